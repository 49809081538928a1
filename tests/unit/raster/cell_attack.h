// Attacks the cell rule of docs/error-model.md §3 from end to end: every ray through a cell that a
// drawn object covers must meet a blocking side of it, between the clip planes and at least as near
// as the cell says. Any camera, transform, place and scale; judged in 113-bit arithmetic.
#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <random>
#include <string>

#include "culling/raster/depth_cells.h"
#include "culling/raster/object_rows.h"
#include "culling/scene/scene_builder.h"
#include "tests/scenes/shapes.h"

namespace culld {

__extension__ typedef __float128 Quad;

struct Vec {
  Quad x, y, z;
};
inline Vec operator-(const Vec& a, const Vec& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec operator+(const Vec& a, const Vec& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec operator*(Quad s, const Vec& v) { return {s * v.x, s * v.y, s * v.z}; }
inline Quad dot(const Vec& a, const Vec& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec cross(const Vec& a, const Vec& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// A row of the camera, exactly.
struct Row {
  Vec linear;
  Quad constant;
  Quad at(const Vec& p) const { return dot(linear, p) + constant; }
};
inline Row rowOf(const glm::dvec4& r) { return {{r.x, r.y, r.z}, r.w}; }
inline Row scaled(const Row& a, const Row& b, Quad s) {
  return {s * (a.linear + b.linear), s * (a.constant + b.constant)};
}

/// A line through one place of the image.
struct Line {
  Vec origin, direction;
};

/// The true rays and depths of a camera's cells.
class TrueView {
 public:
  TrueView(const Camera& camera, const CellGrid& grid)
      : perspective_(camera.perspective),
        w_(rowOf(camera.w_row)),
        u_(scaled(rowOf(camera.x_row), w_, Quad(grid.width) / 2)),
        v_(scaled(rowOf(camera.y_row), w_, Quad(grid.height) / 2)),
        near_(rowOf(camera.near_row)),
        near_cut_(rowOf(camera.near_cut_row)),
        far_cut_(rowOf(camera.far_cut_row)),
        metres_(camera.perspective ? 1.0 / glm::length(glm::dvec3(camera.w_row)) : 1.0) {}

  Line through(Quad s, Quad t) const {
    if (perspective_) {
      const Vec along = cross(u_.linear - s * w_.linear, v_.linear - t * w_.linear);
      return {{0, 0, 0}, dot(w_.linear, along) < 0 ? Quad(-1) * along : along};
    }
    // The point a * u + b * v of the plane that the two rows span.
    const Quad uu = dot(u_.linear, u_.linear), uv = dot(u_.linear, v_.linear);
    const Quad vv = dot(v_.linear, v_.linear);
    const Quad su = s - u_.constant, sv = t - v_.constant, det = uu * vv - uv * uv;
    const Quad a = (su * vv - sv * uv) / det, b = (sv * uu - su * uv) / det;
    const Vec along = cross(u_.linear, v_.linear);
    return {a * u_.linear + b * v_.linear, dot(near_.linear, along) > 0 ? Quad(-1) * along : along};
  }
  bool betweenClipPlanes(const Vec& p) const {
    return (!perspective_ || w_.at(p) > 0) && near_cut_.at(p) >= 0 && far_cut_.at(p) >= 0;
  }
  /// Where a point lies on the image, in cells. REQUIRES: it is not in the eye's plane.
  Quad column(const Vec& p) const { return u_.at(p) / w_.at(p); }
  Quad row(const Vec& p) const { return v_.at(p) / w_.at(p); }
  Quad nearness(const Vec& p) const { return near_.at(p) / (w_.at(p) * metres_); }

 private:
  bool perspective_;
  Row w_, u_, v_, near_, near_cut_, far_cut_;
  Quad metres_;
};

/// The object's triangles where they truly are, relative to the eye.
class TrueObject {
 public:
  TrueObject(const Mesh& mesh, const std::array<double, 12>& m, const glm::dvec3& eye)
      : mesh_(mesh) {
    const auto row = [&](std::size_t r, const glm::vec3& p, double origin) {
      return Quad(m[4 * r]) * p.x + Quad(m[4 * r + 1]) * p.y + Quad(m[4 * r + 2]) * p.z +
             (Quad(m[4 * r + 3]) - origin);
    };
    for (const glm::vec3& p : mesh.positions) {
      corners_.push_back({row(0, p, eye.x), row(1, p, eye.y), row(2, p, eye.z)});
    }
    const Vec a{m[0], m[1], m[2]}, b{m[4], m[5], m[6]}, c{m[8], m[9], m[10]};
    mirrored_ = dot(a, cross(b, c)) < 0;
  }

  std::array<Vec, 3> triangle(std::uint32_t t) const {
    const auto& corner = mesh_.triangles[t];
    return {corners_[corner[0]], corners_[corner[1]], corners_[corner[2]]};
  }
  /// Does the triangle turn its front against the line's direction?
  bool front(const std::array<Vec, 3>& corner, const Line& line) const {
    const Vec normal = cross(corner[1] - corner[0], corner[2] - corner[0]);
    return (dot(normal, line.direction) < 0) != mirrored_;
  }

  /// Nearness of the nearest blocking surface on the line; negative if there is none.
  Quad blockedAt(const TrueView& view, const Line& line) const {
    Quad nearest = -1;
    for (const Surface& surface : mesh_.surfaces) {
      for (std::uint32_t i = 0; surface.blocks && i < surface.triangle_count; ++i) {
        const auto& t = mesh_.triangles[surface.first_triangle + i];
        meet(view, line, {corners_[t[0]], corners_[t[1]], corners_[t[2]]}, surface.double_sided,
             nearest);
      }
    }
    return nearest;
  }

 private:
  void meet(const TrueView& view, const Line& line, const std::array<Vec, 3>& corner,
            bool double_sided, Quad& nearest) const {
    const Vec a = corner[0] - line.origin, b = corner[1] - line.origin, c = corner[2] - line.origin;
    const Quad va = dot(line.direction, cross(b, c)), vb = dot(line.direction, cross(c, a));
    const Quad vc = dot(line.direction, cross(a, b)), volume = va + vb + vc;
    if (volume == 0) return;
    constexpr double kCommonEdge = 1e-25;  // of two triangles, a ray meets one at least
    if (std::min({va / volume, vb / volume, vc / volume}) < Quad(-kCommonEdge)) return;
    if (!double_sided && !front(corner, line)) return;
    const Vec p = line.origin + (va / volume) * a + (vb / volume) * b + (vc / volume) * c;
    if (view.betweenClipPlanes(p)) nearest = std::max(nearest, view.nearness(p));
  }

  const Mesh& mesh_;
  std::vector<Vec> corners_;
  bool mirrored_ = false;
};

class CellAttack : public testing::Test {
 protected:
  void begin(std::uint64_t seed) { random_.seed(seed); }
  double real(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  bool chance(unsigned one_in) { return random_() % one_in == 0; }

  /// Draws the object into cells that know nothing yet.
  virtual void draw(const Mesh& mesh, const std::array<double, 12>& world_from_mesh,
                    const CellView& view, const glm::dvec3& eye, DepthCells& cells) = 0;

  virtual Mesh mesh() {
    scenes::Random shapes(random_());
    scenes::Triangles t;
    switch (random_() % 5) {
      case 0:
        t = scenes::ball(4, chance(2) ? 0.0 : 0.4, shapes);
        break;
      case 1:
        t = scenes::torus(7, 4, 0.8F, 0.25F);
        break;
      case 2:
        t = scenes::bumpySheet(4, chance(2) ? 0.0 : 0.5, shapes);
        break;
      case 3:
        t = scenes::wallWithHole({0.1F, -0.2F}, glm::vec2(static_cast<float>(real(1e-5, 0.3))));
        break;
      default:
        t = scenes::box(glm::vec3(-1), glm::vec3(1));
    }
    return makeMesh({{t.positions, t.indices, true, chance(3)}});
  }

  /// Any linear map, of about `size`; mirrored, sheared, now and then nearly flat.
  std::array<double, 12> placed(const glm::dvec3& at, double size) {
    std::array<double, 12> m{};
    for (std::size_t r = 0; r < 3; ++r) {
      for (std::size_t c = 0; c < 3; ++c) m[4 * r + c] = size * real(-1.0, 1.0);
      m[4 * r + 3] = at[static_cast<int>(r)];
    }
    const double thin = chance(6) ? std::exp2(real(-50.0, -5.0)) : 1.0;
    for (std::size_t r = 0; r < 3; ++r) m[4 * r + 2] *= thin;
    if (chance(6)) {  // flat up to rounding: which side is the front hangs on the last bits
      for (std::size_t r = 0; r < 3; ++r) m[4 * r + 2] = 0.7 * m[4 * r] - 0.3 * m[4 * r + 1];
    }
    return m;
  }

  Camera lookAt(const glm::dvec3& eye, const glm::dvec3& target, double distance) {
    LookAt look;
    look.eye = eye;
    look.target = target;
    look.up = {0.1, 1.0, 0.2};
    look.yfov_rad = chance(3) ? std::exp2(real(-12.0, 1.5)) : 1.0;
    look.znear_m = distance * (chance(3) ? real(0.3, 1.2) : 1e-3);
    if (chance(3)) look.zfar_m = look.znear_m + distance * real(0.1, 3.0);
    fov_ = look.yfov_rad;
    return cameraFromLookAt(look, {320, 180}).value();
  }

  /// Orthographic or off-centre, sometimes mirrored, looking down -z.
  Camera matrices(const glm::dvec3& eye, double distance) {
    glm::dmat4 view(1.0), projection(1.0);
    const double mirror = chance(3) ? -1.0 : 1.0;
    view[0][0] = mirror;
    view[3] = {-mirror * eye.x, -eye.y, -eye.z, 1.0};
    fov_ = 1.0;
    const double near = distance * (chance(3) ? real(0.3, 1.2) : 1e-3);
    const double far = near + distance * real(0.5, 30.0);
    if (chance(2)) {
      projection[0][0] = projection[1][1] = 1.0 / (distance * std::exp2(real(-8.0, 1.0)));
      projection[2][2] = -2.0 / (far - near);
      projection[3] = {real(-0.3, 0.3), real(-0.3, 0.3), -(far + near) / (far - near), 1.0};
      fov_ = 2.0 / (projection[1][1] * distance);
    } else {
      projection[3][3] = 0.0;
      projection[2] = {real(-1.0, 1.0), real(-1.0, 1.0), -(far + near) / (far - near), -1.0};
      projection[3][2] = -2.0 * far * near / (far - near);
    }
    return cameraFromMatrices(view, projection, {320, 180}).value();
  }

  void attackOnce() {
    const double reach = chance(3) ? 1e7 : chance(2) ? 1e3 : 0.0;
    const double distance = std::exp2(real(-7.0, 7.0));
    const glm::dvec3 eye(real(-reach, reach), real(-reach, reach), real(-reach, reach));
    const glm::dvec3 ahead = glm::normalize(glm::dvec3(real(-0.3, 0.3), real(-0.3, 0.3), -1.0));
    const glm::dvec3 at = eye + distance * ahead;
    const Camera camera = chance(2) ? lookAt(eye, at, distance) : matrices(eye, distance);
    const Mesh drawn = mesh();
    const auto m = placed(at, distance * fov_ * std::exp2(real(-2.0, 3.0)));
    drawAndJudge(drawn, m, camera);
  }

  /// Mesh coordinates near 2^23 that the translation takes back, and a telescope on an edge: what
  /// rounding does to a vertex is as large as a cell.
  void attackCancellation() {
    const float base = 0x1p22F;
    scenes::Triangles t = scenes::box(glm::vec3(base), glm::vec3(base + 4.0F));
    const Mesh drawn = makeMesh({{t.positions, t.indices, true, chance(3)}});
    const glm::dvec3 eye(real(-1e3, 1e3), real(-1e3, 1e3), real(-1e3, 1e3));
    std::array<double, 12> m = placed(eye + glm::dvec3(0, 0, -30), 1.0);
    for (std::size_t r = 0; r < 3; ++r) {
      for (std::size_t c = 0; c < 3; ++c) m[4 * r + 3] -= m[4 * r + c] * double{base};
    }
    const auto& edge = drawn.triangles[random_() % drawn.triangles.size()];
    const double along = real(0.0, 1.0);
    const glm::dvec3 p = (1.0 - along) * glm::dvec3(drawn.positions[edge[0]]) +
                         along * glm::dvec3(drawn.positions[edge[1]]);
    LookAt look;
    look.eye = eye;
    for (int r = 0; r < 3; ++r) {
      const double* row = &m[static_cast<std::size_t>(4 * r)];
      look.target[r] = row[0] * p.x + row[1] * p.y + row[2] * p.z + row[3];
    }
    look.up = {0.1, 1.0, 0.2};
    look.yfov_rad = std::exp2(real(-20.5, -18.0));
    drawAndJudge(drawn, m, cameraFromLookAt(look, {320, 180}).value());
  }

  /// What outlineOf() asks for. `wanted` is 0 if no side surely turns to the eye.
  struct Placed {
    int wanted;
    ObjectRows rows;
  };
  static Placed placedIn(const CellView& view, const Mesh& mesh,
                         const std::array<double, 12>& world_from_mesh, const glm::dvec3& eye) {
    const glm::dvec3 largest = glm::max(glm::abs(mesh.bounds.min), glm::abs(mesh.bounds.max));
    return {static_cast<int>(view.front_sign * handedness(world_from_mesh)),
            objectRows(view, world_from_mesh, eye, largest)};
  }

  virtual void drawAndJudge(const Mesh& drawn, const std::array<double, 12>& m,
                            const Camera& camera) {
    const CellView view = cellView(camera, gridFor(camera));
    DepthCells cells;
    cells.reset(view.grid);
    draw(drawn, m, view, camera.origin_world, cells);
    judge(TrueView(camera, view.grid), TrueObject(drawn, m, camera.origin_world), cells);
  }

  float nearnessOf(DepthCells& cells, std::uint32_t x, std::uint32_t y) {
    const std::uint32_t block = cells.grid().blockAt(x / 8, y / 8);
    const float least = cells.leastNearness(block);
    if (!cells.used(block)) return least;
    return std::max(least, cells.cells(block)[y % 8 * 8 + x % 8]);
  }

  /// Calls look(x, y, nearness) for so many covered cells, mostly at the rim of what is covered,
  /// where a wrong margin shows first; until one fails.
  template <typename Look>
  void atCoveredCells(DepthCells& cells, int most, const Look& look) {
    const CellGrid& grid = cells.grid();
    for (int i = 0, tries = 0; i < most && tries < 600 && !HasFatalFailure(); ++tries) {
      const auto x = static_cast<std::uint32_t>(random_() % grid.width);
      const auto y = static_cast<std::uint32_t>(random_() % grid.height);
      const float nearness = nearnessOf(cells, x, y);
      if (!(nearness > 0.0F)) continue;
      const bool inner = x > 0 && y > 0 && x + 1 < grid.width && y + 1 < grid.height &&
                         nearnessOf(cells, x - 1, y) > 0.0F && nearnessOf(cells, x + 1, y) > 0.0F &&
                         nearnessOf(cells, x, y - 1) > 0.0F && nearnessOf(cells, x, y + 1) > 0.0F;
      if (inner && !chance(10)) continue;
      ++i;
      ++cells_;
      look(x, y, nearness);
    }
  }

  void judge(const TrueView& view, const TrueObject& object, DepthCells& cells) {
    atCoveredCells(cells, 12, [&](std::uint32_t x, std::uint32_t y, float nearness) {
      for (int k = 0; k < 8; ++k) {
        const int right = k % 2, up = k / 2;  // the four corners first
        const Quad s = x + (k < 4 ? Quad(right) : Quad(real(0.0, 1.0)));
        const Quad t = y + (k < 4 ? Quad(up) : Quad(real(0.0, 1.0)));
        ASSERT_GE(object.blockedAt(view, view.through(s, t)), Quad(nearness))
            << "cell " << x << ", " << y << ", place " << k;
      }
    });
  }

  double fov_ = 1.0;
  std::size_t cells_ = 0;

  std::mt19937_64 random_;
};

}  // namespace culld
