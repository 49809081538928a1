// Edits of an octree: an object is taken out where its old box says that it is, and put in by the
// rules of the build; the boxes above follow. Leaves that overflow are not split: enough edits make
// a new octree.
#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <utility>

#include "culling/spatial/octree.h"
#include "culling/spatial/octree_split.h"
#include "culling/spatial/wide_bvh_fit.h"

namespace culld {
namespace {

bool hasLane(const Instance& instance) {
  return instance.active() && laneClassOf(instance) == LaneClass::kLane;
}

}  // namespace

class OctreeEditor {
 public:
  OctreeEditor(Octree& octree, const SceneSnapshot& scene, const SceneSnapshot& next)
      : octree_(octree), scene_(scene), next_(next) {}

  /// Nodes whose own objects changed, in no order, some of them twice.
  std::vector<std::uint32_t>& touched() { return touched_; }

  void update(ObjectId id) {
    if (id < scene_.objectCount() && hasLane(scene_.instance(id))) {
      remove(Octree::kRoot, id, scene_.instance(id).bounds_world);
    }
    const Instance& instance = next_.instance(id);
    setListed(octree_.always_kept_, id,
              instance.active() && laneClassOf(instance) == LaneClass::kAlwaysKept);
    if (hasLane(instance)) {
      bounds_ = instance.bounds_world;
      octree_.bounds_.grow(bounds_);
      if (octree_.empty()) octree_.nodes_.push_back({bounds_.min, longestSide(bounds_)});
      insert(Octree::kRoot, id, bounds_);
    }
    ++octree_.edits_since_build_;
  }

 private:
  Box boundsOfNode(std::uint32_t index) const {
    const OctreeNode& node = octree_.nodes_[index];
    Box box;
    if (node.children != OctreeNode::kNone) box.grow(boundsOf(octree_.lanes_[node.children]));
    for (std::uint32_t at = node.objects; at != OctreeNode::kNone; at = octree_.next_[at]) {
      box.grow(boundsOf(octree_.lanes_[at]));
    }
    return box;
  }

  /// Sets the box of one lane; the others keep theirs, unless the origin has to move with it.
  void setLane(std::uint32_t at, std::size_t lane, ChildRef child, const Box& box, bool blocking) {
    WideNode& node = octree_.lanes_.mutableAt(at);
    Box boxes[kWideLanes];
    for (std::size_t l = 0; l < kWideLanes; ++l) boxes[l] = l == lane ? box : boundsOfLane(node, l);
    node.child[lane] = child;
    const auto bit = static_cast<std::uint16_t>(1U << lane);
    node.blocking =
        static_cast<std::uint16_t>(blocking ? node.blocking | bit : node.blocking & ~bit);
    fitNode(node, boxes);
  }

  /// REQUIRES: there are children.
  void refitChild(std::uint32_t index, std::uint32_t octant) {
    const std::uint32_t at = octree_.nodes_[index].children;
    const ChildRef child = octree_.lanes_[at].child[octant];
    setLane(at, octant, child, boundsOfNode(child.nodeIndex()), false);
  }

  bool removeHere(std::uint32_t index, ObjectId id) {
    for (std::uint32_t at = octree_.nodes_[index].objects; at != OctreeNode::kNone;
         at = octree_.next_[at]) {
      for (std::size_t l = 0; l < kWideLanes; ++l) {
        if (octree_.lanes_[at].child[l] != ChildRef::object(id)) continue;
        setLane(at, l, ChildRef(), Box{}, false);
        --octree_.lanes_taken_;
        touched_.push_back(index);
        return true;
      }
    }
    return false;
  }

  void remove(std::uint32_t index, ObjectId id, const Box& box) {
    if (removeHere(index, id)) return;
    const OctreeNode node = octree_.nodes_[index];
    if (node.children == OctreeNode::kNone) return;
    std::uint32_t octants = octantsOf(box, node.centre);
    for (; octants != 0; octants &= octants - 1) {
      const auto o = static_cast<std::uint32_t>(std::countr_zero(octants));
      const ChildRef child = octree_.lanes_[node.children].child[o];
      if (child.empty()) continue;
      remove(child.nodeIndex(), id, partIn(box, node.centre, o));
      refitChild(index, o);
    }
  }

