#include "culling/spatial/octree.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "culling/spatial/octree_split.h"
#include "culling/spatial/wide_bvh_fit.h"

namespace culld {

class OctreeBuilder {
 public:
  OctreeBuilder(Octree& out, const SceneSnapshot& scene) : out_(out), scene_(scene) {}

  void build() {
    std::vector<Part> parts;
    for (std::size_t i = 0; i < scene_.objectCount(); ++i) {
      const auto id = static_cast<ObjectId>(i);
      const Instance& instance = scene_.instance(id);
      if (!instance.active()) continue;
      const LaneClass lane_class = laneClassOf(instance);
      if (lane_class == LaneClass::kAlwaysKept) out_.always_kept_.push_back(id);
      if (lane_class != LaneClass::kLane) continue;
      out_.bounds_.grow(instance.bounds_world);
      parts.push_back({id, instance.bounds_world});
    }
    out_.objects_ = parts.size();
    most_lanes_ = kLanesPerObject * parts.size();
    lanes_expected_ = parts.size();
    if (parts.empty()) return;
    const Box& all = out_.bounds_;
    Cube cube{0.5 * all.min + 0.5 * all.max, 0.5 * longestSide(all)};
    addNode(std::move(parts), cube, 0);
  }

 private:
  static constexpr std::size_t kLanesPerObject = 4;
  static constexpr std::uint32_t kDeepest = 48;

  /// An object, or what of it lies in an octant.
  struct Part {
    ObjectId id;
    Box box;
  };
  struct Cube {
    glm::dvec3 centre;
    double half_m;
    Cube octant(std::uint32_t o) const {
      const double quarter = 0.5 * half_m;
      return {centre + glm::dvec3((o & 1U) != 0 ? quarter : -quarter,
                                  (o & 2U) != 0 ? quarter : -quarter,
                                  (o & 4U) != 0 ? quarter : -quarter),
              quarter};
    }
  };

  /// Splits as long as it brings something. Returns the node.
  std::uint32_t addNode(std::vector<Part> parts, Cube cube, std::uint32_t depth) {
    const auto index = static_cast<std::uint32_t>(out_.nodes_.size());
    out_.nodes_.push_back({});
    std::vector<Part> below[8];
    std::vector<Part> here = split(std::move(parts), cube, depth, below);
    OctreeNode node{cube.centre, cube.half_m, OctreeNode::kNone, addObjects(here)};
    here = {};
    WideNode children = emptyNode();
    Box boxes[kWideLanes];
    bool split_up = false;
    for (std::uint32_t o = 0; o < 8; ++o) {
      if (below[o].empty()) continue;
      split_up = true;
      for (const Part& part : below[o]) boxes[o].grow(part.box);
      children.child[o] = ChildRef::node(addNode(std::move(below[o]), cube.octant(o), depth + 1));
    }
    if (split_up) {
      fitNode(children, boxes);
      node.children = addLanes(children, OctreeNode::kNone);
    }
    out_.nodes_.mutableAt(index) = node;
    return index;
  }

  /// Shares out `parts` among the octants; returns those that stay. Moves `cube` down while all of
  /// them are in one octant.
  std::vector<Part> split(std::vector<Part> parts, Cube& cube, std::uint32_t& depth,
                          std::vector<Part> (&below)[8]) {
    while (depth < kDeepest && parts.size() > out_.rules_.leaf_objects &&
           std::isfinite(cube.half_m) && cube.half_m > 0.0) {
      std::uint32_t common = 0xFFU;
      for (const Part& part : parts) common &= octantsIfAlone(part, cube);
      if (std::has_single_bit(common)) {
        cube = cube.octant(static_cast<std::uint32_t>(std::countr_zero(common)));
        ++depth;
        continue;
      }
      return shareOut(parts, cube, below);
    }
    return parts;
  }

  static std::uint32_t octantsIfAlone(const Part& part, const Cube& cube) {
    const std::uint32_t octants = octantsOf(part.box, cube.centre);
    return std::has_single_bit(octants) ? octants : 0;
  }

