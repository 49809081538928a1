#include "culling/scene/scene_hash.h"

#include <xxhash.h>

#include <cstddef>
#include <cstring>

namespace culld {
namespace {

/// Bytes one after the other, ready to be hashed.
class ByteWriter {
 public:
  explicit ByteWriter(std::size_t expected) { bytes_.reserve(expected); }
  template <typename T>
  void add(const T& value) {
    static_assert(std::is_arithmetic_v<T>);
    const std::size_t at = bytes_.size();
    bytes_.resize(at + sizeof(T));
    std::memcpy(bytes_.data() + at, &value, sizeof(T));
  }
  std::uint64_t hash() const { return XXH3_64bits(bytes_.data(), bytes_.size()); }

 private:
  std::vector<std::byte> bytes_;
};

template <typename T>
std::uint64_t hashArray(const std::vector<T>& values) {
  static_assert(std::is_trivially_copyable_v<T> && sizeof(T) == 12);  // three words, no padding
  return XXH3_64bits(values.data(), values.size() * sizeof(T));
}

void addFlags(ByteWriter& out, std::initializer_list<bool> flags) {
  for (const bool flag : flags) out.add(static_cast<std::uint8_t>(flag ? 1 : 0));
}

}  // namespace

std::uint64_t hashMesh(const Mesh& mesh) {
  ByteWriter out(128 + mesh.surfaces.size() * 10);
  out.add(static_cast<std::uint64_t>(mesh.positions.size()));
  out.add(hashArray(mesh.positions));
  out.add(static_cast<std::uint64_t>(mesh.triangles.size()));
  out.add(hashArray(mesh.triangles));
  for (const Surface& s : mesh.surfaces) {
    out.add(s.first_triangle);
    out.add(s.triangle_count);
    addFlags(out, {s.blocks, s.double_sided});
  }
  for (int i = 0; i < 3; ++i) {
    out.add(mesh.bounds.min[i]);
    out.add(mesh.bounds.max[i]);
  }
  out.add(mesh.points_and_lines);
  addFlags(out, {mesh.unbounded});
  return out.hash();
}

std::uint64_t hashInstances(std::span<const Instance> instances) {
  ByteWriter out(instances.size() * (12 * sizeof(double) + 16));
  for (const Instance& instance : instances) {
    addFlags(out, {instance.removed});
    if (instance.removed) continue;
    addFlags(out, {instance.hidden});
    for (const double m : instance.world_from_mesh) out.add(m + 0.0);  // -0 is 0
    out.add(instance.mesh);
    out.add(instance.node);
    out.add(instance.instance_number);
  }
  return out.hash();
}

std::uint64_t hashTogether(std::span<const std::uint64_t> hashes) {
  return XXH3_64bits(hashes.data(), hashes.size_bytes());
}

}  // namespace culld
