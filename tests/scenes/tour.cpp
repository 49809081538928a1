#include "tests/scenes/tour.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <utility>

namespace culld::scenes {
namespace {

/// [5 %, 95 %] of the middles along one axis, as {low, high}. REQUIRES: there are some.
std::pair<double, double> middleRange(std::vector<double> middles) {
  std::sort(middles.begin(), middles.end());
  const std::size_t last = middles.size() - 1;
  return {middles[last / 20], middles[last - last / 20]};
}

Box crowdedPart(const SceneSnapshot& scene) {
  std::vector<double> x, y, z, reach;
  for (ObjectId id = 0; id < scene.objectCount(); ++id) {
    const Box& box = scene.instance(id).bounds_world;
    if (box.empty() || !box.finite()) continue;
    const glm::dvec3 middle = 0.5 * box.min + 0.5 * box.max;
    x.push_back(middle.x);
    y.push_back(middle.y);
    z.push_back(middle.z);
    reach.push_back(glm::length(0.5 * box.max - 0.5 * box.min));
  }
  if (reach.empty()) return {glm::dvec3(-1.0), glm::dvec3(1.0)};
  std::sort(reach.begin(), reach.end());
  const double typical = reach[reach.size() / 2];  // one object alone has an extent too
  const auto [x_low, x_high] = middleRange(std::move(x));
  const auto [y_low, y_high] = middleRange(std::move(y));
  const auto [z_low, z_high] = middleRange(std::move(z));
  return {glm::dvec3(x_low, y_low, z_low) - typical, glm::dvec3(x_high, y_high, z_high) + typical};
}

}  // namespace

std::vector<CameraSpec> tourCameras(const SceneSnapshot& scene, std::uint32_t frames) {
  const Box part = crowdedPart(scene);
  const glm::dvec3 middle = 0.5 * part.min + 0.5 * part.max;
  const glm::dvec3 half = 0.5 * part.max - 0.5 * part.min;
  const double reach = std::max(glm::length(half), 1e-3);
  std::vector<CameraSpec> cameras;
  for (std::uint32_t i = 0; i < frames; ++i) {
    const double turn = 2.0 * std::numbers::pi * i / frames;
    const glm::dvec3 outwards(std::cos(turn), 0.0, std::sin(turn));
    LookAt look;
    look.znear_m = 1e-4 * reach;
    if (i % 2 == 0) {
      look.eye = middle + reach * (1.5 * outwards + glm::dvec3(0.0, 0.5, 0.0));
      look.target = middle;
    } else {
      look.eye = middle + 0.5 * glm::dvec3(half.x, 0.0, half.z) * outwards;
      look.target = look.eye + reach * glm::dvec3(-outwards.z, 0.0, outwards.x);
    }
    cameras.push_back({look, ImageSize{}, i % 2 == 0 ? "circle" : "walk"});
  }
  return cameras;
}

}  // namespace culld::scenes
