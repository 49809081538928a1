// Builds full nodes top-down: a subtree of height h takes 8^h objects, all but the last of its
// siblings take exactly that many, and among the splits which allow it the one with the smallest
// binned surface-area cost is taken. All decisions are by (coordinate, id): a total order.
#include <algorithm>
#include <array>
#include <bit>

#include "culling/core/parallel.h"
#include "culling/spatial/wide_bvh.h"
#include "culling/spatial/wide_bvh_fit.h"

namespace culld {
namespace {

/// An object while splitting: its box in scene units (-1..1), good enough to choose splits by.
struct Item {
  std::array<float, 3> low, high;
  ObjectId id;
  float centre(std::size_t axis) const { return low[axis] + high[axis]; }
};

struct Extent {
  std::array<float, 3> low{INFINITY, INFINITY, INFINITY};
  std::array<float, 3> high{-INFINITY, -INFINITY, -INFINITY};
  void grow(const std::array<float, 3>& l, const std::array<float, 3>& h) {
    for (std::size_t a = 0; a < 3; ++a) {
      low[a] = std::min(low[a], l[a]);
      high[a] = std::max(high[a], h[a]);
    }
  }
  float halfArea() const {
    const float x = high[0] - low[0], y = high[1] - low[1], z = high[2] - low[2];
    return x < 0.0F ? 0.0F : x * y + y * z + z * x;
  }
};

/// Objects that each lane of a node over `count` objects takes: 8^(height - 1).
std::size_t laneCapacity(std::size_t count) {
  std::size_t capacity = 1;
  while (capacity * kWideLanes < count) capacity *= kWideLanes;
  return capacity;
}

/// Nodes of the subtree over `count` objects; one object is a lane and no node.
std::size_t nodesFor(std::size_t count) {
  if (count <= 1) return 0;
  if (count <= kWideLanes) return 1;
  const std::size_t capacity = laneCapacity(count);
  const std::size_t full = count / capacity;
  return 1 + full * ((capacity - 1) / 7) + nodesFor(count % capacity);
}

struct Split {
  std::size_t axis = 0, groups_left = 0;
};

constexpr std::size_t kBins = 16;
struct Bin {
  Extent extent;
  std::size_t count = 0;
};

/// Cost of the best split of `groups` lanes along one axis, found from bins of centres.
void considerAxis(const std::array<Bin, kBins>& bins, std::size_t axis, std::size_t groups,
                  std::size_t capacity, float& best_cost, Split& best) {
  std::array<Extent, kBins> right;  // right[b]: bins b..end
  Extent sweep;
  for (std::size_t b = kBins; b-- > 0;) {
    sweep.grow(bins[b].extent.low, bins[b].extent.high);
    right[b] = sweep;
  }
  Extent left;
  std::size_t below = 0, b = 0;
  for (std::size_t k = 1; k < groups; ++k) {
    while (b < kBins && below + bins[b].count <= k * capacity) {
      left.grow(bins[b].extent.low, bins[b].extent.high);
      below += bins[b++].count;
    }
    Extent left_k = left;  // a bin that the split cuts counts on both sides
    if (b < kBins && below < k * capacity) left_k.grow(bins[b].extent.low, bins[b].extent.high);
    const float right_area = b < kBins ? right[b].halfArea() : 0.0F;
    const float cost =
        left_k.halfArea() * static_cast<float>(k) + right_area * static_cast<float>(groups - k);
    if (cost < best_cost) {
      best_cost = cost;
      best = {axis, k};
    }
  }
}

Split chooseSplit(std::span<const Item> items, std::size_t groups, std::size_t capacity) {
  Extent centres;
  for (const Item& item : items) {
    const std::array<float, 3> c{item.centre(0), item.centre(1), item.centre(2)};
    centres.grow(c, c);
  }
  std::array<std::array<Bin, kBins>, 3> bins{};
  std::array<float, 3> scale{};
  for (std::size_t a = 0; a < 3; ++a) {
    const float width = centres.high[a] - centres.low[a];
    scale[a] = width > 0.0F ? 0.999F * static_cast<float>(kBins) / width : 0.0F;
    if (!(scale[a] < 1e30F)) scale[a] = 0.0F;
  }
  for (const Item& item : items) {
    for (std::size_t a = 0; a < 3; ++a) {
      const float at = (item.centre(a) - centres.low[a]) * scale[a];
      Bin& bin = bins[a][std::min(kBins - 1, static_cast<std::size_t>(at))];
      bin.extent.grow(item.low, item.high);
      ++bin.count;
    }
  }
  Split best{0, groups / 2};
  float best_cost = INFINITY;
  for (std::size_t a = 0; a < 3; ++a) {
    if (scale[a] > 0.0F) considerAxis(bins[a], a, groups, capacity, best_cost, best);
  }
  return best;
}

}  // namespace

class WideBvhBuilder {
 public:
  WideBvhBuilder(const SceneSnapshot& scene, std::size_t threads)
      : scene_(scene), threads_(threads) {}

