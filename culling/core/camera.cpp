#include "culling/core/camera.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <numbers>
#include <string>

namespace culld {
namespace {

bool finite(const glm::dvec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}
bool finite(const glm::dvec4& v) { return finite(glm::dvec3(v)) && std::isfinite(v.w); }
bool finite(const glm::dmat4& m) {
  return finite(m[0]) && finite(m[1]) && finite(m[2]) && finite(m[3]);
}

/// Largest absolute entry of a row's linear part.
double scaleOf(const glm::dvec4& row) {
  return std::max({std::abs(row.x), std::abs(row.y), std::abs(row.z)});
}

/// Solves dot(a, x) = ra, dot(b, x) = rb, dot(c, x) = rc by Cramer's rule on rows scaled to 1.
/// False if the rows are (nearly) linearly dependent.
bool solveRows(glm::dvec4 a, glm::dvec4 b, glm::dvec4 c, glm::dvec3 rhs, glm::dvec3& x) {
  glm::dvec4* rows[3] = {&a, &b, &c};
  for (int i = 0; i < 3; ++i) {
    const double s = scaleOf(*rows[i]);
    if (!(s > 0.0)) return false;
    *rows[i] /= s;
    rhs[i] /= s;
  }
  const glm::dvec3 ra(a), rb(b), rc(c);
  const glm::dvec3 bc = glm::cross(rb, rc), ca = glm::cross(rc, ra), ab = glm::cross(ra, rb);
  const double det = glm::dot(ra, bc);
  if (!(std::abs(det) > 1e-14)) return false;
  x = (rhs.x * bc + rhs.y * ca + rhs.z * ab) / det;
  return finite(x);
}

/// Unit length, also where the square of the length would underflow or overflow.
/// REQUIRES: finite and not zero.
glm::dvec3 direction(const glm::dvec3& v) {
  const glm::dvec3 scaled = v / std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
  return scaled / glm::length(scaled);
}

Error bad(const std::string& what) { return invalidInput("camera: " + what); }

Result<void> checkImageAndMotion(ImageSize image, MotionBound motion) {
  if (image.width_px == 0 || image.height_px == 0) return bad("image size is zero");
  if (image.width_px > kMaxImageSide || image.height_px > kMaxImageSide) {
    return bad("image side > " + std::to_string(kMaxImageSide));
  }
  if (!std::isfinite(motion.radius_m) || motion.radius_m < 0.0) {
    return bad("motion radius is not a finite number >= 0");
  }
  if (!std::isfinite(motion.angle_rad) || motion.angle_rad < 0.0) {
    return bad("motion angle is not a finite number >= 0");
  }
  return Done{};
}

Result<Camera> finished(Camera camera) {
  if (!finite(camera.origin_world)) return bad("eye is not finite");
  for (const glm::dvec4* row : {&camera.x_row, &camera.y_row, &camera.z_row, &camera.w_row,
                                &camera.near_cut_row, &camera.far_cut_row}) {
    if (!finite(*row)) return bad("matrix product is not finite");
  }
  return camera;
}

/// w + sign * z on world coordinates, added in the projection, before anything can cancel.
glm::dvec4 cutRow(const glm::dmat4& view, const glm::dmat4& projection, double sign) {
  const glm::dmat4 p = glm::transpose(projection);
  return glm::transpose(view) * (p[3] + sign * p[2]);
}

/// A client turns its camera about the view's origin; the engine about origin_world, which may be
/// elsewhere (orthographic, sheared). Turning about another point moves the camera as well.
Camera aboutItsEye(Camera camera, const glm::dmat4& view) {
  if (camera.motion.angle_rad == 0.0) return camera;
  const glm::dvec3 eye(glm::inverse(view)[3]);
  const double lever = glm::length(camera.origin_world - eye);
  const double angle = std::min(camera.motion.angle_rad, std::numbers::pi);
  camera.motion.radius_m += 2.0 * std::sin(angle / 2.0) * lever * (1.0 + 1e-9);
  return camera;
}

}  // namespace

Result<Camera> cameraFromLookAt(const LookAt& look, ImageSize image, MotionBound motion) {
  if (auto ok = checkImageAndMotion(image, motion); !ok) return std::move(ok).error();
  if (!finite(look.eye)) return bad("eye is not finite");
  if (!finite(look.target)) return bad("target is not finite");
  if (!finite(look.up)) return bad("up is not finite");
  if (!(look.yfov_rad > 0.0 && look.yfov_rad < std::numbers::pi)) {
    return bad("yfov is not within (0, pi)");
  }
  if (!(look.aspect > 0.0) || !std::isfinite(look.aspect)) return bad("aspect is not > 0");
  if (!(look.znear_m > 0.0) || !std::isfinite(look.znear_m)) return bad("znear is not > 0");
  if (look.zfar_m && !(*look.zfar_m > look.znear_m && std::isfinite(*look.zfar_m))) {
    return bad("zfar is not a finite number > znear (null means infinite)");
  }
  const glm::dvec3 ahead = look.target - look.eye;
  if (!finite(ahead) || ahead == glm::dvec3(0.0)) return bad("target equals eye");
  if (look.up == glm::dvec3(0.0)) return bad("up is zero");
  const glm::dvec3 forward = direction(ahead);
  const glm::dvec3 rough_side = glm::cross(forward, direction(look.up));
  if (!(glm::length(rough_side) > 1e-12)) return bad("up is parallel to the direction of view");
  const glm::dvec3 rough_up = direction(glm::cross(rough_side, forward));
  // Where up is nearly parallel to the view, the first cross product is mostly rounding; this is
  // not.
  const glm::dvec3 side = direction(glm::cross(forward, rough_up));
  const glm::dvec3 up = glm::cross(side, forward);

  const double focal = 1.0 / std::tan(look.yfov_rad / 2.0);
  const double near = look.znear_m;
  // Depth rows as in glFrustum; an infinite far plane is their limit.
  const double depth_scale = look.zfar_m ? (*look.zfar_m + near) / (*look.zfar_m - near) : 1.0;
  const double depth_shift =
      look.zfar_m ? 2.0 * *look.zfar_m * near / (*look.zfar_m - near) : 2.0 * near;
  Camera camera;
  camera.origin_world = look.eye;
  camera.x_row = glm::dvec4(side * (focal / look.aspect), 0.0);
  camera.y_row = glm::dvec4(up * focal, 0.0);
  camera.z_row = glm::dvec4(forward * depth_scale, -depth_shift);
  camera.w_row = glm::dvec4(forward, 0.0);
  camera.near_cut_row = glm::dvec4(forward, -near);
  camera.far_cut_row = look.zfar_m ? glm::dvec4(-forward, *look.zfar_m) : glm::dvec4(0, 0, 0, 1);
  camera.near_row = {0.0, 0.0, 0.0, 1.0};
  camera.width_px = image.width_px;
  camera.height_px = image.height_px;
  camera.motion = motion;
  return finished(camera);
}

Result<Camera> cameraFromMatrices(const glm::dmat4& view, const glm::dmat4& projection,
                                  ImageSize image, MotionBound motion) {
  if (auto ok = checkImageAndMotion(image, motion); !ok) return std::move(ok).error();
  if (!finite(view)) return bad("view matrix is not finite");
  if (!finite(projection)) return bad("projection matrix is not finite");
  // A scaled or projective view would make every w below wrong; a last 1 may carry rounding dust.
  for (int column = 0; column < 4; ++column) {
    const double wanted = column == 3 ? 1.0 : 0.0;
    if (!(std::abs(view[column][3] - wanted) <= 1e-15)) {
      return bad("last row of the view matrix is not 0 0 0 1");
    }
  }
  const glm::dmat4 rows = glm::transpose(projection * view);  // rows[i] is row i of clip-from-world
  if (!finite(rows)) return bad("matrix product is not finite");
  Camera camera;
  camera.width_px = image.width_px;
  camera.height_px = image.height_px;
  camera.motion = motion;

  const auto atOrigin = [&camera](const glm::dvec4& row) {
    return glm::dvec4(glm::dvec3(row), glm::dot(glm::dvec3(row), camera.origin_world) + row.w);
  };
  // w_row may carry rounding dust of the product in an orthographic camera; the projection tells.
  camera.perspective =
      projection[0][3] != 0.0 || projection[1][3] != 0.0 || projection[2][3] != 0.0;
  if (camera.perspective) {
    // The eye is where x = y = w = 0: true for off-centre and oblique projections as well.
    const glm::dvec3 rhs(-rows[0].w, -rows[1].w, -rows[3].w);
    if (!solveRows(rows[0], rows[1], rows[3], rhs, camera.origin_world)) {
      return bad("view or projection matrix is singular");
    }
    camera.x_row = glm::dvec4(glm::dvec3(rows[0]), 0.0);
    camera.y_row = glm::dvec4(glm::dvec3(rows[1]), 0.0);
    camera.w_row = glm::dvec4(glm::dvec3(rows[3]), 0.0);
    camera.z_row = atOrigin(rows[2]);
    camera.near_cut_row = atOrigin(cutRow(view, projection, 1.0));
    camera.far_cut_row = atOrigin(cutRow(view, projection, -1.0));
    camera.near_row = {0.0, 0.0, 0.0, 1.0};
    if (scaleOf(camera.z_row) == 0.0 && camera.z_row.w == 0.0) return bad("depth row is zero");
    return finished(aboutItsEye(camera, view));
  }
  const double w = projection[3][3];
  if (!(w > 0.0)) return bad("projection matrix is singular: w is not positive");
  // Which side is near: the camera looks down -z of its view space, whatever the depth convention.
  const bool reversed = projection[2][2] > 0.0;
  const glm::dvec3 near_centre(-rows[0].w, -rows[1].w, (reversed ? w : -w) - rows[2].w);
  if (!solveRows(rows[0], rows[1], rows[2], near_centre, camera.origin_world)) {
    return bad("view or projection matrix is singular");
  }
  camera.x_row = atOrigin(rows[0]) / w;
  camera.y_row = atOrigin(rows[1]) / w;
  camera.z_row = atOrigin(rows[2]) / w;
  camera.w_row = {0.0, 0.0, 0.0, 1.0};
  camera.near_cut_row = atOrigin(cutRow(view, projection, 1.0)) / w;
  camera.far_cut_row = atOrigin(cutRow(view, projection, -1.0)) / w;
  // 1 at the near plane, 0 at the far plane.
  camera.near_row = (reversed ? 0.5 : -0.5) * camera.z_row + glm::dvec4(0.0, 0.0, 0.0, 0.5);
  return finished(aboutItsEye(camera, view));
}

}  // namespace culld
