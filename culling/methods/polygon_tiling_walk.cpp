#include "culling/methods/polygon_tiling_walk.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "culling/occluders/image_walk.h"
#include "culling/raster/box_cells.h"
#include "culling/spatial/octree_split.h"
#include "culling/spatial/wide_bvh_fit.h"

namespace culld {
namespace {

// Choices of what to tile: they cost or save time and never change what an answer promises.
constexpr std::uint32_t kMostTilings = 4;  ///< of one object, as more of it is passed

// Nanoseconds of counted work: rough.
constexpr std::uint64_t kFrameNs = 20'000, kNodeNs = 300, kMaskNs = 6;

/// What of `box` is not in `region`, in boxes. What lies on an upper side of a region belongs to
/// the one beyond it. Returns how many.
std::size_t partsOutside(const Box& box, const Box& region, std::array<Box, 6>& out) {
  std::size_t count = 0;
  for (int axis = 0; axis < 3; ++axis) {
    if (box.min[axis] < region.min[axis]) {
      out[count] = box;
      out[count].max[axis] = std::min(box.max[axis], region.min[axis]);
      ++count;
    }
    if (!(box.max[axis] < region.max[axis]) && !std::isinf(region.max[axis])) {
      out[count] = box;
      out[count].min[axis] = std::max(box.min[axis], region.max[axis]);
      ++count;
    }
  }
  return count;
}

/// An object is met once in each group in which it has a part.
void makeUnique(std::vector<ObjectId>& ids) {
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
}

Box everywhere() {
  constexpr double kInf = std::numeric_limits<double>::infinity();
  return {glm::dvec3(-kInf), glm::dvec3(kInf)};
}

/// The view of a camera that stands still at the pose's centre.
Camera still(const Camera& camera) {
  Camera out = camera;
  out.motion = MotionBound{};
  return out;
}

}  // namespace

ViewSide viewSide(const Camera& camera) noexcept {
  ViewSide side;
  side.perspective = camera.perspective;
  side.eye = camera.origin_world;
  side.known = camera.motion.still();
  if (camera.perspective) return side;
  // The direction of all rays is perpendicular to the rows of the image's axes.
  const glm::dvec3 u(camera.x_row), v(camera.y_row), n(camera.near_row);
  constexpr double kSlack = 0x1p-50;
  double nearer = 0.0, terms = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    const int i = (axis + 1) % 3, j = (axis + 2) % 3;
    const double a = u[i] * v[j], b = u[j] * v[i], size = std::abs(a) + std::abs(b);
    side.toward_eye[axis] = a - b;
    // Exactly 0, or certainly not.
    side.known = side.known && (size == 0.0 || std::abs(a - b) > kSlack * size);
    nearer += n[axis] * side.toward_eye[axis];
    terms += std::abs(n[axis]) * size;
  }
  side.known = side.known && std::abs(nearer) > kSlack * terms && std::isfinite(terms);
  if (nearer < 0.0) side.toward_eye = -side.toward_eye;
  return side;
}

PolygonTilingWalk::PolygonTilingWalk(const PolygonTilingScene& scene, const OccluderSet& occluders,
                                     std::uint32_t levels, const Camera& camera,
                                     const Deadline& deadline, const Demand& demand,
                                     PolygonTilingMemory& memory)
    : scene_(scene),
      occluders_(occluders),
      levels_(levels),
      budget_(deadline, demand.work),
      memory_(memory),
      side_(viewSide(camera)),
      frustum_(camera, scene.octree().bounds()),
      view_(cellView(still(camera), gridFor(camera))),
      box_view_(boxView(view_)),
      eye_world_(camera.origin_world),
      drawing_(scene.snapshot(), occluders, view_, eye_world_, deadline, memory.occluder) {}

void PolygonTilingWalk::beginFrame() {
  if (++memory_.frame == 0) {  // after 2^32 frames old marks could be mistaken for this frame's
    memory_.kept_in.clear();
    memory_.frame = 1;
  }
  const std::size_t objects = scene_.snapshot().objectCount();
  if (memory_.kept_in.size() < objects) memory_.kept_in.resize(objects, 0);
  memory_.coverage.reset(view_.grid);
  memory_.tilings.clear();
}

std::uint64_t PolygonTilingWalk::countedNs() const {
  return kFrameNs + kNodeNs * stats_.nodes_visited + kMaskNs * memory_.coverage.masksCompared();
}

void PolygonTilingWalk::run(Answer& answer) {
  answer_ = &answer;
  beginFrame();
  Ids met;
  if (!scene_.octree().empty()) takeNode(Octree::kRoot, everywhere(), frustum_.planes(), met);
  stats_.depth_comparisons = memory_.coverage.masksCompared();
  stats_.work = budget_.work(countedNs());
  answer.stats = stats_;
  answer.out_of_budget = budget_.stopped();
}

