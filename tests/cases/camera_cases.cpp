// Families whose camera is pushed: angle, image, depth range, projection.
#include <array>
#include <cmath>
#include <glm/mat4x4.hpp>
#include <limits>
#include <numbers>
#include <optional>

#include "tests/cases/families.h"

namespace culld::cases {
namespace {

constexpr double kAspect = 16.0 / 9.0;
constexpr double kNear = 1e-3;

/// As glFrustum makes it for a symmetric view; an infinite far plane is its limit.
glm::dmat4 perspective(double tan_half, double near, std::optional<double> far) {
  glm::dmat4 p(0.0);
  p[0][0] = 1.0 / (tan_half * kAspect);
  p[1][1] = 1.0 / tan_half;
  p[2][2] = far ? -(*far + near) / (*far - near) : -1.0;
  p[2][3] = -1.0;
  p[3][2] = far ? -2.0 * *far * near / (*far - near) : -2.0 * near;
  return p;
}

/// Somewhere in the depth range, another place for every seed.
double withinRange(CaseBuilder& builder, double far_over_near) {
  const double usable = std::min(far_over_near, 1e15);
  return kNear * std::pow(usable, builder.random().uniform(0.2, 0.8));
}

std::optional<double> farOf(double ratio) {
  return std::isfinite(ratio) ? std::optional(kNear * ratio) : std::nullopt;
}

}  // namespace

Sight fieldOfView(CaseBuilder& builder, double yfov_deg) {
  LookAt look;
  look.yfov_rad = yfov_deg / 180.0 * std::numbers::pi;
  builder.look(look);
  Sight sight;
  sight.tan_half = std::tan(look.yfov_rad / 2.0);
  return sight;
}

Sight imageSide(CaseBuilder& builder, double side_px) {
  LookAt look;
  look.aspect = 1.0;
  const auto side = static_cast<std::uint32_t>(side_px);
  builder.look(look, {side, side}, "square image");
  Sight sight;
  sight.tan_half = std::tan(look.yfov_rad / 2.0);
  return sight;
}

Sight imageWidth(CaseBuilder& builder, double width_px) {
  LookAt look;
  builder.look(look, {static_cast<std::uint32_t>(width_px), 2}, "strip");
  Sight sight;
  sight.tan_half = std::tan(look.yfov_rad / 2.0);
  return sight;
}

Sight farOverNear(CaseBuilder& builder, double ratio) {
  LookAt look;
  look.znear_m = kNear;
  look.zfar_m = farOf(ratio);
  builder.look(look);
  Sight sight;
  sight.tan_half = std::tan(look.yfov_rad / 2.0);
  sight.distance_m = withinRange(builder, ratio);
  return sight;
}

Sight farOverNearMatrices(CaseBuilder& builder, double ratio) {
  Sight sight;
  sight.distance_m = withinRange(builder, ratio);
  const glm::dmat4 usual = perspective(sight.tan_half, kNear, farOf(ratio));
  builder.matrices(glm::dmat4(1.0), usual, kCaseImage, "depth as in OpenGL");
  glm::dmat4 reversed = usual;
  reversed[2][2] = -reversed[2][2];
  reversed[3][2] = -reversed[3][2];
  builder.matrices(glm::dmat4(1.0), reversed, kCaseImage, "reversed depth");
  return sight;
}

Sight offCentre(CaseBuilder& builder, double shift) {
  Sight sight;
  glm::dmat4 p = perspective(sight.tan_half, 0.1, 1e6);
  p[2][0] = shift;
  p[2][1] = -shift / 2.0;
  sight.slope = {shift / p[0][0], -shift / 2.0 / p[1][1]};
  builder.matrices(glm::dmat4(1.0), p, kCaseImage, "off-centre");
  return sight;
}

Sight obliqueNear(CaseBuilder& builder, double tilt) {
  Sight sight;
  glm::dmat4 p = perspective(sight.tan_half, 0.1, 1e3);
  // Lengyel: the third row becomes the plane, scaled so that the far corner stays in.
  const glm::dvec4 plane{-tilt, 0.0, -1.0, -1.0};
  const glm::dvec4 corner((std::copysign(1.0, plane.x) + p[2][0]) / p[0][0], 1.0 / p[1][1], -1.0,
                          (1.0 + p[2][2]) / p[3][2]);
  const double scale = 2.0 / glm::dot(plane, corner);
  for (int column = 0; column < 4; ++column) p[column][2] = plane[column] * scale - p[column][3];
  builder.matrices(glm::dmat4(1.0), p, kCaseImage, "oblique");
  return sight;
}

Sight orthographicDepth(CaseBuilder& builder, double range_over_distance) {
  Sight sight;
  sight.parallel = true;
  sight.tan_half = 5.0;
  glm::dmat4 p(1.0);
  p[0][0] = 1.0 / (kAspect * sight.tan_half);
  p[1][1] = 1.0 / sight.tan_half;
  p[2][2] = -2.0 / (range_over_distance * sight.distance_m);
  p[3][2] = -1.0;
  builder.matrices(glm::dmat4(1.0), p, kCaseImage, "orthographic");
  return sight;
}

Sight mirroredView(CaseBuilder& builder, double x_scale) {
  Sight sight;
  glm::dmat4 view(1.0);
  view[0][0] = x_scale;
  builder.matrices(view, perspective(sight.tan_half, 0.1, std::nullopt), kCaseImage,
                   x_scale < 0 ? "mirrored" : "squeezed");
  return sight;
}

void badCameras(CaseBuilder& builder, double number) {
  addClutter(builder, 20, 10.0);
  LookAt look;
  builder.look(look);
  glm::dmat4 view(1.0), projection = perspective(0.5, 0.1, 1e3);
  builder.matrices(view, projection);
  constexpr double kInf = std::numeric_limits<double>::infinity();
  const auto which = static_cast<int>(number);
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), kInf, -kInf}) {
    double znear_far[2] = {look.znear_m, 100.0};
    LookAt broken = look;
    const std::array<double*, 13> numbers{
        &broken.eye.x,    &broken.eye.y, &broken.eye.z, &broken.target.x, &broken.target.y,
        &broken.target.z, &broken.up.x,  &broken.up.y,  &broken.up.z,     &broken.yfov_rad,
        &broken.aspect,   &znear_far[0], &znear_far[1]};
    *numbers[static_cast<std::size_t>(which % 13)] = bad;
    broken.znear_m = znear_far[0];
    broken.zfar_m = znear_far[1];
    builder.refuses({broken, kCaseImage, "look-at that is not a number"});
    glm::dmat4 broken_view = view, broken_projection = projection;
    (which % 32 < 16 ? broken_view : broken_projection)[which % 16 / 4][which % 4] = bad;
    builder.refuses({scenes::ViewProjection{broken_view, broken_projection}, kCaseImage,
                     "matrix that is not a number"});
  }
}

}  // namespace culld::cases
