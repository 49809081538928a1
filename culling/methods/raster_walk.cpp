#include "culling/methods/raster_walk.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "culling/core/prefetch.h"
#include "culling/core/prices.h"
#include "culling/raster/box_cells.h"

namespace culld {
namespace {

constexpr std::uint32_t kItemsPerLook = 16;  ///< items between two looks at the clock

// Nanoseconds of counted work, measured (docs/planner.md).
constexpr std::uint64_t kFrameNs = 20'000, kNodeNs = 150;
constexpr std::uint64_t kStakeShare = 16;  ///< of the walk's work: asked in vain before it must pay
constexpr std::uint32_t kAskOneOf = 32;    ///< where it does not

bool fartherFirst(const RasterItem& a, const RasterItem& b) { return a.nearest < b.nearest; }

}  // namespace

RasterWalk::RasterWalk(const SceneSnapshot& scene, const WideBvh& bvh, const OccluderSet& occluders,
                       const Camera& camera, const Deadline& deadline, const Demand& demand,
                       RasterMemory& memory)
    : scene_(scene),
      bvh_(bvh),
      occluders_(occluders),
      deadline_(deadline),
      most_work_(demand.work),
      memory_(memory),
      frustum_(camera, bvh),
      view_(cellView(camera, gridFor(camera))),
      asked_view_(askedView(view_)),
      box_view_(boxView(view_)),
      origin_world_(camera.origin_world),
      drawing_(scene, occluders, view_, origin_world_, deadline, memory.occluder),
      ask_triangles_(demand.own_triangles) {
  memory_.cells.reset(view_.grid);
  memory_.queue.clear();
  memory_.candidates.clear();
}

void RasterWalk::push(const RasterItem& item) {
  memory_.queue.push_back(item);
  std::push_heap(memory_.queue.begin(), memory_.queue.end(), fartherFirst);
}

RasterItem RasterWalk::pop() {
  std::pop_heap(memory_.queue.begin(), memory_.queue.end(), fartherFirst);
  const RasterItem item = memory_.queue.back();
  memory_.queue.pop_back();
  return item;
}

void RasterWalk::visitNode(const RasterItem& item) {
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
    RasterItem below{cellRect(rects, lane, view_.grid), rects.nearest[lane], child, 0};
    if (child.isObject()) {
      takeObject(below, (node.blocking >> lane & 1U) != 0);
      continue;
    }
    below.planes = verdicts.planesLeft(lane);
    if (hidden(below)) {
      takeHidden(below);
    } else {
      prefetch(bvh_.node(child.nodeIndex()));
      push(below);
    }
  }
}

/// What is hidden ends here; it is only counted, so that the answer can say what occlusion brought.
void RasterWalk::takeHidden(const RasterItem& item) {
  if (item.ref.isObject()) {
    ++stats_.occluded;
  } else {
    in_frustum_ += countInFrustum(bvh_, frustum_, item.ref.nodeIndex(), item.planes);
  }
}

void RasterWalk::takeObject(const RasterItem& item, bool blocking) {
  ++in_frustum_;
  if (hidden(item)) {
    takeHidden(item);
  } else if (blocking && largeEnough(item.rect)) {
    prefetch(scene_.instance(item.ref.objectId()));
    push(item);
  } else {
    memory_.candidates.push_back(item);
  }
}

/// False if time or work ran out on the way.
bool RasterWalk::drawObject(const RasterItem& item) {
  const Instance& instance = scene_.instance(item.ref.objectId());
  if (!worthDrawing(item.rect, occluders_.mesh(instance.mesh))) return true;
  ++stats_.occluders_drawn;
  const DrawnOccluder drawn = drawing_.draw(instance, item.nearest, workLeftNs(), memory_.cells);
  stats_.triangles_drawn += drawn.triangles;
  drawing_ns_ += drawn.work_ns;
  return !drawn.cut_short;
}

std::uint64_t RasterWalk::workLeftNs() const {
  if (most_work_.count() == 0) return OccluderDrawing::kNoLimit;
  return workLeft() ? static_cast<std::uint64_t>((most_work_ - work()).count()) : 0;
}