void PolygonTilingWalk::keep(ObjectId id) {
  if (memory_.kept_in[id] == memory_.frame) return;
  memory_.kept_in[id] = memory_.frame;
  answer_->visible.push_back(id);
}

/// All that was met before lies before everything in the box: that it covers is enough.
bool PolygonTilingWalk::covered(const CellRect& rect, float nearest) {
  return side_.known && std::isfinite(nearest) && memory_.coverage.covers(rect, levels_);
}

void PolygonTilingWalk::takeNode(std::uint32_t index, const Box& region, PlaneMask planes,
                                 Ids& met) {
  const Octree& octree = scene_.octree();
  if (!mayGoOn()) {
    Ids below;
    octree.appendObjects(index, below);
    for (const ObjectId id : below) keep(id);
    return;
  }
  ++stats_.nodes_visited;
  const OctreeNode& node = octree.node(index);
  const BspTree& tree = scene_.tree(index);
  const bool leaf = node.children == OctreeNode::kNone;
  // Of a node that is split, its own objects are before none of what is in its octants.
  Ids here;
  if (!tree.empty()) takeTree(tree, 0, region, planes, leaf, leaf ? met : here);
  if (leaf) return;
  const WideNode& lanes = octree.lanes(node.children);
  const LaneVerdicts verdicts = frustum_.test(lanes, planes);
  BoxRects rects;
  projectBoxes(box_view_, originFrom(lanes, eye_world_), lanes.offsets, rects);
  std::uint32_t nearest = 0;
  for (int axis = 0; axis < 3; ++axis) {
    if (side_.highFirst(axis, node.centre[axis])) nearest |= 1U << axis;
  }
  constexpr std::uint32_t kNearestFirst[8] = {0, 1, 2, 4, 3, 5, 6, 7};  // by planes between
  std::uint32_t passed = 0;
  for (const std::uint32_t across : kNearestFirst) {
    const std::uint32_t o = nearest ^ across;
    const std::uint32_t off_grid = side_.known ? rects.off_grid : 0;
    const bool seen = ((verdicts.may_intersect & ~off_grid) >> o & 1U) != 0;
    if (seen && !covered(cellRect(rects, o, view_.grid), rects.nearest[o])) {
      takeNode(lanes.child[o].nodeIndex(), partIn(region, node.centre, o), verdicts.planesLeft(o),
               here);
    }
    passed |= 1U << o;
    tileAfterOctant(region, node.centre, o, passed, here);
  }
  met.insert(met.end(), here.begin(), here.end());
}

void PolygonTilingWalk::takeTree(const BspTree& tree, std::uint32_t index, const Box& region,
                                 PlaneMask planes, bool tile, Ids& met) {
  const BspNode& node = tree.node(index);
  if (node.axis == BspNode::kGroup) {
    Ids here;
    takeGroup(tree, node, planes, here);
    if (tile) tileAfterRegion(region, node, here);
    met.insert(met.end(), here.begin(), here.end());
    return;
  }
  const int axis = node.axis;
  Box low = region, high = region;
  low.max[axis] = std::min(low.max[axis], node.plane);
  high.min[axis] = std::max(high.min[axis], node.plane);
  const bool high_first = side_.highFirst(axis, node.plane);
  Ids here;
  takeTree(tree, node.below[high_first ? 1 : 0], high_first ? high : low, planes, tile, here);
  takeTree(tree, node.below[high_first ? 0 : 1], high_first ? low : high, planes, tile, here);
  if (tile) tileAfterRegion(region, node, here);
  met.insert(met.end(), here.begin(), here.end());
}

/// First everything is asked, then what blocks is met: within a group there is no order.
void PolygonTilingWalk::takeGroup(const BspTree& tree, const BspNode& group, PlaneMask planes,
                                  Ids& met) {
  for (std::uint32_t at = group.below[0]; at < group.below[1]; ++at) {
    const WideNode& lanes = tree.lanes(at);
    const LaneVerdicts verdicts = frustum_.test(lanes, planes);
    BoxRects rects;
    projectBoxes(box_view_, originFrom(lanes, eye_world_), lanes.offsets, rects);
    stats_.tested += static_cast<std::uint32_t>(std::popcount(std::uint32_t{lanes.live}));
    std::uint32_t left = verdicts.may_intersect & ~(side_.known ? rects.off_grid : 0U);
    for (; left != 0; left &= left - 1) {
      const auto l = static_cast<std::size_t>(std::countr_zero(left));
      const ObjectId id = lanes.child[l].objectId();
      if (covered(cellRect(rects, l, view_.grid), rects.nearest[l])) {
        ++stats_.occluded;
        continue;
      }
      keep(id);
      if (side_.known && (lanes.blocking >> l & 1U) != 0) met.push_back(id);
    }
  }
}

