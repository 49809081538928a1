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

}  // namespace

std::chrono::nanoseconds FrustumWalkStats::work(std::size_t answered) const noexcept {
  return std::chrono::nanoseconds(kFrameNs + kNodeNs * nodes_visited + kAnsweredNs * answered);
}

FrustumWalkStats appendInFrustum(const WideBvh& bvh, const FrustumTest& frustum,
                                 const Deadline& deadline, std::vector<ObjectId>& out) {
  constexpr std::uint32_t kNodesPerLook = 64;  // a look at the clock costs about one node
  FrustumWalkStats stats;
  std::vector<Entry> stack;
  for (auto root = static_cast<std::uint32_t>(bvh.rootCount()); root-- > 0;) {
    stack.push_back({root, frustum.planes()});
  }
  while (!stack.empty()) {
    const Entry entry = stack.back();
    stack.pop_back();
    if (stats.nodes_visited % kNodesPerLook == 0) stats.out_of_time |= deadline.passed();
    if (entry.planes == 0 || stats.out_of_time) {
      bvh.appendObjects(entry.node, out);
      continue;
    }
    ++stats.nodes_visited;
    const WideNode& node = bvh.node(entry.node);
    const LaneVerdicts verdicts = frustum.test(node, entry.planes);
    for (std::uint32_t lanes = node.live; lanes != 0; lanes &= lanes - 1) {
      const auto lane = static_cast<std::size_t>(std::countr_zero(lanes));
      const ChildRef child = node.child[lane];
      const bool may_intersect = (verdicts.may_intersect >> lane & 1U) != 0;
      if (child.isObject()) {
        ++stats.tested;
        if (may_intersect) out.push_back(child.objectId());
      } else if (may_intersect) {
        stack.push_back({child.nodeIndex(), verdicts.planesLeft(lane)});
      }
    }
  }
  return stats;
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
