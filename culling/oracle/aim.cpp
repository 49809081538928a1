#include "culling/oracle/aim.h"

#include <cmath>
#include <glm/geometric.hpp>

namespace culld::oracle {
namespace {

constexpr std::uint64_t kGolden = 0x9E3779B97F4A7C15U;
constexpr double kNudge = 0.01;  // barycentric, inward from a corner or an edge

std::uint64_t mixed(std::uint64_t z) {
  z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9U;
  z = (z ^ (z >> 27U)) * 0x94D049BB133111EBU;
  return z ^ (z >> 31U);
}

glm::dvec3 weightsFor(std::uint32_t number, Random& random) {
  const auto corner = static_cast<int>(random.next() % 3);
  glm::dvec3 weights(0.0);
  switch (number % 4) {
    case 1:  // just inside a corner
      weights = glm::dvec3(kNudge);
      weights[corner] = 1.0 - 2.0 * kNudge;
      return weights;
    case 3:  // just inside the middle of an edge
      weights = glm::dvec3(0.5 - 0.5 * kNudge);
      weights[corner] = kNudge;
      return weights;
    default: {
      const double root = std::sqrt(random.unit());
      const double v = random.unit();
      return {1.0 - root, root * (1.0 - v), root * v};
    }
  }
}

}  // namespace

Random::Random(std::uint64_t seed, std::uint64_t what, std::uint64_t which)
    : state_(mixed(mixed(mixed(seed + kGolden) + what * kGolden) + which * kGolden)) {}

std::uint64_t Random::next() {
  state_ += kGolden;
  return mixed(state_);
}

double Random::unit() { return static_cast<double>(next() >> 11U) * 0x1p-53; }

std::optional<Ray> aimAt(const RayView& view, const RayView::Placed& placed, std::uint32_t number,
                         Random& random) {
  const RayMesh& mesh = *placed.mesh;
  const double draw = random.unit();
  // Small triangles get their turn too: every other ray picks by number, not by area.
  const std::uint32_t index =
      number % 2 == 0
          ? mesh.triangleAtArea(draw)
          : static_cast<std::uint32_t>(draw * static_cast<double>(mesh.triangleCount()));
  const Triangle corners = mesh.triangle(index);
  const glm::dvec3 weights = weightsFor(number, random);
  const glm::dvec3 in_mesh =
      weights.x * corners[0] + weights.y * corners[1] + weights.z * corners[2];
  const auto aimed = view.rays().at(placed.world_from_mesh * in_mesh + placed.centre);
  if (!aimed) return std::nullopt;
  if (!mesh.surfaceOf(index).double_sided) {
    const glm::dvec3 normal = glm::cross(corners[1] - corners[0], corners[2] - corners[0]);
    const bool front = glm::dot(normal, placed.mesh_from_world * aimed->ray.direction) < 0.0;
    if (front == mesh.frontIsClockwise()) return std::nullopt;
  }
  return aimed->ray;
}

}  // namespace culld::oracle
