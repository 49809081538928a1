#include "culling/spatial/frustum_walk.h"

#include <algorithm>
#include <bit>

namespace culld {

namespace {

constexpr std::uint64_t kFrameNs = 500, kNodeNs = 50, kAnsweredNs = 4;  // measured

struct Entry {
  std::uint32_t node;
  PlaneMask planes;
};

/// Plane after plane until all of the node is out; the same verdicts as all at once.
LaneVerdicts testCoherently(const FrustumTest& frustum, const WideNode& node, PlaneMask planes,
                            std::uint8_t& best, std::uint64_t& tests) {
  LaneVerdicts all;
  all.may_intersect = node.live;
  int most = -1;
  const std::uint32_t first = best;
  for (std::uint32_t i = 0; i <= kMaxPlanes && all.may_intersect != 0; ++i) {
    const std::uint32_t p = i == 0 ? first : i - 1;  // the best one, then the others
    if ((i > 0 && p == first) || (planes >> p & 1U) == 0) continue;
    const auto plane = static_cast<PlaneMask>(1U << p);
    const LaneVerdicts one = frustum.test(node, plane);
    tests += static_cast<std::uint64_t>(std::popcount(node.live));
    const int out = std::popcount(node.live & ~one.may_intersect);
    if (out > most) {
      most = out;
      best = static_cast<std::uint8_t>(p);
    }
    all.may_intersect &= one.may_intersect;
    all.tested = static_cast<PlaneMask>(all.tested | plane);
    all.inside[p] = one.inside[p];
  }
  return all;
}

class FrustumWalk {
 public:
  FrustumWalk(const WideBvh& bvh, const FrustumTest& frustum, const FrustumParts& parts,
              std::vector<ObjectId>& out)
      : bvh_(bvh), frustum_(frustum), parts_(parts), out_(out) {
    if (parts.coherence != nullptr) {
      parts.coherence->best_plane.resize(bvh.nodeCount(), FrustumCoherence::kNone);
    }
  }

  FrustumWalkStats run(const Deadline& deadline) {
    constexpr std::uint32_t kNodesPerLook = 64;  // a look at the clock costs about one node
    for (auto root = static_cast<std::uint32_t>(bvh_.rootCount()); root-- > 0;) {
      stack_.push_back({root, frustum_.planes()});
    }
    while (!stack_.empty()) {
      const Entry entry = stack_.back();
      stack_.pop_back();
      if (stats_.nodes_visited % kNodesPerLook == 0) stats_.out_of_time |= deadline.passed();
      if (entry.planes == 0 || stats_.out_of_time) {
        bvh_.appendObjects(entry.node, out_);
      } else {
        visit(entry);
      }
    }
    return stats_;
  }

 private:
  void visit(const Entry& entry) {
    ++stats_.nodes_visited;
    const WideNode& node = bvh_.node(entry.node);
    const LaneVerdicts verdicts = test(node, entry);
    for (std::uint32_t lanes = node.live; lanes != 0; lanes &= lanes - 1) {
      const auto lane = static_cast<std::size_t>(std::countr_zero(lanes));
      const ChildRef child = node.child[lane];
      const bool may_intersect = (verdicts.may_intersect >> lane & 1U) != 0;
      if (child.isObject()) {
        ++stats_.tested;
        if (may_intersect && !outsideItself(child.objectId(), verdicts, lane)) {
          out_.push_back(child.objectId());
        }
      } else if (may_intersect) {
        PlaneMask planes = parts_.masking ? verdicts.planesLeft(lane) : frustum_.planes();
        if (parts_.octants) planes = frustum_.inOctant(node, lane, planes, stats_.plane_tests);
        stack_.push_back({child.nodeIndex(), planes});
      }
    }
  }

  LaneVerdicts test(const WideNode& node, const Entry& entry) {
    if (parts_.coherence != nullptr) {
      std::uint8_t& best = parts_.coherence->best_plane[entry.node];
      return testCoherently(frustum_, node, entry.planes, best, stats_.plane_tests);
    }
    stats_.plane_tests +=
        static_cast<std::uint64_t>(std::popcount(entry.planes) * std::popcount(node.live));
    return frustum_.test(node, entry.planes);
  }

  /// By the box of its mesh, where that is tighter than its bounds.
  bool outsideItself(ObjectId id, const LaneVerdicts& verdicts, std::size_t lane) {
    if (parts_.oriented == nullptr) return false;
    const PlaneMask planes = verdicts.planesLeft(lane);
    const Instance& instance = parts_.oriented->instance(id);
    if (planes == 0 || !turned(instance.world_from_mesh)) return false;
    const OrientedBox box =
        orientedBox(instance.world_from_mesh, parts_.oriented->mesh(instance.mesh).bounds);
    return frustum_.outside(box, planes, parts_.sphere, stats_.plane_tests);
  }

  const WideBvh& bvh_;
  const FrustumTest& frustum_;
  const FrustumParts& parts_;
  std::vector<ObjectId>& out_;
  std::vector<Entry> stack_;
  FrustumWalkStats stats_;
};

}  // namespace

std::chrono::nanoseconds FrustumWalkStats::work(std::size_t answered) const noexcept {
  return std::chrono::nanoseconds(kFrameNs + kNodeNs * nodes_visited + kAnsweredNs * answered);
}

FrustumWalkStats appendInFrustum(const WideBvh& bvh, const FrustumTest& frustum,
                                 const Deadline& deadline, std::vector<ObjectId>& out,
                                 const FrustumParts& parts) {
  return FrustumWalk(bvh, frustum, parts, out).run(deadline);
}

std::uint32_t countInFrustum(const WideBvh& bvh, const FrustumTest& frustum, std::uint32_t index,
                             PlaneMask planes) {
  if (planes == 0) return bvh.node(index).live_objects;
  const WideNode& node = bvh.node(index);
  const LaneVerdicts verdicts = frustum.test(node, planes);
  std::uint32_t count = 0;
  for (std::uint32_t lanes = verdicts.may_intersect; lanes != 0; lanes &= lanes - 1) {
    const auto lane = static_cast<std::size_t>(std::countr_zero(lanes));
    const ChildRef child = node.child[lane];
    count += child.isObject()
                 ? 1
                 : countInFrustum(bvh, frustum, child.nodeIndex(), verdicts.planesLeft(lane));
  }
  return count;
}

void sortIds(std::vector<ObjectId>& ids, std::size_t limit) {
  // Marking bits and reading them out beats sorting once about one id in 1024 is there.
  if (ids.size() < limit / 1024) {
    std::sort(ids.begin(), ids.end());
    return;
  }
  std::vector<std::uint64_t> words((limit + 63) / 64, 0);
  for (const ObjectId id : ids) words[id / 64] |= std::uint64_t{1} << (id % 64);
  ids.clear();
  for (std::size_t w = 0; w < words.size(); ++w) {
    for (std::uint64_t word = words[w]; word != 0; word &= word - 1) {
      ids.push_back(
          static_cast<ObjectId>(w * 64 + static_cast<std::size_t>(std::countr_zero(word))));
    }
  }
}

}  // namespace culld