void RasterWalk::keepTheRest(Answer& answer) {
  for (const RasterItem& item : memory_.queue) {
    if (item.ref.isObject()) {
      answer.visible.push_back(item.ref.objectId());
    } else {
      bvh_.appendObjects(item.ref.nodeIndex(), answer.visible);
    }
  }
  for (const RasterItem& item : memory_.candidates) answer.visible.push_back(item.ref.objectId());
  answer.out_of_budget = true;
}

std::chrono::nanoseconds RasterWalk::work() const {
  return std::chrono::nanoseconds(kFrameNs + kNodeNs * stats_.nodes_visited + drawing_ns_ +
                                  asking_ns_);
}

void RasterWalk::run(Answer& answer) {
  for (std::uint32_t root = 0; root < bvh_.rootCount(); ++root) {
    push({everyCell(view_.grid), std::numeric_limits<float>::infinity(), ChildRef::node(root),
          frustum_.planes()});
  }
  bool in_time = true;
  for (std::uint32_t taken = 0; in_time && !memory_.queue.empty(); ++taken) {
    if (taken % kItemsPerLook == 0) in_time = !deadline_.passed();
    if (in_time) in_time = takeNearest() && workLeft();
  }
  if (!in_time) {
    keepTheRest(answer);
  } else {
    answerCandidates(answer);
    stats_.in_frustum = in_frustum_;
  }
  stats_.work = work();
  answer.stats = stats_;
}

bool RasterWalk::takeNearest() {
  const RasterItem item = pop();
  if (hidden(item)) {
    takeHidden(item);
    return true;
  }
  if (item.ref.isNode()) {
    visitNode(item);
    return true;
  }
  memory_.candidates.push_back(item);
  return drawObject(item);
}

void RasterWalk::answerCandidates(Answer& answer) {
  const std::uint64_t stake_ns = static_cast<std::uint64_t>(work().count()) / kStakeShare;
  std::uint32_t looks = 0;
  for (const RasterItem& item : memory_.candidates) {
    bool out = hidden(item);
    // What an eye in motion may see beside the image has infinite nearness: it stays.
    const bool may_ask = ask_triangles_ && (!view_.moves || std::isfinite(item.nearest));
    if (!out && may_ask && !answer.out_of_budget && askingPays(stake_ns)) {
      if (looks++ % kItemsPerLook == 0) answer.out_of_budget = deadline_.passed();
      out = !answer.out_of_budget && hiddenByItsTriangles(item, answer.out_of_budget);
    }
    if (out) {
      ++stats_.occluded;
    } else {
      answer.visible.push_back(item.ref.objectId());
    }
  }
}

/// Objects left out pay for those asked in vain, beyond a share of the frame. Where they do not,
/// few are asked, so that asking is taken up again once it pays.
bool RasterWalk::askingPays(std::uint64_t stake_ns) {
  return asking_ns_ < saved_ns_ + stake_ns || ++unasked_ % kAskOneOf == 0;
}

/// The last rung, for what the rectangle kept. Sets `out_of_budget` once time or work is used up.
bool RasterWalk::hiddenByItsTriangles(const RasterItem& item, bool& out_of_budget) {
  const Instance& instance = scene_.instance(item.ref.objectId());
  const Mesh& mesh = scene_.mesh(instance.mesh);
  if (mesh.points_and_lines != 0) return false;
  const SheetObject object =
      sheetObjectOf(scene_, instance, item.nearest, SheetParts::kAll, memory_.occluder.surfaces);
  const auto worth_ns = static_cast<std::uint64_t>(kObjectPrice.count()) +
                        static_cast<std::uint64_t>(kTrianglePrice.count()) * mesh.triangles.size();
  const OwnTriangleVerdict verdict =
      ownTrianglesHidden(object, asked_view_, origin_world_, deadline_, worth_ns, memory_.cells);
  asking_ns_ += verdict.work_ns;
  if (verdict.hidden) saved_ns_ += worth_ns;
  out_of_budget = verdict.out_of_time || !workLeft();
  return verdict.hidden;
}

}  // namespace culld
