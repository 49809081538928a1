// A frame's depth on the GPU: outlines drawn into a grid of cells, a pyramid of their farthest
// depths, boxes asked against it. depth_reference.h is the scalar truth (equal bytes where the GPU
// divides as IEEE 754 does); docs/error-model/gpu.md proves that "hidden" is.
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "culling/gpu/context_pool.h"
#include "culling/gpu/outline_batch.h"
#include "culling/gpu/program.h"
#include "culling/gpu/resident_scenes.h"
#include "culling/raster/box_kernels.h"

namespace culld::gpu {

/// Where the levels of a pyramid lie in one array. Level k, texel (x, y) stands for the cells
/// [x << k, (x + 1) << k) x [y << k, (y + 1) << k): padded to powers of two, so that every texel
/// has exactly the four below it, and no cell is missed at any size of the grid.
struct PyramidLayout {
  static constexpr std::uint32_t kMostLevels = 13;
  std::uint32_t levels = 0;
  std::array<std::uint32_t, kMostLevels> first, width, height;  ///< of each level, in words
  std::uint32_t words = 0;
};
/// REQUIRES: sides of at most DepthPass::kMostSide cells.
PyramidLayout pyramidLayout(const CellGrid& grid) noexcept;

/// Eight boxes around one origin, the unit in which scenes are uploaded: rows min x, y, z, max x,
/// y, z, as in projectBoxes().
using BoxGroup = std::array<float, 6 * kBoxLanes>;

/// Asks the boxes `lanes` of one group. `origin` is the group's, relative to the eye.
struct GroupQuery {
  std::uint32_t group, lanes;
  std::array<float, 3> origin;
  std::uint32_t unused = 0;
};
static_assert(sizeof(GroupQuery) == 24);  // std430

/// A scene's groups, uploaded into a context when it first needs them. Another version of a scene
/// has another key.
struct GroupSource {
  std::uint64_t key = 0;
  std::size_t count = 0;
  std::function<void(std::vector<BoxGroup>&)> fill;
};

/// THREADS: as the context. Results count only if Lease::check() says so afterwards.
class DepthPass final : public ContextData {
 public:
  /// `contexts`: how many have a pass.
  DepthPass(const GlTable& gl, std::size_t contexts);
  ~DepthPass() override;
  DepthPass(const DepthPass&) = delete;
  DepthPass& operator=(const DepthPass&) = delete;

  /// ERROR: kUnavailable: a program did not compile. Then nothing else may be called.
  const Result<void>& ready() const noexcept { return ready_; }

  /// Forgets everything drawn. REQUIRES: sides of at most kMostSide cells.
  void begin(const CellGrid& grid);
  void draw(const OutlineBatch& batch);
  void buildPyramid();
  /// What a test computes with must stay far from overflow, as a shader's infinities are not to be
  /// trusted: the largest coefficient of the view times the sum of a box's coordinates.
  static constexpr float kLargestTerm = 1e20F;

  /// Sets bit 8 * q + l, counted from the lowest of the first word on, iff lane l of query q is
  /// certainly hidden. `refine`: finer levels asked where the first does not hide, at most 3.
  /// REQUIRES: no box asked exceeds kLargestTerm.
  void test(const BoxView& view, const GroupSource& source, std::span<const GroupQuery> queries,
            std::uint32_t refine, std::vector<std::uint32_t>& hidden);

  /// The pyramid, for tests.
  void readPyramid(std::vector<float>& out) const;

  static constexpr std::uint32_t kMostSide = 1U << (PyramidLayout::kMostLevels - 1);
  static constexpr std::size_t kQueriesPerWord = 4;
  /// Of scenes kept in all contexts, each of which may keep its share; the one in use is kept
  /// whatever its size.
  static constexpr std::size_t kResidentBytes = std::size_t{256} << 20U;

  std::size_t residentBytes() const noexcept { return scenes_.bytes(); }
  std::uint64_t uploads() const noexcept { return scenes_.uploads(); }

 private:
  const GlTable& gl_;
  Result<void> ready_;
  Program drawing_, reducing_, testing_;
  Buffer heads_, lines_, pyramid_, queries_, hidden_;
  unsigned framebuffer_ = 0, no_vertices_ = 0;
  CellGrid grid_;
  PyramidLayout layout_;
  ResidentScenes scenes_;
};

}  // namespace culld::gpu