/// What is no farther behind a surface than this is level with it (docs/oracle.md), and may lie
/// just across a plane: the object counts as reaching there.
Box PolygonTilingWalk::withTies(Box box) const {
  constexpr double kTie = 0x1p-36;  // of the distance
  double distance = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    distance = std::max({distance, std::abs(box.min[axis] - eye_world_[axis]),
                         std::abs(box.max[axis] - eye_world_[axis])});
  }
  return {box.min - kTie * distance, box.max + kTie * distance};
}

/// All of `region` is behind the walk: what was met there is tiled as far as it lies there, and
/// taken out if that is all of it. Only what `cut`, the node's plane, divides shows more of itself
/// than it did before.
void PolygonTilingWalk::tileAfterRegion(const Box& region, const BspNode& cut, Ids& met) {
  makeUnique(met);
  std::size_t left = 0;
  for (const ObjectId id : met) {
    const Box bounds = withTies(scene_.snapshot().instance(id).bounds_world);
    std::array<Box, 6> outside;
    const std::size_t count = partsOutside(bounds, region, outside);
    const bool group = cut.axis == BspNode::kGroup;
    const bool shows_more =
        group || (bounds.min[cut.axis] < cut.plane && !(bounds.max[cut.axis] < cut.plane));
    if (shows_more) tile(id, {outside.data(), count});
    if (count != 0) met[left++] = id;
  }
  met.resize(left);
}

/// The same after one octant of a region, for what is in several of them.
void PolygonTilingWalk::tileAfterOctant(const Box& region, const glm::dvec3& centre,
                                        std::uint32_t octant, std::uint32_t passed, Ids& met) {
  makeUnique(met);
  std::size_t left = 0;
  for (const ObjectId id : met) {
    const Box bounds = withTies(scene_.snapshot().instance(id).bounds_world);
    std::array<Box, 6> outside;
    std::array<Box, 14> to_come;
    std::size_t count = partsOutside(bounds, region, outside);
    std::copy_n(outside.begin(), count, to_come.begin());
    const std::uint32_t in = octantsOf(bounds, centre);
    for (std::uint32_t o = in & ~passed; o != 0; o &= o - 1) {
      const auto next = static_cast<std::uint32_t>(std::countr_zero(o));
      to_come[count++] = partIn(bounds, centre, next);
    }
    const bool shows_more = (in >> octant & 1U) != 0 && !std::has_single_bit(in);
    if (shows_more) tile(id, {to_come.data(), count});
    if (count != 0) met[left++] = id;
  }
  met.resize(left);
}

/// Covers the cells in which the object surely hides what is behind it, but for those where that
/// may be a part which is still to come.
void PolygonTilingWalk::tile(ObjectId id, std::span<const Box> to_come) {
  if (budget_.stopped()) return;
  const auto tilings = memory_.tilings.try_emplace(id, 0U).first;
  if (tilings->second == kMostTilings) return;
  const Instance& instance = scene_.snapshot().instance(id);
  CellRect rect{};
  float nearest = 0.0F;
  if (!cellsOf(instance.bounds_world, rect, nearest)) return;
  if (!worthDrawing(rect, occluders_.mesh(instance.mesh))) return;
  if (memory_.coverage.covers(rect, levels_)) return;
  memory_.except.clear();
  std::uint64_t left_out = 0;
  for (const Box& box : to_come) {
    CellRect cells{};
    float unused = 0.0F;
    if (!cellsOf(box, cells, unused)) continue;
    const bool all =
        cells.x0 <= rect.x0 && cells.x1 >= rect.x1 && cells.y0 <= rect.y0 && cells.y1 >= rect.y1;
    if (all) return;
    memory_.except.push_back(cells);
    left_out = std::max(left_out, CellRect{std::max(cells.x0, rect.x0), std::min(cells.x1, rect.x1),
                                           std::max(cells.y0, rect.y0), std::min(cells.y1, rect.y1)}
                                      .cells());
  }
  // The first time for a quarter of its cells, the last for all.
  if (kMostTilings * left_out > (kMostTilings - 1 - tilings->second) * rect.cells()) return;
  ++tilings->second;
  ++stats_.occluders_drawn;
  memory_.cells.reset(view_.grid);
  const DrawnOccluder drawn =
      drawing_.draw(instance, nearest, budget_.leftNs(countedNs()), memory_.cells);
  stats_.triangles_drawn += drawn.triangles;
  budget_.drew(drawn);
  memory_.coverage.update(memory_.cells, rect, memory_.except);
}

/// The cells that a box may be on. False: surely none.
bool PolygonTilingWalk::cellsOf(const Box& box, CellRect& rect, float& nearest) const {
  return projectBox(box_view_, eye_world_, view_.grid, box, rect, nearest);
}

}  // namespace culld