  void insert(std::uint32_t index, ObjectId id, const Box& box) {
    const OctreeNode node = octree_.nodes_[index];
    std::uint32_t octants = octantsOf(box, node.centre);
    const bool goes_down =
        node.children != OctreeNode::kNone &&
        (std::has_single_bit(octants) || smallIn(bounds_, node.half_m, octree_.rules_));
    if (!goes_down) {
      insertHere(index, id, box);
      return;
    }
    for (; octants != 0; octants &= octants - 1) {
      const auto o = static_cast<std::uint32_t>(std::countr_zero(octants));
      insert(childAt(index, o), id, partIn(box, node.centre, o));
      refitChild(index, o);
    }
  }

  std::uint32_t childAt(std::uint32_t index, std::uint32_t octant) {
    const OctreeNode node = octree_.nodes_[index];
    const ChildRef child = octree_.lanes_[node.children].child[octant];
    if (!child.empty()) return child.nodeIndex();
    const double quarter = 0.5 * node.half_m;
    OctreeNode fresh;
    for (int axis = 0; axis < 3; ++axis) {
      const bool far = (octant >> axis & 1U) != 0;
      fresh.centre[axis] = node.centre[axis] + (far ? quarter : -quarter);
    }
    fresh.half_m = quarter;
    const auto at = static_cast<std::uint32_t>(octree_.nodes_.size());
    octree_.nodes_.push_back(fresh);
    octree_.lanes_.mutableAt(node.children).child[octant] = ChildRef::node(at);
    return at;
  }

  void insertHere(std::uint32_t index, ObjectId id, const Box& box) {
    ++octree_.lanes_taken_;
    touched_.push_back(index);
    const bool blocking = next_.mesh(next_.instance(id).mesh).blocking_triangles != 0;
    const std::uint32_t first = octree_.nodes_[index].objects;
    for (std::uint32_t at = first; at != OctreeNode::kNone; at = octree_.next_[at]) {
      for (std::size_t l = 0; l < kWideLanes; ++l) {
        if (!octree_.lanes_[at].child[l].empty()) continue;
        setLane(at, l, ChildRef::object(id), box, blocking);
        return;
      }
    }
    const auto fresh = static_cast<std::uint32_t>(octree_.lanes_.size());
    octree_.lanes_.push_back(emptyNode());
    octree_.next_.push_back(first);
    octree_.nodes_.mutableAt(index).objects = fresh;
    setLane(fresh, 0, ChildRef::object(id), box, blocking);
  }

  Octree& octree_;
  const SceneSnapshot& scene_;
  const SceneSnapshot& next_;
  std::vector<std::uint32_t> touched_;
  Box bounds_;  ///< of the object being put in, whole
};

Octree Octree::edited(const SceneSnapshot& scene, const SceneSnapshot& next,
                      std::span<const ObjectId> changed,
                      std::vector<std::uint32_t>* touched) const {
  std::vector<ObjectId> ids(changed.begin(), changed.end());
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  constexpr std::size_t kFewEdits = 1024;  // and else not more than a quarter of the objects
  if (edits_since_build_ + ids.size() > kFewEdits + objects_ / 4) {
    Octree fresh = of(next, rules_);
    if (touched != nullptr) {
      touched->resize(fresh.nodeCount());
      std::iota(touched->begin(), touched->end(), 0U);
    }
    return fresh;
  }
  Octree octree = *this;
  OctreeEditor editor(octree, scene, next);
  for (const ObjectId id : ids) editor.update(id);
  if (touched != nullptr) {
    *touched = std::move(editor.touched());
    std::sort(touched->begin(), touched->end());
    touched->erase(std::unique(touched->begin(), touched->end()), touched->end());
  }
  return octree;
}

}  // namespace culld
