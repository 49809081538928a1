// The triangles of a mesh in clusters of like place and like normal. Each has a region behind it,
// from where all of its triangles turn away, and one in front, from where none does; in between is
// the mixed region. A hierarchy, so that only clusters in their mixed region are looked into
// (hierarchical back-face computation; Kumar, Manocha, Garrett, Lin 1999). Regions are cones with
// margins: docs/error-model/backface-clusters.md.
#pragma once
#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "culling/occluders/mesh_eye.h"
#include "culling/raster/sheet.h"
#include "culling/scene/mesh.h"

namespace culld {

/// The region of a cluster that an eye is in.
enum class FacingRegion : std::uint8_t {
  kBack,   ///< all of its triangles turn away, surely and for all eyes of the motion bound
  kFront,  ///< none of them does, about: this saves work and proves nothing
  kMixed,
};

/// How clusters are made. Any rules give sound ones.
struct ClusterRules {
  std::uint32_t leaf = 8;   ///< triangles in a cluster that is not divided further
  bool by_position = true;  ///< near triangles together
  bool by_normal = true;    ///< and those with like normals
};

class FacingClusters {
 public:
  /// COST: O(n log n) time; 24 bytes a triangle and 96 a cluster, of which there are at most 4 n /
  /// `leaf`; and while it is made 48 bytes a triangle.
  static FacingClusters of(const Mesh& mesh, const ClusterRules& rules);

  /// Nothing of the mesh can be seen from there: all of it is single-sided, and turned away.
  /// `hierarchy`: false asks the clusters of the leaves alone, all of them. `regions` grows by the
  /// clusters held against the eye: false if `most_regions` of them do not decide.
  bool turnedAway(const MeshEye& eye, bool hierarchy, std::uint64_t most_regions,
                  std::uint64_t& regions) const;

  /// The mesh's blocking triangles without the clusters whose back region the eye is in, as runs of
  /// triangles(). Returns how many triangles are in them.
  std::uint32_t appendFacing(const Mesh& mesh, const MeshEye& eye, bool hierarchy,
                             std::vector<SheetSurface>& out, std::uint64_t& regions) const;

  /// The mesh's triangles and their partners in the order of clusters; surfaces stay where they
  /// are. Empty if none of them is single-sided.
  std::span<const std::array<std::uint32_t, 3>> triangles() const noexcept { return triangles_; }
  std::span<const std::uint32_t> partners() const noexcept { return partners_; }
  bool oneSided() const noexcept { return one_sided_; }  ///< all of it: it may turn away
  /// Some of it is single-sided.
  bool any() const noexcept { return !clusters_.empty(); }
  std::size_t bytes() const noexcept;

 private:
  friend class ClusterBuilder;
  static constexpr std::uint32_t kNoCluster = 0xFFFFFFFFU;  ///< of surfaces that have two sides
  struct Cluster {
    glm::dvec3 axis;      ///< of length 1 up to rounding
    double cosine, sine;  ///< of the angle around it that holds all normals, rounded up
    glm::dvec3 middle;
    double below;  ///< no plane is behind the middle by more than this; not negative
    double above;  ///< nor before it by more than this, about
    std::uint32_t first, count;
    std::uint32_t right;  ///< index of the second half; the first one follows this. 0: a leaf
    bool certain;         ///< all normals are known, and within less than a right angle of the axis
  };
  static FacingRegion regionOf(const Cluster& cluster, const MeshEye& eye) noexcept;
  template <typename Take>
  void walk(std::uint32_t root, const MeshEye& eye, bool hierarchy, std::uint64_t& regions,
            const Take& take) const;

  std::vector<Cluster> clusters_;
  std::vector<std::uint32_t> roots_;  ///< by surface, or kNoCluster
  std::vector<std::array<std::uint32_t, 3>> triangles_;
  std::vector<std::uint32_t> partners_;
  bool one_sided_ = false;  ///< all triangles, and there are no points or lines
};

}  // namespace culld
