#include "culling/methods/horizon_walk.h"

#include <algorithm>
#include <bit>

#include "culling/core/prefetch.h"
#include "culling/raster/box_cells.h"
#include "culling/spatial/frustum_walk.h"

namespace culld {
namespace {

// Choices of what joins the horizon: they cost or save time and never change a promise.
constexpr float kLeastColumns = 3.0F;
constexpr float kLeastRows = 3.0F;
constexpr float kTrianglesPerCell = 0.125F;  ///< more detail than cells is not worth drawing
constexpr float kVerticesPerCell = 4.0F;     ///< as all of a mesh's vertices are transformed

// Nanoseconds of counted work, measured (docs/methods/horizon.md).
constexpr std::uint64_t kFrameNs = 3'000, kNodeNs = 150, kLookNs = 3;
constexpr std::uint64_t kVertexNs = 20, kTriangleNs = 20, kTurnedNs = 60, kMarkNs = 12;

ColumnRect columnRect(const BoxRects& rects, std::size_t lane, const CellGrid& grid) {
  const auto top = static_cast<float>(grid.height);
  return {clampCell(rects.x0[lane], grid.width), clampCell(rects.x1[lane], grid.width),
          std::min(std::max(rects.y0[lane], 0.0F), top),
          std::min(std::max(rects.y1[lane], 0.0F), top)};
}

constexpr auto kFartherFirst = [](const auto& a, const auto& b) { return a.nearest < b.nearest; };

}  // namespace

HorizonWalk::HorizonWalk(const SceneSnapshot& scene, const WideBvh& bvh, const Camera& camera,
                         const Deadline& deadline, const Demand& demand, const HorizonParts& parts,
                         HorizonMemory& memory)
    : scene_(scene),
      bvh_(bvh),
      deadline_(deadline),
      budget_(deadline, demand.work),
      parts_(parts),
      memory_(memory),
      frustum_(camera, bvh),
      view_(cellView(camera, gridFor(camera))),
      box_view_(boxView(view_)),
      origin_world_(camera.origin_world) {
  memory_.horizon.reset(view_.grid.width, parts.tree);
  memory_.coming.reset(view_.grid.width, false);
  memory_.slices.clear();
  memory_.waiting.clear();
  memory_.queue.clear();
}

void HorizonWalk::push(const HorizonItem& item) {
  memory_.queue.push_back(item);
  std::push_heap(memory_.queue.begin(), memory_.queue.end(), kFartherFirst);
}

HorizonItem HorizonWalk::pop() {
  std::pop_heap(memory_.queue.begin(), memory_.queue.end(), kFartherFirst);
  const HorizonItem item = memory_.queue.back();
  memory_.queue.pop_back();
  return item;
}

bool HorizonWalk::hidden(const HorizonItem& item) {
  if (item.ref.isNode() && !parts_.hierarchy) return false;
  return memory_.horizon.certainlyHidden(item.rect, item.nearest);
}

/// What is hidden ends here; it is only counted, so that the answer can say what occlusion brought.
void HorizonWalk::takeHidden(const HorizonItem& item) {
  if (item.ref.isObject()) {
    ++stats_.occluded;
  } else {
    in_frustum_ += countInFrustum(bvh_, frustum_, item.ref.nodeIndex(), item.planes);
  }
}

void HorizonWalk::visitNode(const HorizonItem& item) {
  ++stats_.nodes_visited;
  const WideNode& node = bvh_.node(item.ref.nodeIndex());
  const LaneVerdicts verdicts = frustum_.test(node, item.planes);
  BoxRects rects;
  projectBoxes(box_view_, originFrom(node, origin_world_), node.offsets, rects);
  const std::uint32_t on_image = verdicts.may_intersect & ~rects.off_grid;
  for (std::uint32_t lanes = node.live; lanes != 0; lanes &= lanes - 1) {
    const auto lane = static_cast<std::size_t>(std::countr_zero(lanes));
    const ChildRef child = node.child[lane];
    if (child.isObject()) ++stats_.tested;
    if ((on_image >> lane & 1U) == 0) {
      if (child.isObject()) ++stats_.outside;
      continue;
    }
    if (child.isObject()) ++in_frustum_;
    const HorizonItem below{columnRect(rects, lane, view_.grid), rects.nearest[lane], child,
                            child.isNode() ? verdicts.planesLeft(lane) : PlaneMask{0},
                            (node.blocking >> lane & 1U) != 0};
    if (hidden(below)) {
      takeHidden(below);
    } else {
      push(below);
    }
  }
}

/// All that hides before `nearest` joins the horizon.
void HorizonWalk::sweepTo(float nearest) {
  std::vector<WaitingSlice>& waiting = memory_.waiting;
  while (!waiting.empty() && waiting.front().nearest > nearest) {
    std::pop_heap(waiting.begin(), waiting.end(), kFartherFirst);
    join(memory_.slices.slices[waiting.back().slice]);
    waiting.pop_back();
  }
}

void HorizonWalk::join(const HorizonSlice& slice) {
  memory_.horizon.raise(slice.first_column, memory_.slices.spansOf(slice), slice.nearness);
}

/// Slices from `first` on wait for the sweep; those that would raise nothing are dropped.
void HorizonWalk::queueSlices(std::size_t first) {
  const HorizonSlices& slices = memory_.slices;
  for (std::size_t i = first; i < slices.slices.size(); ++i) {
    const HorizonSlice& slice = slices.slices[i];
    if (memory_.coming.covers(slice.first_column, slices.spansOf(slice))) continue;
    memory_.coming.raise(slice.first_column, slices.spansOf(slice), slice.nearness);
    if (!parts_.sweep) {
      join(slice);
      continue;
    }
    memory_.waiting.push_back({slice.nearness, static_cast<std::uint32_t>(i)});
    std::push_heap(memory_.waiting.begin(), memory_.waiting.end(), kFartherFirst);
  }
}

bool HorizonWalk::worthAdding(const HorizonItem& item, const Mesh& mesh) const {
  const float columns = static_cast<float>(item.rect.x1 - item.rect.x0 + 1);
  const float rows = item.rect.y1 - item.rect.y0;
  if (!(columns >= kLeastColumns && rows >= kLeastRows)) return false;
  if (!(memory_.coming.shareBeyond(item.rect) >= parts_.least_gain)) return false;
  const float cells = columns * rows;
  return static_cast<float>(mesh.positions.size()) <= kVerticesPerCell * cells &&
         static_cast<float>(mesh.blocking_triangles) <= kTrianglesPerCell * cells;
}

void HorizonWalk::addOccluder(const HorizonItem& item) {
  const Instance& instance = scene_.instance(item.ref.objectId());
  const Mesh& mesh = scene_.mesh(instance.mesh);
  if (!worthAdding(item, mesh)) return;
  const std::size_t first = memory_.slices.slices.size();
  const SheetObject object =
      sheetObjectOf(scene_, instance, item.nearest, SheetParts::kBlocking, memory_.surfaces);
  const SkylineWork work = memory_.skyline.append(object, view_, origin_world_,
                                                  parts_.slice_columns, deadline_, memory_.slices);
  ++stats_.occluders_drawn;
  stats_.triangles_drawn += work.triangles;
  const std::uint64_t work_ns = kVertexNs * mesh.positions.size() +
                                kTriangleNs * mesh.blocking_triangles + kTurnedNs * work.triangles +
                                kMarkNs * work.marks;
  budget_.drew({work.triangles, work_ns, work.out_of_time});
  queueSlices(first);
}

void HorizonWalk::takeNearest(Answer& answer) {
  const HorizonItem item = pop();
  sweepTo(item.nearest);
  if (hidden(item)) {
    takeHidden(item);
  } else if (item.ref.isNode()) {
    visitNode(item);
  } else {
    answer.visible.push_back(item.ref.objectId());
    if (item.blocks) addOccluder(item);
  }
}

void HorizonWalk::keepTheRest(Answer& answer) {
  for (const HorizonItem& item : memory_.queue) {
    if (item.ref.isObject()) {
      answer.visible.push_back(item.ref.objectId());
    } else {
      bvh_.appendObjects(item.ref.nodeIndex(), answer.visible);
    }
  }
  answer.out_of_budget = true;
}

std::uint64_t HorizonWalk::countedNs() const {
  return kFrameNs + kNodeNs * stats_.nodes_visited + kLookNs * memory_.horizon.looks();
}

void HorizonWalk::run(Answer& answer) {
  const ColumnRect everything{0, view_.grid.width - 1, 0.0F, static_cast<float>(view_.grid.height)};
  for (std::uint32_t root = 0; root < bvh_.rootCount(); ++root) {
    push({everything, std::numeric_limits<float>::infinity(), ChildRef::node(root),
          frustum_.planes(), false});
  }
  while (!memory_.queue.empty() && budget_.mayGoOn(countedNs())) takeNearest(answer);
  if (memory_.queue.empty()) {
    stats_.in_frustum = in_frustum_;
  } else {
    keepTheRest(answer);
  }
  stats_.work = budget_.work(countedNs());
  answer.stats = stats_;
}

}  // namespace culld
