#include "culling/scene/scene_snapshot.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "culling/scene/scene_hash.h"

namespace culld {
namespace {

bool finite(const std::array<double, 12>& rows) {
  return std::all_of(rows.begin(), rows.end(), [](double m) { return std::isfinite(m); });
}

struct Range {
  double low, high;
};

/// One world coordinate of all points of a box.
/// The terms are added in the order m0 x + m1 y + m2 z + m3. Rounding is monotone, so `low` is at
/// or below that sum as computed for any point of the box. The margin covers every other order, and
/// the exact value: each differs from the exact sum by at most g = 4u/(1-4u) times S, the sum of
/// the absolute terms; two such errors and the last rounding are below 10 u S. 16 u S leaves room
/// for the rounding of S itself; DBL_MIN covers underflow.
Range rangeAlong(const double* m, const Box& box) {
  double low = 0.0, high = 0.0, total = 0.0;
  for (int i = 0; i < 3; ++i) {
    const double a = m[i] * box.min[i], b = m[i] * box.max[i];
    low = i == 0 ? std::min(a, b) : low + std::min(a, b);
    high = i == 0 ? std::max(a, b) : high + std::max(a, b);
    total += std::max(std::abs(a), std::abs(b));
  }
  total += std::abs(m[3]);
  const double margin =
      8.0 * std::numeric_limits<double>::epsilon() * total + std::numeric_limits<double>::min();
  return {low + m[3] - margin, high + m[3] + margin};
}

}  // namespace

Box boundsOf(const std::array<double, 12>& world_from_mesh, const Box& bounds_mesh) {
  Box world;
  if (bounds_mesh.empty()) return world;
  const double* row = world_from_mesh.data();
  for (int r = 0; r < 3; ++r, row += 4) {
    const Range range = rangeAlong(row, bounds_mesh);
    world.min[r] = range.low;
    world.max[r] = range.high;
  }
  return world;
}

void place(Instance& instance, const Mesh& mesh, const std::array<double, 12>& world_from_mesh) {
  instance.world_from_mesh = world_from_mesh;
  instance.bounds_world = Box{};
  instance.always_kept = mesh.unbounded || !finite(world_from_mesh);
  if (instance.always_kept) return;
  const Box world = boundsOf(world_from_mesh, mesh.bounds);
  if (mesh.bounds.empty()) return;
  instance.always_kept = !world.finite();
  if (!instance.always_kept) instance.bounds_world = world;
}

std::size_t SceneSnapshot::bytes() const noexcept {
  std::size_t total = sizeof(SceneSnapshot) + sizeof(FixedParts) + instances_.bytes() +
                      chunk_hashes_.capacity() * sizeof(chunk_hashes_[0]);
  for (const Mesh& mesh : fixed_->meshes) total += mesh.bytes();
  for (const std::string& line : fixed_->warnings) total += sizeof(line) + line.capacity();
  return total;
}

std::size_t SceneSnapshot::chunksNotIn(const SceneSnapshot& other) const noexcept {
  std::size_t count = 0;
  for (std::size_t c = 0; c < instances_.chunkCount(); ++c) {
    if (!instances_.sharesChunk(c, other.instances_)) ++count;
  }
  return count;
}

std::uint64_t SceneSnapshot::combinedHash() const {
  std::vector<std::uint64_t> parts{fixed_->meshes_hash, instances_.size()};
  parts.insert(parts.end(), chunk_hashes_.begin(), chunk_hashes_.end());
  return hashTogether(parts);
}

}  // namespace culld
