// Attacks docs/error-model/motion.md: what lies behind a cell that was drawn for a camera in motion
// must be hidden from every eye within the bound, by a blocking side that the near plane of no pose
// cuts away. Any camera, transform, place and scale; judged in 113-bit arithmetic.
#pragma once
#include <numbers>

#include "culling/raster/moving_view.h"
#include "tests/unit/raster/cell_attack.h"

namespace culld {

inline Vec vecOf(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

/// A turn by `angle` about `axis`, of length 1 up to rounding (Rodrigues).
inline Vec turned(const Vec& v, const Vec& axis, double angle) {
  const Quad c = std::cos(angle), s = std::sin(angle);
  return c * v + s * cross(axis, v) + ((1 - c) * dot(axis, v)) * axis;
}

/// Where something sees from: moved, and turned back by `turn` about `axis`.
struct Pose {
  Vec eye, axis;
  double turn;
  Vec seen(const Vec& p) const { return turned(p - eye, axis, turn); }
};

class MotionAttack : public CellAttack {
 protected:
  void attackSeeds(std::uint64_t most) {
    for (std::uint64_t seed = 1; seed <= most && !HasFatalFailure(); ++seed) {
      SCOPED_TRACE("seed " + std::to_string(seed));
      begin(seed);
      attackMotion();
    }
  }

  void attackMotion() {
    const double reach = chance(3) ? 1e6 : 0.0;
    const double distance = std::exp2(real(-7.0, 7.0));
    const glm::dvec3 eye(real(-reach, reach), real(-reach, reach), real(-reach, reach));
    const glm::dvec3 ahead = glm::normalize(glm::dvec3(real(-0.3, 0.3), real(-0.3, 0.3), -1.0));
    const glm::dvec3 at = eye + distance * ahead;
    Camera camera = chance(2) ? lookAt(eye, at, distance) : matrices(eye, distance);
    const double size = distance * fov_ * std::exp2(real(-2.0, 3.0));
    camera.motion.radius_m = std::min(size, distance) * std::exp2(real(-8.0, -0.5));
    if (chance(3)) camera.motion.angle_rad = std::exp2(real(-8.0, -1.0));
    if (!holdsInMotion(camera)) return;
    const Mesh drawn = mesh();
    const auto m = placed(at, size);
    CellView view = cellView(camera, gridFor(camera));
    if (forget_motion_) view.motion = {};
    DepthCells cells;
    cells.reset(view.grid);
    draw(drawn, m, view, camera.origin_world, cells);
    judgeMotion(camera, view, drawn, m, cells);
  }

  void judgeMotion(const Camera& camera, const CellView& view, const Mesh& mesh,
                   const std::array<double, 12>& m, DepthCells& cells) {
    const std::vector<Vec> corners = cornersOf(mesh, m, camera.origin_world);
    mirrored_ = handedness(m) < 0.0;
    atCoveredCells(cells, 10, [&](std::uint32_t x, std::uint32_t y, float nearness) {
      for (int k = 0; k < 16; ++k) {
        const Quad s = x + (k % 2 == 0 ? Quad(k / 2 % 2) : Quad(real(0.0, 1.0)));
        const Quad t = y + (k % 2 == 0 ? Quad(k / 4 % 2) : Quad(real(0.0, 1.0)));
        const double behind = chance(2) ? 0.0 : chance(2) ? 1e-9 : real(0.0, 30.0);
        const Vec hidden = placeBehind(view, s, t, Quad(nearness), behind);
        const Pose pose = somePose(camera, view, k);
        if (!blocked(camera, mesh, corners, pose, hidden)) {
          ++open_;
          ASSERT_TRUE(forget_motion_) << "cell " << x << ", " << y << ", place " << k;
        }
      }
    });
  }

  Vec placeBehind(const CellView& view, Quad s, Quad t, Quad nearness, double behind) {
    const Row u = rowOf(view.u), v = rowOf(view.v), w = rowOf(view.w), n = rowOf(view.n);
    if (view.perspective) {
      const Vec along = cross(u.linear - s * w.linear, v.linear - t * w.linear);
      return ((1 + Quad(behind)) / (nearness * dot(w.linear, along))) * along;
    }
    // The place of u, v and n by Cramer's rule.
    const Vec vn = cross(v.linear, n.linear), nu = cross(n.linear, u.linear);
    const Vec uv = cross(u.linear, v.linear);
    const Quad det = dot(u.linear, vn);
    return (1 / det) * ((s - u.constant) * vn + (t - v.constant) * nu +
                        (nearness - Quad(behind) - n.constant) * uv);
  }

  /// Within the camera's bound, mostly at its very end, across the view in many directions.
  Pose somePose(const Camera& camera, const CellView& view, int k) {
    const glm::dvec3 side = glm::normalize(glm::dvec3(view.u)),
                     up = glm::normalize(glm::dvec3(view.v));
    const double turn = 0.125 * std::numbers::pi * k;
    glm::dvec3 d = std::cos(turn) * side + std::sin(turn) * up;
    if (chance(3)) d = {real(-1.0, 1.0), real(-1.0, 1.0), real(-1.0, 1.0)};
    const double length = chance(6) ? real(0.0, 1.0) : 1.0 - 0x1p-50;
    const glm::dvec3 axis = glm::normalize(glm::dvec3(real(-1.0, 1.0), real(-1.0, 1.0), 0.01));
    return {vecOf(camera.motion.radius_m * length * glm::normalize(d)), vecOf(axis),
            camera.motion.angle_rad * (chance(2) ? 1.0 : real(0.0, 1.0))};
  }

  static std::vector<Vec> cornersOf(const Mesh& mesh, const std::array<double, 12>& m,
                                    const glm::dvec3& eye) {
    std::vector<Vec> corners;
    const auto row = [&](std::size_t r, const glm::vec3& p, double origin) {
      return Quad(m[4 * r]) * p.x + Quad(m[4 * r + 1]) * p.y + Quad(m[4 * r + 2]) * p.z +
             (Quad(m[4 * r + 3]) - origin);
    };
    for (const glm::vec3& p : mesh.positions) {
      corners.push_back({row(0, p, eye.x), row(1, p, eye.y), row(2, p, eye.z)});
    }
    return corners;
  }

  /// From the pose's eye to `hidden`, a blocking side is met that its near plane does not cut; or
  /// the pose does not look there at all.
  bool blocked(const Camera& camera, const Mesh& mesh, const std::vector<Vec>& corners,
               const Pose& pose, const Vec& hidden) {
    const Vec seen = pose.seen(hidden);
    const Quad w = camera.perspective ? rowOf(camera.w_row).at(seen) : Quad(1);
    const Quad x = rowOf(camera.x_row).at(seen), y = rowOf(camera.y_row).at(seen);
    if (!(w > 0) || x < -w || x > w || y < -w || y > w) return true;
    if (rowOf(camera.near_cut_row).at(seen) < 0 || rowOf(camera.far_cut_row).at(seen) < 0)
      return true;
    // Orthographic: from the plane of the moved eye along the direction of view.
    Vec from = pose.eye;
    if (!camera.perspective) {
      const Vec view_axis = cross(rowOf(camera.x_row).linear, rowOf(camera.y_row).linear);
      const Quad along = dot(rowOf(camera.near_row).linear, view_axis);
      const Quad to_near = (1 - rowOf(camera.near_row).at(seen)) / along;
      from = hidden + to_near * view_axis;
    }
    for (const Surface& surface : mesh.surfaces) {
      for (std::uint32_t i = 0; i < surface.triangle_count; ++i) {
        const auto& t = mesh.triangles[surface.first_triangle + i];
        const std::array<Vec, 3> corner{corners[t[0]], corners[t[1]], corners[t[2]]};
        Vec met;
        if (meets(from, hidden, corner, surface.double_sided, met) &&
            rowOf(camera.near_cut_row).at(pose.seen(met)) >= 0) {
          return true;
        }
      }
    }
    return false;
  }

  bool meets(const Vec& from, const Vec& to, const std::array<Vec, 3>& corner, bool double_sided,
             Vec& met) const {
    const Vec along = to - from, a = corner[0] - from, b = corner[1] - from, c = corner[2] - from;
    const Quad va = dot(along, cross(b, c)), vb = dot(along, cross(c, a));
    const Quad vc = dot(along, cross(a, b)), volume = va + vb + vc;
    if (volume == 0) return false;
    constexpr double kCommonEdge = 1e-25;  // of two triangles, a segment meets one at least
    if (std::min({va / volume, vb / volume, vc / volume}) < Quad(-kCommonEdge)) return false;
    const Vec normal = cross(corner[1] - corner[0], corner[2] - corner[0]);
    const bool front = (dot(normal, along) < 0) != mirrored_;
    if (!front && !double_sided) return false;
    const Vec p = (va / volume) * a + (vb / volume) * b + (vc / volume) * c;
    const Quad part = dot(p, along) / dot(along, along);
    met = from + p;
    return part > 0 && part <= 1;
  }

  bool forget_motion_ = false, mirrored_ = false;
  std::size_t open_ = 0;
};

}  // namespace culld
