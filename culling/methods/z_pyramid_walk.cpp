#include "culling/methods/z_pyramid_walk.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "culling/core/prices.h"
#include "culling/occluders/image_walk.h"
#include "culling/raster/box_cells.h"
#include "culling/raster/moving_view.h"
#include "culling/raster/own_triangles.h"
#include "culling/spatial/wide_bvh_fit.h"

namespace culld {
namespace {

// Choices of what to ask: they cost or save time and never change what is promised. They look at
// the object and the camera alone, so that answers do not depend on the order of drawing.
constexpr std::uint64_t kLeastFaceCells = 32;  ///< fewer cells: the rectangle says enough
constexpr std::uint64_t kStakeNs = 300;        ///< per object: asked in vain before it must pay

// Nanoseconds of counted work: rough.
constexpr std::uint64_t kFrameNs = 20'000, kNodeNs = 300, kComparisonNs = 8;

void growTo(std::vector<std::uint32_t>& marks, std::size_t size) {
  if (marks.size() < size) marks.resize(size, 0);
}

/// Where no image shows what all poses see, none is drawn and any will do.
Camera shownBy(const Camera& camera) {
  Camera shown = camera;
  if (!holdsInMotion(camera)) shown.motion = MotionBound{};
  return shown;
}

}  // namespace

ZPyramidWalk::ZPyramidWalk(const SceneSnapshot& scene, const Octree& octree,
                           const OccluderSet& occluders, const ZPyramidParts& parts,
                           const Camera& camera, const Deadline& deadline, const Demand& demand,
                           ZPyramidMemory& memory)
    : scene_(scene),
      octree_(octree),
      occluders_(occluders),
      parts_(parts),
      deadline_(deadline),
      budget_(deadline, demand.work),
      memory_(memory),
      frustum_(camera, octree.bounds()),
      view_(cellView(shownBy(camera), gridFor(camera))),
      asked_view_(askedView(view_)),
      box_view_(boxView(view_)),
      eye_world_(camera.origin_world),
      toward_eye_(camera.near_row),
      perspective_(camera.perspective),
      drawing_(scene, occluders, view_, eye_world_, deadline, memory.occluder),
      ask_triangles_(demand.own_triangles),
      // A widened image shows surfaces that no pose sees: drawing them or not would show in
      // answers. And answers limited by work must not hang on what was drawn first.
      coherent_(parts.coherence && camera.motion.still() && demand.work.count() == 0),
      occlusion_(holdsInMotion(camera)) {}

void ZPyramidWalk::beginFrame() {
  if (++memory_.frame == 0) {  // after 2^32 frames old marks could be mistaken for this frame's
    for (auto* marks : {&memory_.taken_in, &memory_.kept_in, &memory_.visible_in}) marks->clear();
    memory_.frame = 1;
    memory_.visible_frame = 0;
  }
  growTo(memory_.taken_in, scene_.objectCount());
  growTo(memory_.kept_in, scene_.objectCount());
  growTo(memory_.visible_in, octree_.nodeCount());
  memory_.cells.reset(view_.grid);
  memory_.pyramid.reset(view_.grid);
  memory_.pending.clear();
  memory_.visits.clear();
  memory_.parts.clear();
}

std::uint64_t ZPyramidWalk::countedNs() const {
  return kFrameNs + kNodeNs * stats_.nodes_visited + kComparisonNs * memory_.pyramid.comparisons() +
         asking_ns_;
}

void ZPyramidWalk::run(Answer& answer) {
  beginFrame();
  if (!octree_.empty()) {
    ZPyramidVisit root;
    root.node = Octree::kRoot;
    root.planes = frustum_.planes();
    root.box.rect = everyCell(view_.grid);
    root.box.nearest = std::numeric_limits<float>::infinity();
    if (occlusion_ && coherent_ && memory_.visible_frame != 0) drawWhatWasVisible();
    memory_.pending.push_back(root);
    walk();
  }
  if (!budget_.stopped() && settle(answer)) {
    askByTriangles(answer);
  } else {
    keepTheRest(answer);
  }
  stats_.depth_comparisons = memory_.pyramid.comparisons();
  stats_.work = budget_.work(countedNs());
  answer.out_of_budget = budget_.stopped();
  answer.stats = stats_;
}

/// First pass: what the last frame found visible, nodes and objects. Whether they still are does
/// not matter: hidden things change no depth.
void ZPyramidWalk::drawWhatWasVisible() {
  struct Entry {
    std::uint32_t node;
    PlaneMask planes;
  };
  std::vector<Entry> stack{{Octree::kRoot, frustum_.planes()}};
  while (!stack.empty() && mayGoOn()) {
    const Entry entry = stack.back();
    stack.pop_back();
    const OctreeNode& node = octree_.node(entry.node);
    for (std::uint32_t at = node.objects; at != OctreeNode::kNone; at = octree_.nextLanes(at)) {
      const WideNode& lanes = octree_.lanes(at);
      std::uint32_t left = frustum_.test(lanes, entry.planes).may_intersect & lanes.blocking;
      for (; left != 0; left &= left - 1) {
        const ObjectId id = lanes.child[std::countr_zero(left)].objectId();
        if (memory_.kept_in[id] == memory_.visible_frame) takeOccluder(id);
      }
    }
    forEachChild(node, entry.planes, [&](std::uint32_t child, PlaneMask planes, std::uint32_t) {
      if (memory_.visible_in[child] == memory_.visible_frame) stack.push_back({child, planes});
    });
  }
}

/// Octants that the frustum may hold, farthest first, as a stack wants them.
template <typename Take>
void ZPyramidWalk::forEachChild(const OctreeNode& node, PlaneMask planes, const Take& take) {
  if (node.children == OctreeNode::kNone) return;
  const WideNode& lanes = octree_.lanes(node.children);
  const LaneVerdicts verdicts = frustum_.test(lanes, planes);
  const std::uint32_t nearest = nearestOctant(node.centre);
  // By the number of planes between the octant and the nearest one.
  constexpr std::uint32_t kFarthestFirst[8] = {7, 6, 5, 3, 4, 2, 1, 0};
  for (const std::uint32_t across : kFarthestFirst) {
    const std::uint32_t octant = nearest ^ across;
    if ((verdicts.may_intersect >> octant & 1U) == 0) continue;
    take(lanes.child[octant].nodeIndex(), verdicts.planesLeft(octant), octant);
  }
}

std::uint32_t ZPyramidWalk::nearestOctant(const glm::dvec3& centre) const {
  const glm::dvec3 toward = perspective_ ? eye_world_ - centre : toward_eye_;
  return (toward.x > 0.0 ? 1U : 0U) | (toward.y > 0.0 ? 2U : 0U) | (toward.z > 0.0 ? 4U : 0U);
}

void ZPyramidWalk::walk() {
  while (!memory_.pending.empty() && mayGoOn()) {
    const ZPyramidVisit from = memory_.pending.back();
    memory_.pending.pop_back();
    visit(from);
  }
}

void ZPyramidWalk::visit(const ZPyramidVisit& from) {
  ++stats_.nodes_visited;
  const auto index = static_cast<std::uint32_t>(memory_.visits.size());
  memory_.visits.push_back(from);
  if (hides(memory_.visits.back().box)) {
    memory_.visits.pop_back();
    return;
  }
  takeObjects(from, index);
  pushChildren(from, index);
}

void ZPyramidWalk::takeObjects(const ZPyramidVisit& from, std::uint32_t visit) {
  const OctreeNode& node = octree_.node(from.node);
  for (std::uint32_t at = node.objects; at != OctreeNode::kNone; at = octree_.nextLanes(at)) {
    const WideNode& lanes = octree_.lanes(at);
    const LaneVerdicts verdicts = frustum_.test(lanes, from.planes);
    BoxRects rects;
    projectBoxes(box_view_, originFrom(lanes, eye_world_), lanes.offsets, rects);
    stats_.tested += static_cast<std::uint32_t>(std::popcount(std::uint32_t{lanes.live}));
    std::uint32_t left = verdicts.may_intersect & ~(occlusion_ ? rects.off_grid : 0U);
    for (; left != 0; left &= left - 1) {
      const auto l = static_cast<std::uint32_t>(std::countr_zero(left));
      const ZPyramidBox box{
          cellRect(rects, l, view_.grid), rects.nearest[l], at, static_cast<std::uint8_t>(l), {}};
      takeObject(box, visit, lanes.child[l].objectId(), (lanes.blocking >> l & 1U) != 0);
    }
  }
}

void ZPyramidWalk::takeObject(ZPyramidBox box, std::uint32_t visit, ObjectId id, bool blocking) {
  if (hides(box)) return;
  memory_.parts.push_back({box, id, visit});
  if (blocking && occlusion_) takeOccluder(id);
}

void ZPyramidWalk::pushChildren(const ZPyramidVisit& from, std::uint32_t visit) {
  const OctreeNode& node = octree_.node(from.node);
  if (node.children == OctreeNode::kNone) return;
  const WideNode& lanes = octree_.lanes(node.children);
  BoxRects rects;
  projectBoxes(box_view_, originFrom(lanes, eye_world_), lanes.offsets, rects);
  forEachChild(node, from.planes, [&](std::uint32_t child, PlaneMask planes, std::uint32_t octant) {
    if (occlusion_ && (rects.off_grid >> octant & 1U) != 0) return;
    ZPyramidVisit below;
    below.node = child;
    below.parent = visit;
    below.planes = planes;
    below.box = {cellRect(rects, octant, view_.grid),
                 rects.nearest[octant],
                 node.children,
                 static_cast<std::uint8_t>(octant),
                 {}};
    memory_.pending.push_back(below);
  });
}

/// By the rectangle, then by the front faces. Only more depth in the pyramid changes the verdict.
bool ZPyramidWalk::hides(ZPyramidBox& box) {
  box.open.nearest = std::numeric_limits<float>::infinity();
  if (!occlusion_ || !std::isfinite(box.nearest)) return false;
  DepthPyramid& pyramid = memory_.pyramid;
  bringPyramidUpToDate();
  BoxProbe probe;
  probe.rect = box.rect;
  probe.nearest = box.nearest;
  if (pyramid.hides(probe, parts_.levels, box.open)) return true;
  if (!parts_.faces || box.rect.cells() < kLeastFaceCells) return false;
  const WideNode& lanes = octree_.lanes(box.lanes);
  addFaces(view_, eye_world_, {lanes.origin[0], lanes.origin[1], lanes.origin[2]}, lanes.offsets,
           box.lane, probe);
  const CellRect cell{box.open.x, box.open.x, box.open.y, box.open.y};
  const OpenCell same{box.open.x, box.open.y, probe.nearestOver(cell)};
  if (!probe.besides(cell) && pyramid.stillOpen(same)) {
    box.open = same;
    return false;
  }
  return pyramid.hides(probe, parts_.levels, box.open);
}

/// The whole object, whichever part of it was met first.
bool ZPyramidWalk::ownBox(ObjectId id, ZPyramidBox& box) const {
  return projectBox(box_view_, eye_world_, view_.grid, scene_.instance(id).bounds_world, box.rect,
                    box.nearest);
}

/// Draws the object if it is worth that and not hidden: hidden, it would change nothing.
void ZPyramidWalk::takeOccluder(ObjectId id) {
  if (memory_.taken_in[id] == memory_.frame || budget_.stopped()) return;
  memory_.taken_in[id] = memory_.frame;
  const Instance& instance = scene_.instance(id);
  ZPyramidBox box;
  if (!ownBox(id, box) || !worthDrawing(box.rect, occluders_.mesh(instance.mesh))) return;
  bringPyramidUpToDate();
  BoxProbe probe;
  probe.rect = box.rect;
  probe.nearest = box.nearest;
  if (memory_.pyramid.hides(probe, parts_.levels, box.open)) return;
  ++stats_.occluders_drawn;
  const DrawnOccluder drawn =
      drawing_.draw(instance, box.nearest, budget_.leftNs(countedNs()), memory_.cells);
  stats_.triangles_drawn += drawn.triangles;
  budget_.drew(drawn);
  if (parts_.incremental) {
    memory_.pyramid.update(memory_.cells, box.rect);
  } else {
    pyramid_is_old_ = true;
  }
}

void ZPyramidWalk::bringPyramidUpToDate() {
  if (!pyramid_is_old_) return;
  memory_.pyramid.rebuild(memory_.cells);
  pyramid_is_old_ = false;
}

/// Second look at everything visited, with all depths known: it makes the list of visible nodes,
/// and the answer the same whatever was drawn first. False: stopped on the way.
bool ZPyramidWalk::settle(Answer& answer) {
  bringPyramidUpToDate();
  const auto nowHidden = [&](ZPyramidBox& box) {
    return !memory_.pyramid.stillOpen(box.open) && hides(box);
  };
  for (ZPyramidVisit& visit : memory_.visits) {
    if (!mayGoOn()) return false;
    const bool below_hidden =
        visit.parent != ZPyramidVisit::kNoParent && memory_.visits[visit.parent].hidden;
    visit.hidden = below_hidden || nowHidden(visit.box);
    if (!visit.hidden) memory_.visible_in[visit.node] = memory_.frame;
  }
  for (ZPyramidPart& part : memory_.parts) {
    if (!mayGoOn()) return false;
    if (memory_.visits[part.visit].hidden || nowHidden(part.box)) {
      ++stats_.occluded;
    } else {
      keep(part.id, answer);
    }
  }
  memory_.visible_frame = memory_.frame;
  return true;
}

void ZPyramidWalk::keep(ObjectId id, Answer& answer) {
  if (memory_.kept_in[id] == memory_.frame) return;
  memory_.kept_in[id] = memory_.frame;
  answer.visible.push_back(id);
}

/// Primitives against the pyramid: what no box could hide. In the order of ids, so that who is
/// asked does not depend on the walk either.
void ZPyramidWalk::askByTriangles(Answer& answer) {
  if (!ask_triangles_ || !occlusion_) return;
  std::sort(answer.visible.begin(), answer.visible.end());
  const std::uint64_t stake_ns = kStakeNs * answer.visible.size();
  std::size_t kept = 0;
  for (const ObjectId id : answer.visible) {
    const bool pays = asking_ns_ < saved_ns_ + stake_ns;
    const bool hidden = pays && mayGoOn() && hiddenByItsTriangles(id);
    if (hidden) ++stats_.occluded;
    if (!hidden) answer.visible[kept++] = id;
  }
  answer.visible.resize(kept);
}

bool ZPyramidWalk::hiddenByItsTriangles(ObjectId id) {
  const Instance& instance = scene_.instance(id);
  const Mesh& mesh = scene_.mesh(instance.mesh);
  ZPyramidBox box;
  // What an eye in motion may see beside the image has infinite nearness: it stays.
  if (mesh.points_and_lines != 0 || !ownBox(id, box)) return false;
  if (view_.moves && !std::isfinite(box.nearest)) return false;
  const SheetObject object =
      sheetObjectOf(scene_, instance, box.nearest, SheetParts::kAll, memory_.occluder.surfaces);
  const auto worth_ns = static_cast<std::uint64_t>(kObjectPrice.count()) +
                        static_cast<std::uint64_t>(kTrianglePrice.count()) * mesh.triangles.size();
  const OwnTriangleVerdict verdict =
      ownTrianglesHidden(object, asked_view_, eye_world_, deadline_, worth_ns, memory_.cells);
  asking_ns_ += verdict.work_ns;
  if (verdict.hidden) saved_ns_ += worth_ns;
  if (verdict.out_of_time) budget_.stop();
  return verdict.hidden;
}

/// All that is not proven hidden by now.
void ZPyramidWalk::keepTheRest(Answer& answer) {
  std::vector<ObjectId> below;
  for (const ZPyramidVisit& pending : memory_.pending) octree_.appendObjects(pending.node, below);
  for (const ObjectId id : below) keep(id, answer);
  for (const ZPyramidPart& part : memory_.parts) {
    if (!memory_.visits[part.visit].hidden) keep(part.id, answer);
  }
}

}  // namespace culld
