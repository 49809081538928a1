// An item buffer on the GPU (Weghorst, Hooper, Greenberg 1984): triangles drawn with the number of
// their item, so that an image tells which item is nearest at each sample, and how many samples
// each has. What does not hide others is asked against the same depths, without a place of its own
// in the image.
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "culling/gpu/context_pool.h"
#include "culling/gpu/program.h"
#include "culling/gpu/resident_scenes.h"

namespace culld::gpu {

/// One thing to draw: rows on (position, 1) of its mesh to clip coordinates with 0 <= z <= w,
/// larger z / w nearer to the eye; the cuts are >= 0 where nothing is cut off.
struct Item {
  std::array<double, 4> x, y, z, w, near_cut, far_cut;
  std::uint32_t number = 0;  ///< whose samples are counted
  std::array<std::uint32_t, 7> unused{};
};
static_assert(sizeof(Item) == 224);  // std430: aligned as a dvec4

/// Which side of a triangle is drawn, by the order of its corners in the image.
enum class Facing : std::uint8_t { kBoth, kCounterClockwise, kClockwise };

/// Indices of a mesh, drawn with items that follow each other.
struct ItemDraw {
  std::uint32_t first_index, index_count;
  std::uint32_t first_item, item_count;
  Facing facing;
};

/// All meshes of a scene: three floats for each vertex, then indices of vertices. Uploaded into a
/// context when it first needs them.
struct MeshSource {
  std::uint64_t key = 0;
  std::size_t vertices = 0, indices = 0;
  std::function<void(std::vector<std::uint32_t>&)> fill;  ///< appends the floats' bits, the indices
  std::size_t words() const noexcept { return 3 * vertices + indices; }
};

/// THREADS: as the context. Results count only if Lease::check() says so afterwards.
class ItemPass final : public ContextData {
 public:
  /// `contexts`: how many have a pass.
  ItemPass(const GlTable& gl, std::size_t contexts);
  ~ItemPass() override;
  ItemPass(const ItemPass&) = delete;
  ItemPass& operator=(const ItemPass&) = delete;

  /// ERROR: kUnavailable: a program did not compile. Then nothing else may be called.
  const Result<void>& ready() const noexcept { return ready_; }

  static constexpr std::uint32_t kMostSide = 16384;
  static constexpr std::uint64_t kMostSamples = std::uint64_t{1} << 25U;
  /// Of meshes kept in all contexts, each of which may keep its share; those in use are kept
  /// whatever their size.
  static constexpr std::size_t kResidentBytes = std::size_t{256} << 20U;

  /// Forgets everything drawn. REQUIRES: an image within kMostSide and kMostSamples. `numbers`:
  /// items are numbered below it.
  void begin(std::uint32_t width, std::uint32_t height, std::size_t numbers);

  enum class Stage : std::uint8_t {
    kNearest,  ///< the nearest surface takes a sample; of equally near ones the first
    kAsked     ///< takes none, and is counted wherever nothing is nearer by more than rounding
  };
  void draw(Stage stage, const MeshSource& meshes, std::span<const Item> items,
            std::span<const ItemDraw> draws);
  /// Counts the samples taken so far.
  void countTaken();
  /// By number, samples taken and asked fragments that passed.
  void read(std::vector<std::uint32_t>& counts) const;

  std::uint64_t uploads() const noexcept { return meshes_.uploads(); }

 private:
  void resize(std::uint32_t width, std::uint32_t height);

  const GlTable& gl_;
  Result<void> ready_;
  Program nearest_, asked_, counting_;
  Buffer items_, counts_;
  unsigned vertex_array_ = 0;
  unsigned image_ = 0, depth_ = 0;
  unsigned whole_ = 0;       ///< framebuffer of both
  unsigned depth_only_ = 0;  ///< and of the depths alone
  std::uint32_t width_ = 0, height_ = 0;
  std::size_t numbers_ = 0;
  ResidentScenes meshes_;
};

}  // namespace culld::gpu
