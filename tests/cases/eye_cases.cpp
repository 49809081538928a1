// Families whose eye or near plane comes too close to something.
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "tests/cases/families.h"

namespace culld::cases {
namespace {

/// A box around the origin among other things, and an eye at `point`, moved along `away`.
void eyeAt(CaseBuilder& builder, const glm::dvec3& point, const glm::dvec3& away) {
  builder.made(scenes::Alpha::kOpaque, builder.seed() % 2 != 0);
  builder.add(scenes::box(glm::vec3(-1), glm::vec3(1)));
  addClutter(builder, 60, 10.0);
  LookAt look;
  look.eye = point + away;
  look.up = {0.1, 1.0, 0.2};
  for (const double znear_m : {1e-9, 0.3}) {
    look.znear_m = znear_m;
    for (const glm::dvec3& ahead :
         {glm::dvec3(0, 0, 1), glm::dvec3(1, 0, 0), glm::dvec3(-0.3, -0.2, -1)}) {
      look.target = look.eye + ahead;
      builder.look(look);
    }
  }
}

}  // namespace

void eyeAtSurface(CaseBuilder& builder, double distance) {
  const double x = builder.random().uniform(-0.9, 0.9);
  eyeAt(builder, {x, builder.random().uniform(-0.9, 0.9), 1}, glm::dvec3(0, 0, 1) * distance);
}

void eyeAtEdge(CaseBuilder& builder, double distance) {
  const double x = builder.random().uniform(-0.9, 0.9);
  eyeAt(builder, {x, 1, 1}, glm::dvec3(0, 0.7, 0.7) * distance);
}

void eyeAtVertex(CaseBuilder& builder, double distance) {
  eyeAt(builder, {1, 1, 1}, glm::dvec3(0.6, 0.6, 0.6) * distance);
}

void eyeInside(CaseBuilder& builder, double distance) {
  const double x = builder.random().uniform(-0.9, 0.9);
  eyeAt(builder, {x, builder.random().uniform(-0.9, 0.9), 1}, glm::dvec3(0, 0, -1) * distance);
}

/// The near plane is a metre before the eye, so that things can stand across it.
Sight lookFromANearPlane(CaseBuilder& builder) {
  Sight sight;
  LookAt look;
  look.yfov_rad = 2.0 * std::atan(sight.tan_half);
  look.znear_m = 1.0;
  builder.look(look);
  return sight;
}

/// The near plane cuts a box that stands before everything else.
void boxThroughNear(CaseBuilder& builder, double share_before) {
  Sight sight = lookFromANearPlane(builder);
  builder.made(scenes::Alpha::kOpaque, builder.seed() % 2 != 0);
  const double front = 1.0 - 0.9 * share_before;
  const auto half = static_cast<float>(0.3);
  builder.add(scenes::box({-half, -half, -1}, {half, half, 0}),
              scenes::scaledAndMoved({1, 1, 0.9}, {0, 0, -front}));
  builder.made(scenes::Alpha::kOpaque, false);
  sight.distance_m = 2.2;
  addThings(builder, sight);
}

/// A wall through the middle of the near plane, turned by so much out of it.
void wallThroughNear(CaseBuilder& builder, double angle_deg) {
  Sight sight = lookFromANearPlane(builder);
  const double angle = angle_deg / 180.0 * std::numbers::pi;
  const double c = std::cos(angle), s = std::sin(angle);
  builder.made(scenes::Alpha::kOpaque, builder.seed() % 2 != 0);
  builder.add(scenes::quad({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}),
              {0.8, 0, 0, 0, 0, 0.8 * c, -s, 0, 0, 0.8 * s, c, -1});
  builder.made(scenes::Alpha::kOpaque, false);
  sight.distance_m = 2.2;
  addThings(builder, sight);
}

}  // namespace culld::cases
