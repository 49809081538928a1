#include "culling/oracle/aim.h"

#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

namespace culld::oracle {
namespace {

constexpr std::uint64_t kGolden = 0x9E3779B97F4A7C15U;
constexpr std::array<double, 4> kBesidePx = {0.3, 0.03, 0.01, 0.001};
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
  if (!mesh.surfaceOf(index).double_sided && mesh.front() != Front::kUnknown) {
    const glm::dvec3 normal = glm::cross(corners[1] - corners[0], corners[2] - corners[0]);
    const bool front = glm::dot(normal, placed.mesh_from_world * aimed->ray.direction) < 0.0;
    if (front == (mesh.front() == Front::kClockwise)) return std::nullopt;
  }
  return aimed->ray;
}

std::optional<Ray> aimBeside(const RayView& view, const RayView::Placed& placed,
                             const glm::dvec2& pixel_ndc, Random& random) {
  const RayMesh& mesh = *placed.mesh;
  const auto triangle =
      static_cast<std::uint32_t>(random.unit() * static_cast<double>(mesh.triangleCount()));
  const Triangle corners = mesh.triangle(triangle);
  const std::size_t from = random.next() % 3;
  // Half of the places are corners: a hole has more of them near than of its short edges.
  const double along = random.next() % 2 == 0 ? 0.0 : random.unit();
  const glm::dvec3 in_mesh = corners[from] * (1.0 - along) + corners[(from + 1) % 3] * along;
  const auto place = view.rays().imageOf(placed.world_from_mesh * in_mesh + placed.centre);
  if (!place) return std::nullopt;
  const double pixels = kBesidePx[random.next() % kBesidePx.size()];
  const double turn = random.unit() * 2.0 * std::numbers::pi;
  const glm::dvec2 aside = *place + pixels * pixel_ndc * glm::dvec2(std::cos(turn), std::sin(turn));
  if (!(std::abs(aside.x) < 1.0 && std::abs(aside.y) < 1.0)) return std::nullopt;
  return view.rays().through(aside.x, aside.y);
}

}  // namespace culld::oracle
