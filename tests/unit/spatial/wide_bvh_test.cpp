#include "culling/spatial/wide_bvh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <limits>

#include "tests/unit/spatial/box_scene.h"
#include "tests/unit/spatial/exact.h"

namespace culld::testing {
namespace {

bool live(const WideNode& node, std::size_t lane) { return (node.live >> lane & 1U) != 0; }

/// Checks everything that the header promises, and returns the live objects found in the tree.
std::vector<ObjectId> checkedObjects(const WideBvh& bvh, const SceneSnapshot& scene) {
  std::vector<ObjectId> found;
  if (bvh.empty()) return found;
  EXPECT_EQ(bvh.parentOf(WideBvh::kRoot), WideBvh::kNoLane);
  std::vector<std::uint32_t> stack{WideBvh::kRoot};
  while (!stack.empty()) {
    const std::uint32_t index = stack.back();
    stack.pop_back();
    const WideNode& node = bvh.node(index);
    std::vector<ObjectId> below_it;
    bvh.appendObjects(index, below_it);
    EXPECT_EQ(node.live_objects, below_it.size());
    for (std::size_t l = 0; l < kWideLanes; ++l) {
      const ChildRef child = node.child[l];
      const std::uint32_t lane = index * 8 + static_cast<std::uint32_t>(l);
      if (!live(node, l)) {
        EXPECT_GT(node.offsets[kMinX][l], node.offsets[kMaxX][l]);
      }
      if (child.empty()) {
        EXPECT_FALSE(live(node, l));
      } else if (child.isObject()) {
        const Instance& instance = scene.instance(child.objectId());
        EXPECT_EQ(bvh.laneOf(child.objectId()), lane);
        EXPECT_EQ(live(node, l), instance.active());
        if (!live(node, l)) continue;
        found.push_back(child.objectId());
        EXPECT_TRUE(containsExactly(exactLaneBox(node, l), instance.bounds_world));
      } else {
        const WideNode& below = bvh.node(child.nodeIndex());
        EXPECT_EQ(bvh.parentOf(child.nodeIndex()), lane);
        EXPECT_EQ(live(node, l), below.live != 0);
        for (std::size_t k = 0; k < kWideLanes; ++k) {
          if (!live(below, k)) continue;
          EXPECT_TRUE(containsExactly(exactLaneBox(node, l), exactLaneBox(below, k)));
        }
        stack.push_back(child.nodeIndex());
      }
    }
  }
  std::sort(found.begin(), found.end());
  EXPECT_EQ(found.size(), bvh.liveObjects());
  return found;
}

/// Every active object is in the tree or always kept, once, and nothing else is.
void expectComplete(const WideBvh& bvh, const SceneSnapshot& scene) {
  const std::vector<ObjectId> found = checkedObjects(bvh, scene);
  std::vector<ObjectId> lanes, always;
  for (std::size_t i = 0; i < scene.objectCount(); ++i) {
    const auto id = static_cast<ObjectId>(i);
    const Instance& instance = scene.instance(id);
    if (!instance.active()) continue;
    (instance.always_kept ? always : lanes).push_back(id);
  }
  EXPECT_EQ(found, lanes);
  EXPECT_TRUE(
      std::equal(always.begin(), always.end(), bvh.alwaysKept().begin(), bvh.alwaysKept().end()));
  if (!bvh.empty()) {
    std::vector<ObjectId> all;
    bvh.appendObjects(WideBvh::kRoot, all);
    std::sort(all.begin(), all.end());
    EXPECT_EQ(all, found);
  }
}

bool equalNodes(const WideBvh& a, const WideBvh& b) {
  if (a.nodeCount() != b.nodeCount()) return false;
  for (std::uint32_t i = 0; i < a.nodeCount(); ++i) {
    if (std::memcmp(&a.node(i), &b.node(i), sizeof(WideNode)) != 0) return false;
  }
  return true;
}

TEST(WideBvh, IsEmptyForAnEmptyScene) {
  const SnapshotPtr scene = boxScene({});
  const WideBvh bvh = WideBvh::build(*scene);
  EXPECT_TRUE(bvh.empty());
  EXPECT_EQ(bvh.liveObjects(), 0U);
}

TEST(WideBvh, HoldsEveryObjectOnceWhateverTheirNumber) {
  for (std::size_t count : {1U, 2U, 7U, 8U, 9U, 15U, 63U, 64U, 65U, 511U, 512U, 513U, 5000U}) {
    SCOPED_TRACE(count);
    const SnapshotPtr scene = boxScene(randomBoxes(count, {0, 0, 0}, 100.0, count));
    expectComplete(WideBvh::build(*scene), *scene);
  }
}

TEST(WideBvh, ContainsBoundsExactlyFarFromTheWorldsOriginAndAtAnyScale) {
  const glm::dvec3 centres[] = {{0, 0, 0}, {1e7, -1e7, 1e7}, {6.4e6, 0.1, -3e5}, {1e15, 1, 1}};
  for (const glm::dvec3& centre : centres) {
    for (double extent : {1e-30, 1e-3, 1.0, 1e6, 1e30}) {
      SCOPED_TRACE(::testing::Message() << centre.x << " extent " << extent);
      const SnapshotPtr scene = boxScene(randomBoxes(300, centre, extent, 7));
      expectComplete(WideBvh::build(*scene), *scene);
    }
  }
}

TEST(WideBvh, SurvivesBoxesBeyondTheRangeOfFloat) {
  const SnapshotPtr scene =
      boxScene({placed({-1e300, 0, 0}, {2e300, 1, 1}), placed({0, 0, 0}, {1, 1, 1}),
                placed({1e300, 1e300, 1e300}, {1e290, 1, 1})});
  expectComplete(WideBvh::build(*scene), *scene);
}

TEST(WideBvh, IsTheSameForAnyNumberOfThreads) {
  const SnapshotPtr scene = boxScene(randomBoxes(20000, {1e5, 0, 0}, 1000.0, 3));
  const WideBvh one = WideBvh::build(*scene, 1);
  EXPECT_TRUE(equalNodes(one, WideBvh::build(*scene, 2)));
  EXPECT_TRUE(equalNodes(one, WideBvh::build(*scene, 7)));
}

TEST(WideBvh, TakesAtMost45BytesPerObject) {
  for (std::size_t count : {20000U, 32768U, 32769U, 100000U}) {
    const SnapshotPtr scene = boxScene(randomBoxes(count, {0, 0, 0}, 100.0, 1));
    const double bytes = static_cast<double>(WideBvh::build(*scene).bytes());
    EXPECT_LE(bytes / static_cast<double>(count), 45.0) << count;
  }
}

TEST(WideBvh, KeepsObjectsOfUnboundedMeshesApart) {
  SceneBuilder builder;
  const MeshId cube = builder.addMesh(unitCube());
  Mesh skinned = unitCube();
  skinned.unbounded = true;
  const MeshId loose = builder.addMesh(std::move(skinned));
  for (std::uint32_t i = 0; i < 40; ++i) {
    builder.addInstance(i % 4 == 1 ? loose : cube, placed({1.0 * i, 0, 0}, {1, 1, 1}), i);
  }
  const SnapshotPtr scene = builder.finish();
  const WideBvh bvh = WideBvh::build(*scene);
  EXPECT_EQ(bvh.alwaysKept().size(), 10U);
  expectComplete(bvh, *scene);

  const auto edited = applyEdits(scene, std::vector<Edit>{HideObject{1}, RemoveObject{5}});
  ASSERT_TRUE(edited.ok());
  const WideBvh after = bvh.edited(*edited.value().snapshot, edited.value().changed);
  EXPECT_EQ(after.alwaysKept().size(), 8U);
  expectComplete(after, *edited.value().snapshot);
}

/// One random edit of any kind; objects wander by about the size of their neighbourhood, or far.
Edit randomEdit(const SceneSnapshot& scene, std::mt19937_64& random) {
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const auto pick = [&] { return static_cast<ObjectId>(random() % scene.objectCount()); };
  ObjectId id = pick();
  while (scene.instance(id).removed) id = pick();
  auto t = scene.instance(id).world_from_mesh;
  const double step = random() % 4 == 0 ? 100.0 : 1.0;
  for (std::size_t row = 0; row < 3; ++row) t[row * 4 + 3] += step * unit(random);
  switch (random() % 6) {
    case 0:
      return HideObject{id};
    case 1:
      return ShowObject{id};
    case 2:
      return RemoveObject{id};
    case 3:
      return AddInstance{id, t};
    default:
      return MoveObject{id, t};
  }
}

TEST(WideBvh, StaysCompleteAndExactThroughRandomEdits) {
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937_64 random(seed);
    const std::size_t count = seed % 3 == 0 ? 3 : 200;
    SnapshotPtr scene = boxScene(randomBoxes(count, {1e7, 0, -1e7}, 100.0, seed));
    WideBvh bvh = WideBvh::build(*scene);
    for (int round = 0; round < 150; ++round) {
      std::vector<Edit> edits;
      for (std::uint64_t i = 0; i <= random() % 4; ++i) {
        const Edit edit = randomEdit(*scene, random);
        // Removing an object twice in one step is an error of the caller; one removal at a time.
        if (std::holds_alternative<RemoveObject>(edit) && !edits.empty()) continue;
        edits.push_back(edit);
        if (std::holds_alternative<RemoveObject>(edit)) break;
      }
      if (scene->triangleCount() <= 12) break;  // the last object: nothing left to edit after it
      const auto next = applyEdits(scene, edits);
      ASSERT_TRUE(next.ok()) << next.error().message;
      const WideBvh before = bvh;
      bvh = before.edited(*next.value().snapshot, next.value().changed);
      expectComplete(bvh, *next.value().snapshot);
      expectComplete(before, *scene);  // readers of the older version see nothing of the edit
      scene = next.value().snapshot;
      if (HasFailure()) return;
    }
  }
}

TEST(WideBvh, GivesBackTheLaneWhenAHiddenObjectIsShown) {
  const SnapshotPtr scene = boxScene(randomBoxes(500, {0, 0, 0}, 10.0, 5));
  const WideBvh bvh = WideBvh::build(*scene);
  const auto hidden = applyEdits(scene, std::vector<Edit>{HideObject{77}});
  const WideBvh without = bvh.edited(*hidden.value().snapshot, hidden.value().changed);
  EXPECT_EQ(without.liveObjects(), 499U);
  EXPECT_EQ(without.laneOf(77), bvh.laneOf(77));
  const auto shown = applyEdits(hidden.value().snapshot, std::vector<Edit>{ShowObject{77}});
  const WideBvh again = without.edited(*shown.value().snapshot, shown.value().changed);
  EXPECT_TRUE(equalNodes(again, bvh));
}

TEST(WideBvh, GrowsFromNothingAndShrinksToNothing) {
  SnapshotPtr scene = boxScene({placed({0, 0, 0}, {1, 1, 1})});
  WideBvh bvh = WideBvh::build(*scene);
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> at(-50.0, 50.0);
  for (int i = 0; i < 700; ++i) {
    const auto t = placed({at(random), at(random), at(random)}, {1, 1, 1});
    const auto next = applyEdits(scene, std::vector<Edit>{AddInstance{0, t}});
    bvh = bvh.edited(*next.value().snapshot, next.value().changed);
    scene = next.value().snapshot;
  }
  expectComplete(bvh, *scene);
  EXPECT_FALSE(bvh.degraded());
  for (ObjectId id = 0; id < 701; ++id) {
    const auto next = applyEdits(scene, std::vector<Edit>{RemoveObject{id}});
    bvh = bvh.edited(*next.value().snapshot, next.value().changed);
    scene = next.value().snapshot;
  }
  expectComplete(bvh, *scene);
  EXPECT_EQ(bvh.liveObjects(), 0U);
}

TEST(WideBvh, RebuildsItselfWhenObjectsArriveInTheWorstOrder) {
  SnapshotPtr scene = boxScene({placed({0, 0, 0}, {1, 1, 1})});
  WideBvh bvh = WideBvh::build(*scene);
  for (int i = 1; i < 900; ++i) {  // each one further out: a tree without rebuilds becomes a list
    const double x = std::pow(1.5, i);
    const auto next =
        applyEdits(scene, std::vector<Edit>{AddInstance{0, placed({x, 0, 0}, {1, 1, 1})}});
    ASSERT_TRUE(next.ok());
    bvh = bvh.edited(*next.value().snapshot, next.value().changed);
    scene = next.value().snapshot;
  }
  expectComplete(bvh, *scene);
  EXPECT_LT(bvh.editsSinceBuild(), 899U);
}

TEST(WideBvh, SharesNearlyAllChunksAfterOneEdit) {
  const SnapshotPtr scene = boxScene(randomBoxes(50000, {0, 0, 0}, 1000.0, 9));
  const WideBvh bvh = WideBvh::build(*scene);
  auto t = scene->instance(123).world_from_mesh;
  t[3] += 500.0;
  const auto next = applyEdits(scene, std::vector<Edit>{MoveObject{123, t}});
  const WideBvh after = bvh.edited(*next.value().snapshot, next.value().changed);
  expectComplete(after, *next.value().snapshot);
  // Two paths from the root, at most 6 nodes each; node + chunk counts do not depend on the clock.
  EXPECT_LE(after.chunksNotSharedWith(bvh), 14U);
}

}  // namespace
}  // namespace culld::testing
