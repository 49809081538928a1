#include "culling/spatial/octree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <glm/common.hpp>
#include <map>
#include <random>

#include "culling/spatial/octree_split.h"
#include "tests/unit/spatial/box_scene.h"

namespace culld::testing {
namespace {

Box laneBoxOf(const WideNode& node, std::size_t l) {
  Box box;
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    box.min[axis] = node.origin[a] + static_cast<double>(node.offsets[kMinX + a][l]);
    box.max[axis] = node.origin[a] + static_cast<double>(node.offsets[kMaxX + a][l]);
  }
  return box;
}

struct Lane {
  ObjectId id;
  Box box;
  double half_m;  ///< of the cube that it is bound to
};

void collect(const Octree& octree, std::uint32_t index, const Box& above, std::vector<Lane>& out) {
  const OctreeNode& node = octree.node(index);
  const auto within = [&](const Box& box) {
    // Lanes are rounded outwards, each about its own origin.
    const double rounded = 1e-3 + 1e-6 * longestSide(octree.bounds());
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_GE(box.min[axis], above.min[axis] - rounded);
      EXPECT_LE(box.max[axis], above.max[axis] + rounded);
    }
  };
  for (std::uint32_t at = node.objects; at != OctreeNode::kNone; at = octree.nextLanes(at)) {
    for (std::size_t l = 0; l < kWideLanes; ++l) {
      if ((octree.lanes(at).live >> l & 1U) == 0) continue;
      out.push_back(
          {octree.lanes(at).child[l].objectId(), laneBoxOf(octree.lanes(at), l), node.half_m});
      within(out.back().box);
    }
  }
  if (node.children == OctreeNode::kNone) return;
  for (std::size_t l = 0; l < kWideLanes; ++l) {
    if ((octree.lanes(node.children).live >> l & 1U) == 0) continue;
    const Box box = laneBoxOf(octree.lanes(node.children), l);
    within(box);
    collect(octree, octree.lanes(node.children).child[l].nodeIndex(), box, out);
  }
}

std::vector<Lane> lanesOf(const Octree& octree) {
  std::vector<Lane> lanes;
  if (!octree.empty()) collect(octree, Octree::kRoot, octree.bounds(), lanes);
  return lanes;
}

bool holds(const Box& box, const glm::dvec3& p) {
  for (int axis = 0; axis < 3; ++axis) {
    if (!(p[axis] >= box.min[axis] && p[axis] <= box.max[axis])) return false;
  }
  return true;
}

/// Every point of every object must be in one of its lanes, and nothing else in the octree.
void expectWhole(const Octree& octree, const SceneSnapshot& scene) {
  std::map<ObjectId, std::vector<Box>> parts;
  for (const Lane& lane : lanesOf(octree)) parts[lane.id].push_back(lane.box);
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (std::size_t i = 0; i < scene.objectCount(); ++i) {
    const auto id = static_cast<ObjectId>(i);
    const Instance& instance = scene.instance(id);
    ASSERT_EQ(parts.contains(id), instance.active()) << id;
    if (!instance.active()) continue;
    const Box& b = instance.bounds_world;
    for (int k = 0; k < 12; ++k) {
      const glm::dvec3 t(k < 8 ? (k & 1) : unit(random), k < 8 ? (k >> 1 & 1) : unit(random),
                         k < 8 ? (k >> 2 & 1) : unit(random));
      const glm::dvec3 p = glm::mix(b.min, b.max, t);
      const auto& boxes = parts[id];
      ASSERT_TRUE(std::any_of(boxes.begin(), boxes.end(), [&](const Box& box) {
        return holds(box, glm::clamp(p, b.min, b.max));
      })) << id;
    }
  }
}

TEST(Octree, HoldsAllOfEveryObject) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const SnapshotPtr scene = boxScene(randomBoxes(3000, {100.0, -30.0, 5.0}, 40.0, seed));
    expectWhole(Octree::of(*scene, {}), *scene);
    expectWhole(Octree::of(*scene, {.leaf_objects = 1, .small_share = 0.0}), *scene);
  }
}

/// Small boxes across the middle planes of everything, among others.
SnapshotPtr boxesAcrossThePlanes() {
  auto boxes = randomBoxes(800, {0, 0, 0}, 20.0, 9);
  boxes.push_back(placed({-64.0, -64.0, -64.0}, {128.0, 128.0, 128.0}));
  for (int i = 0; i < 60; ++i)
    boxes.push_back(placed({-0.05, -60.0 + 2.0 * i, 20.0}, {0.1, 0.1, 0.1}));
  return boxScene(boxes);
}

