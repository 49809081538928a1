// A camera as the engine uses it: everything relative to its own origin, in double precision, so
// that a centimetre at 6.4e6 m from the world's origin is still a centimetre (docs/error-model.md
// §2). OpenGL conventions: clip space with -w <= x, y, z <= w, the camera looks down -z of its view
// space.
#pragma once
#include <array>
#include <cstdint>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <optional>

#include "culling/core/result.h"

namespace culld {

/// Every pose within `radius_m` of the eye and `angle_rad` of the orientation is promised the
/// answer.
struct MotionBound {
  double radius_m = 0.0;
  double angle_rad = 0.0;
  bool still() const noexcept { return radius_m == 0.0 && angle_rad == 0.0; }
};

/// REQUIRES of users: made by one of the functions below, which check it; then every number is
/// finite.
struct Camera {
  glm::dvec3 origin_world{0.0};  ///< the eye; for an orthographic camera a point of the near plane
  /// Clip coordinates are rows applied to (p_world - origin_world, 1).
  /// For a perspective camera x_row.w == y_row.w == w_row.w == 0 exactly: the eye is the origin.
  glm::dvec4 x_row{0.0}, y_row{0.0}, z_row{0.0}, w_row{0.0};
  /// >= 0 where a point is not cut off by the near (z >= -w) and far (z <= w) clip planes. Not
  /// w_row +- z_row: that difference cancels to rounding dust when far / near is large, and moves
  /// the plane.
  glm::dvec4 near_cut_row{0.0}, far_cut_row{0.0};
  /// nearness(p) = dot(near_row, p) / dot(w_row, p): affine over the image on any plane, larger is
  /// nearer to the eye, > 0 inside the frustum. Perspective: 1/w. Orthographic: 1 at near, 0 at
  /// far.
  glm::dvec4 near_row{0.0};
  bool perspective = true;
  std::uint32_t width_px = 1280;
  std::uint32_t height_px = 720;
  MotionBound motion;
};

struct LookAt {
  glm::dvec3 eye{0.0}, target{0.0, 0.0, -1.0}, up{0.0, 1.0, 0.0};
  double yfov_rad = 1.0;
  double aspect = 16.0 / 9.0;
  double znear_m = 0.1;
  std::optional<double> zfar_m;  ///< none: infinite
};

struct ImageSize {
  std::uint32_t width_px = 1280;
  std::uint32_t height_px = 720;
};

inline constexpr std::uint32_t kMaxImageSide = 65536;

/// ERROR: kInvalidInput naming the field: NaN, zero-sized image, yfov outside (0, pi), near <= 0,
/// ...
Result<Camera> cameraFromLookAt(const LookAt& look, ImageSize image, MotionBound motion = {});

/// `view` maps world to view space, `projection` view to clip space, both column-major.
/// Perspective (finite or infinite far, reversed depth, off-centre, oblique) or orthographic.
/// ERROR: kInvalidInput: not finite, singular, zero-sized image.
Result<Camera> cameraFromMatrices(const glm::dmat4& view, const glm::dmat4& projection,
                                  ImageSize image, MotionBound motion = {});

}  // namespace culld