  WideBvh runFlat() {
    WideBvh bvh;
    bvh.flat_ = true;
    collect(bvh);
    std::erase_if(items_, [this](const Item& item) { return !scene_.instance(item.id).active(); });
    bvh.lanes_taken_ = items_.size();
    std::vector<std::span<Item>> groups;
    if (!items_.empty()) divide(items_, kWideLanes, groups);
    for (const std::span<Item> group : groups) {
      WideNode node = emptyNode();
      for (std::size_t l = 0; l < group.size(); ++l) node.child[l] = ChildRef::object(group[l].id);
      fitNode(node, scene_, [&node](std::uint32_t) -> const WideNode& { return node; });
      bvh.nodes_.push_back(node);
      bvh.parent_of_.push_back(WideBvh::kNoLane);
    }
    bvh.nodes_.shrinkToFit();
    return bvh;
  }

  WideBvh run() {
    WideBvh bvh;
    collect(bvh);
    bvh.lanes_taken_ = items_.size();
    lane_of_.assign(scene_.objectCount(), WideBvh::kNoLane);
    if (!items_.empty()) {
      nodes_.resize(std::max<std::size_t>(1, nodesFor(items_.size())));
      parent_of_.resize(nodes_.size());
      buildNodes();
    }
    for (const WideNode& node : nodes_) bvh.nodes_.push_back(node);
    for (const std::uint32_t lane : parent_of_) bvh.parent_of_.push_back(lane);
    for (std::uint32_t lane : lane_of_) bvh.lane_of_.push_back(lane);
    return bvh;
  }

 private:
  struct Job {
    std::uint32_t node, parent;
    std::span<Item> items;
  };

  void collect(WideBvh& bvh) {
    Box all;
    for (std::size_t i = 0; i < scene_.objectCount(); ++i) {
      const auto id = static_cast<ObjectId>(i);
      const Instance& instance = scene_.instance(id);
      const LaneClass lane_class = laneClassOf(instance);
      if (lane_class == LaneClass::kAlwaysKept && instance.active()) bvh.always_kept_.push_back(id);
      if (lane_class == LaneClass::kLane) {
        all.grow(instance.bounds_world);
        items_.push_back({{}, {}, id});
      }
    }
    const glm::dvec3 middle = 0.5 * all.min + 0.5 * all.max;
    const glm::dvec3 half = 0.5 * all.max - 0.5 * all.min;
    const double size = std::max({half.x, half.y, half.z});
    const auto inUnits = [&](const glm::dvec3& p) {
      const glm::dvec3 q = size > 0.0 ? (p - middle) / size : glm::dvec3(0.0);
      return std::array<float, 3>{static_cast<float>(q.x), static_cast<float>(q.y),
                                  static_cast<float>(q.z)};
    };
    for (Item& item : items_) {
      const Box& box = scene_.instance(item.id).bounds_world;
      item.low = inUnits(box.min);
      item.high = inUnits(box.max);
    }
  }