  std::vector<Part> shareOut(const std::vector<Part>& parts, const Cube& cube,
                             std::vector<Part> (&below)[8]) {
    std::vector<Part> here;
    for (const Part& part : parts) {
      std::uint32_t octants = octantsOf(part.box, cube.centre);
      const auto copies = static_cast<std::size_t>(std::popcount(octants)) - 1;
      const bool goes_down = copies == 0 || (smallIn(scene_.instance(part.id).bounds_world,
                                                     cube.half_m, out_.rules_) &&
                                             lanes_expected_ + copies <= most_lanes_);
      if (!goes_down) {
        here.push_back(part);
        continue;
      }
      lanes_expected_ += copies;
      for (; octants != 0; octants &= octants - 1) {
        const auto o = static_cast<std::uint32_t>(std::countr_zero(octants));
        below[o].push_back({part.id, partIn(part.box, cube.centre, o)});
      }
    }
    return here;
  }

  std::uint32_t addObjects(const std::vector<Part>& parts) {
    std::uint32_t first = OctreeNode::kNone;
    for (std::size_t begin = 0; begin < parts.size(); begin += kWideLanes) {
      WideNode lanes = emptyNode();
      Box boxes[kWideLanes];
      std::uint32_t blocking = 0;
      const std::size_t count = std::min(kWideLanes, parts.size() - begin);
      for (std::size_t l = 0; l < count; ++l) {
        const Part& part = parts[begin + l];
        lanes.child[l] = ChildRef::object(part.id);
        boxes[l] = part.box;
        const Mesh& mesh = scene_.mesh(scene_.instance(part.id).mesh);
        blocking |= (mesh.blocking_triangles != 0 ? 1U : 0U) << l;
      }
      fitNode(lanes, boxes);
      lanes.blocking = static_cast<std::uint16_t>(blocking);
      out_.lanes_taken_ += count;
      first = addLanes(lanes, first);
    }
    return first;
  }

  std::uint32_t addLanes(const WideNode& lanes, std::uint32_t next) {
    out_.lanes_.push_back(lanes);
    out_.next_.push_back(next);
    return static_cast<std::uint32_t>(out_.lanes_.size() - 1);
  }

  Octree& out_;
  const SceneSnapshot& scene_;
  std::size_t most_lanes_ = 0, lanes_expected_ = 0;
};

Octree Octree::of(const SceneSnapshot& scene, const OctreeRules& rules) {
  Octree octree;
  octree.rules_ = rules;
  OctreeBuilder(octree, scene).build();
  octree.nodes_.shrinkToFit();
  octree.lanes_.shrinkToFit();
  octree.next_.shrinkToFit();
  return octree;
}

void Octree::appendObjects(std::uint32_t index, std::vector<ObjectId>& out) const {
  std::vector<std::uint32_t> stack{index};
  while (!stack.empty()) {
    const OctreeNode& node = nodes_[stack.back()];
    stack.pop_back();
    for (std::uint32_t at = node.objects; at != OctreeNode::kNone; at = next_[at]) {
      for (std::uint32_t live = lanes_[at].live; live != 0; live &= live - 1) {
        out.push_back(lanes_[at].child[std::countr_zero(live)].objectId());
      }
    }
    if (node.children == OctreeNode::kNone) continue;
    const WideNode& children = lanes_[node.children];
    for (std::uint32_t live = children.live; live != 0; live &= live - 1) {
      stack.push_back(children.child[std::countr_zero(live)].nodeIndex());
    }
  }
}

std::size_t Octree::bytes() const noexcept {
  return nodes_.bytes() + lanes_.bytes() + next_.bytes() +
         always_kept_.capacity() * sizeof(ObjectId);
}

std::size_t Octree::chunksNotSharedWith(const Octree& other) const noexcept {
  std::size_t count = 0;
  for (std::size_t c = 0; c < nodes_.chunkCount(); ++c) {
    if (!nodes_.sharesChunk(c, other.nodes_)) ++count;
  }
  for (std::size_t c = 0; c < lanes_.chunkCount(); ++c) {
    if (!lanes_.sharesChunk(c, other.lanes_)) ++count;
  }
  return count;
}

}  // namespace culld