TEST(Octree, SmallObjectsAreNotBoundToLargeCubes) {
  const SnapshotPtr scene = boxesAcrossThePlanes();
  const auto largestCubeOfASmallObject = [&](double share) {
    double half_m = 0.0;
    for (const Lane& lane :
         lanesOf(Octree::of(*scene, {.leaf_objects = 8, .small_share = share}))) {
      if (lane.id < 801) continue;  // those in the way are the last ones
      half_m = std::max(half_m, lane.half_m);
    }
    return half_m;
  };
  EXPECT_GT(largestCubeOfASmallObject(0.0), 60.0);
  EXPECT_LT(largestCubeOfASmallObject(0.5), 20.0);
}

TEST(Octree, TakesFewLanesHoweverMuchObjectsOverlap) {
  std::vector<std::array<double, 12>> boxes;
  for (int i = 0; i < 20'000; ++i) boxes.push_back(placed({-0.5, -0.5, -0.5}, {1.0, 1.0, 1.0}));
  boxes.push_back(placed({1e6, 1e6, 1e6}, {1.0, 1.0, 1.0}));
  boxes.push_back(placed({-1e6, -1e6, -1e6}, {1.0, 1.0, 1.0}));
  const SnapshotPtr scene = boxScene(boxes);
  const Octree octree = Octree::of(*scene, {});
  EXPECT_LE(octree.laneCount(), 4 * scene->objectCount());
  EXPECT_LE(octree.nodeCount(), 20'000U);
  expectWhole(octree, *scene);
}

TEST(Octree, HoldsObjectsOfEverySizeAndPlace) {
  std::vector<std::array<double, 12>> boxes;
  for (int e = -300; e <= 300; e += 20) {
    for (const double sign : {-1.0, 1.0}) {
      const double at = sign * std::pow(10.0, e);
      for (int i = 0; i < 3; ++i) boxes.push_back(placed({at, at, at}, {std::abs(at), 0.0, 1.0}));
    }
  }
  const SnapshotPtr scene = boxScene(boxes);
  const Octree octree = Octree::of(*scene, {.leaf_objects = 2});
  std::vector<ObjectId> ids;
  octree.appendObjects(Octree::kRoot, ids);
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  EXPECT_EQ(ids.size() + octree.alwaysKept().size(), scene->objectCount());
}

TEST(Octree, EditsKeepItWholeAndShareWhatTheyDoNotTouch) {
  SnapshotPtr scene = boxScene(randomBoxes(20'000, {0, 0, 0}, 60.0, 4));
  Octree octree = Octree::of(*scene, {});
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> place(-80.0, 80.0);
  for (int step = 0; step < 60; ++step) {
    std::vector<Edit> edits;
    const auto id = static_cast<ObjectId>(random() % scene->objectCount());
    if (scene->instance(id).removed) continue;
    const auto world =
        placed({place(random), place(random), place(random)}, glm::dvec3(0.5 + step % 9));
    switch (step % 5) {
      case 0:
        edits = {HideObject{id}};
        break;
      case 1:
        edits = {ShowObject{id}};
        break;
      case 2:
        edits = {RemoveObject{id}};
        break;
      case 3:
        edits = {AddInstance{id, world}, MoveObject{id, world}};
        break;
      default:
        edits = {MoveObject{id, world}};
    }
    auto edited = applyEdits(scene, edits);
    ASSERT_TRUE(edited.ok()) << edited.error().message;
    Octree next = octree.edited(*scene, *edited.value().snapshot, edited.value().changed);
    EXPECT_LT(next.chunksNotSharedWith(octree), 60U);
    scene = edited.value().snapshot;
    octree = std::move(next);
  }
  expectWhole(octree, *scene);
}

TEST(Octree, ManyEditsMakeANewOne) {
  SnapshotPtr scene = boxScene(randomBoxes(200, {0, 0, 0}, 60.0, 4));
  Octree octree = Octree::of(*scene, {.leaf_objects = 4});
  const std::size_t nodes = octree.nodeCount();
  for (int step = 0; step < 1200; ++step) {
    const ObjectId id = static_cast<ObjectId>(step % 200);
    const auto world = placed({0.01 * step, 0.0, 0.3 * step}, glm::dvec3(0.5));
    auto edited = applyEdits(scene, std::vector<Edit>{MoveObject{id, world}});
    ASSERT_TRUE(edited.ok());
    octree = octree.edited(*scene, *edited.value().snapshot, edited.value().changed);
    scene = edited.value().snapshot;
  }
  EXPECT_GT(octree.nodeCount(), nodes / 4);
  expectWhole(octree, *scene);
}

TEST(Octree, IsEmptyForNothingAndTakesItsFirstObject) {
  SnapshotPtr scene = boxScene({placed({1, 2, 3}, {1, 1, 1})});
  auto hidden = applyEdits(scene, std::vector<Edit>{HideObject{0}});
  ASSERT_TRUE(hidden.ok());
  const Octree empty = Octree::of(*hidden.value().snapshot, {});
  EXPECT_TRUE(empty.empty());
  const Octree one = empty.edited(*hidden.value().snapshot, *scene, std::vector<ObjectId>{0});
  expectWhole(one, *scene);
}

}  // namespace
}  // namespace culld::testing