  /// Level by level, so that the nodes of a level split in parallel; small subtrees in one go.
  void buildNodes() {
    std::vector<Job> level{{WideBvh::kRoot, WideBvh::kNoLane, items_}};
    std::vector<std::uint32_t> large;
    while (!level.empty()) {
      std::vector<std::vector<Job>> below(level.size());
      parallelFor(
          level.size(), [&](std::size_t i) { below[i] = buildSubtree(level[i]); }, threads_);
      std::vector<Job> next;
      for (std::size_t i = 0; i < level.size(); ++i) {
        if (!below[i].empty()) large.push_back(level[i].node);
        next.insert(next.end(), below[i].begin(), below[i].end());
      }
      level = std::move(next);
    }
    for (std::size_t i = large.size(); i-- > 0;) fit(large[i]);  // children before parents
  }

  /// Builds all nodes of a small subtree, or only the top one of a large subtree and returns the
  /// rest.
  std::vector<Job> buildSubtree(const Job& job) {
    constexpr std::size_t kSmall = 4096;
    if (job.items.size() > kSmall) return expand(job);
    std::vector<Job> jobs{job};
    for (std::size_t i = 0; i < jobs.size(); ++i) {
      const Job current = jobs[i];
      const std::vector<Job> children = expand(current);
      jobs.insert(jobs.end(), children.begin(), children.end());
    }
    for (std::size_t i = jobs.size(); i-- > 0;) fit(jobs[i].node);
    return {};
  }

  /// Fills the lanes of one node; returns the nodes below it.
  std::vector<Job> expand(const Job& job) {
    WideNode& node = nodes_[job.node];
    node = emptyNode();
    parent_of_[job.node] = job.parent;
    const std::size_t capacity = laneCapacity(job.items.size());
    std::vector<std::span<Item>> lanes;
    divide(job.items, capacity, lanes);
    std::vector<Job> below;
    std::uint32_t next_node = job.node + 1;
    for (std::size_t l = 0; l < lanes.size(); ++l) {
      const std::uint32_t lane =
          static_cast<std::uint32_t>(kWideLanes) * job.node + static_cast<std::uint32_t>(l);
      if (lanes[l].size() == 1) {
        const ObjectId id = lanes[l].front().id;
        node.child[l] = ChildRef::object(id);
        lane_of_[id] = lane;
        continue;
      }
      node.child[l] = ChildRef::node(next_node);
      below.push_back({next_node, lane, lanes[l]});
      next_node += static_cast<std::uint32_t>(nodesFor(lanes[l].size()));
    }
    return below;
  }

  /// Cuts `items` into groups of `capacity` (the last may be smaller), near ones together.
  static void divide(std::span<Item> items, std::size_t capacity,
                     std::vector<std::span<Item>>& lanes) {
    const std::size_t groups = (items.size() + capacity - 1) / capacity;
    if (groups == 1) {
      lanes.push_back(items);
      return;
    }
    if (capacity == 1) {
      for (std::size_t i = 0; i < items.size(); ++i) lanes.push_back(items.subspan(i, 1));
      return;
    }
    const Split split = chooseSplit(items, groups, capacity);
    const std::size_t left = split.groups_left * capacity;
    std::nth_element(items.begin(), items.begin() + static_cast<std::ptrdiff_t>(left), items.end(),
                     [axis = split.axis](const Item& a, const Item& b) {
                       const float ca = a.centre(axis), cb = b.centre(axis);
                       return ca < cb || (ca == cb && a.id < b.id);
                     });
    divide(items.first(left), capacity, lanes);
    divide(items.subspan(left), capacity, lanes);
  }

  void fit(std::uint32_t index) {
    fitNode(nodes_[index], scene_,
            [this](std::uint32_t child) -> const WideNode& { return nodes_[child]; });
  }

  const SceneSnapshot& scene_;
  std::size_t threads_;
  std::vector<Item> items_;
  std::vector<WideNode> nodes_;
  std::vector<std::uint32_t> parent_of_;
  std::vector<std::uint32_t> lane_of_;
};

WideBvh WideBvh::of(const SceneSnapshot& scene) {
  return scene.objectCount() <= kFewObjects ? flat(scene) : build(scene);
}

WideBvh WideBvh::flat(const SceneSnapshot& scene) { return WideBvhBuilder(scene, 1).runFlat(); }

WideBvh WideBvh::build(const SceneSnapshot& scene, std::size_t threads) {
  return WideBvhBuilder(scene, threads).run();
}

}  // namespace culld
