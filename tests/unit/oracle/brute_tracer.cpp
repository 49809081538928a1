#include "tests/unit/oracle/brute_tracer.h"

#include <algorithm>
#include <cmath>

namespace culld::oracle_test {
namespace {

Vec operator-(const Vec& a, const Vec& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
Vec cross(const Vec& a, const Vec& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
long double dot(const Vec& a, const Vec& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
long double length(const Vec& a) { return std::sqrt(dot(a, a)); }

Vec placed(const Instance& instance, const glm::vec3& p, const glm::dvec3& eye) {
  const auto row = [&](std::size_t i) {
    const double* m = instance.world_from_mesh.data() + 4 * i;
    return static_cast<long double>(m[0]) * p.x + static_cast<long double>(m[1]) * p.y +
           static_cast<long double>(m[2]) * p.z + m[3];
  };
  return {row(0) - eye.x, row(1) - eye.y, row(2) - eye.z};
}

constexpr long double kFlat = 1e-14L;  // of the determinant's terms: doubles may get its sign wrong

/// Does the instance turn triangles over? By its own determinant; unknown if rounding could decide.
struct Turned {
  bool over = false, known = true;
};

Turned turnedOver(const Instance& instance) {
  const double* m = instance.world_from_mesh.data();
  long double sum = 0, terms = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
    const long double with = static_cast<long double>(m[i]) * m[4 + j] * m[8 + k];
    const long double against = static_cast<long double>(m[i]) * m[4 + k] * m[8 + j];
    sum += with - against;
    terms += std::abs(with) + std::abs(against);
  }
  if (terms == 0) return {};
  return {sum<0, std::abs(sum)> kFlat * terms};
}

/// By the three volumes that the ray spans with the triangle's edges.
void meet(const Vec (&corner)[3], const BruteRay& ray, const Turned& turned, const Surface& surface,
          BruteHit hit, std::vector<BruteHit>& hits) {
  const Vec a = corner[0] - ray.origin, b = corner[1] - ray.origin, c = corner[2] - ray.origin;
  const long double va = dot(ray.direction, cross(b, c));
  const long double vb = dot(ray.direction, cross(c, a));
  const long double vc = dot(ray.direction, cross(a, b));
  const long double volume = va + vb + vc;
  if (volume == 0) return;
  hit.inside = std::min({va / volume, vb / volume, vc / volume});
  if (!(hit.inside >= 0)) return;
  const Vec normal = cross(corner[1] - corner[0], corner[2] - corner[0]);
  hit.facing = std::abs(dot(normal, ray.direction)) / (length(normal) * length(ray.direction));
  hit.side_known = surface.double_sided || turned.known;
  const bool front = (dot(normal, ray.direction) < 0) != turned.over;
  if (hit.side_known && !front && !surface.double_sided) return;
  hit.t = dot(normal, a) / dot(normal, ray.direction);
  if (hit.t >= ray.t_min && hit.t <= ray.t_max) hits.push_back(hit);
}

}  // namespace

std::vector<BruteHit> bruteHits(const SceneSnapshot& scene, const Camera& camera,
                                const BruteRay& ray) {
  std::vector<BruteHit> hits;
  for (ObjectId id = 0; id < scene.objectCount(); ++id) {
    const Instance& instance = scene.instance(id);
    if (!instance.active()) continue;
    const Turned turned = turnedOver(instance);
    const Mesh& mesh = scene.mesh(instance.mesh);
    for (const Surface& surface : mesh.surfaces) {
      for (std::uint32_t i = 0; i < surface.triangle_count; ++i) {
        const auto& t = mesh.triangles[surface.first_triangle + i];
        const Vec corner[3] = {placed(instance, mesh.positions[t[0]], camera.origin_world),
                               placed(instance, mesh.positions[t[1]], camera.origin_world),
                               placed(instance, mesh.positions[t[2]], camera.origin_world)};
        BruteHit hit;
        hit.object = id;
        hit.blocks = surface.blocks && !instance.always_kept;
        meet(corner, ray, turned, surface, hit, hits);
      }
    }
  }
  return hits;
}

}  // namespace culld::oracle_test
