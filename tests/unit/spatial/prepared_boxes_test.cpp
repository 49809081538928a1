#include "culling/spatial/prepared_boxes.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "culling/spatial/frustum_walk.h"
#include "tests/unit/spatial/box_scene.h"
#include "tests/unit/spatial/exact.h"

namespace culld::testing {
namespace {

PreparedBoxes prepared(const SnapshotPtr& scene) { return PreparedBoxes::of(scene).value(); }

bool hasHierarchy(const WideBvh& bvh) {
  for (std::uint32_t n = 0; n < bvh.nodeCount(); ++n) {
    for (const ChildRef child : bvh.node(n).child) {
      if (child.isNode()) return true;
    }
  }
  return false;
}

std::vector<ObjectId> inFrustum(const WideBvh& bvh, const Camera& camera, std::size_t limit) {
  std::vector<ObjectId> ids;
  appendInFrustum(bvh, FrustumTest(camera, bvh), Deadline(steadyClock(), {}, {}), ids);
  sortIds(ids, limit);
  return ids;
}

Camera lookingFrom(double x) {
  LookAt look;
  look.eye = {x, 3.0, 40.0};
  look.target = {0.5 * x, 0.0, 0.0};
  return cameraFromLookAt(look, {}).value();
}

TEST(PreparedBoxes, BuildNoHierarchyForAHundredObjects) {
  const PreparedBoxes few = prepared(boxScene(randomBoxes(100, {0, 0, 0}, 50.0, 1)));
  EXPECT_FALSE(hasHierarchy(few.bvh()));
  EXPECT_EQ(few.bvh().nodeCount(), 13U);  // eight boxes each
  EXPECT_EQ(few.bvh().rootCount(), 13U);
  EXPECT_LE(few.bytes(), 13 * sizeof(WideNode) + 128);
  const WideBvh built = WideBvh::build(*few.scene());
  EXPECT_TRUE(hasHierarchy(built));
  EXPECT_LT(few.bytes(), built.bytes());
}

TEST(PreparedBoxes, BuildAHierarchyForMany) {
  const PreparedBoxes many =
      prepared(boxScene(randomBoxes(WideBvh::kFewObjects + 1, {0, 0, 0}, 50.0, 1)));
  EXPECT_TRUE(hasHierarchy(many.bvh()));
  EXPECT_EQ(many.bvh().rootCount(), 1U);
}

TEST(PreparedBoxes, FindTheSameObjectsInAFlatListAsInAHierarchyUpToRounding) {
  for (const std::size_t count : {0U, 1U, 7U, 8U, 9U, 64U, 100U, 128U}) {
    const SnapshotPtr scene = boxScene(randomBoxes(count, {1e6, 0, 0}, 30.0, count));
    const WideBvh flat = WideBvh::flat(*scene), tree = WideBvh::build(*scene);
    EXPECT_EQ(flat.liveObjects(), tree.liveObjects());
    for (int n = 0; n < 40; ++n) {
      const Camera camera = lookingFrom(1e6 + 3.0 * (n - 20));
      const auto found = inFrustum(flat, camera, count);
      for (ObjectId id = 0; id < count; ++id) {
        const Box& box = scene->instance(id).bounds_world;
        const bool there = std::binary_search(found.begin(), found.end(), id);
        ASSERT_TRUE(there || outsideExactly(camera, box)) << id;
        ASSERT_FALSE(there && clearlyOutside(camera, box, 1e-5)) << id;
      }
    }
  }
}

TEST(PreparedBoxes, FollowEditsAcrossTheBorderBetweenListAndHierarchy) {
  SnapshotPtr scene = boxScene(randomBoxes(120, {0, 0, 0}, 30.0, 3));
  PreparedBoxes boxes = prepared(scene);
  for (int n = 0; n < 30; ++n) {
    std::vector<Edit> edits{AddInstance{0, placed({1.0 * n, 0, 0}, {1, 1, 1})}};
    if (n % 3 == 0) edits.emplace_back(HideObject{static_cast<ObjectId>(n)});
    const auto edited = applyEdits(scene, edits);
    ASSERT_TRUE(edited.ok());
    scene = edited.value().snapshot;
    boxes = boxes.edited(scene, edited.value().changed).value();
    std::vector<ObjectId> all;
    for (std::uint32_t root = 0; root < boxes.bvh().rootCount(); ++root) {
      boxes.bvh().appendObjects(root, all);
    }
    std::sort(all.begin(), all.end());
    std::vector<ObjectId> active;
    for (ObjectId id = 0; id < scene->objectCount(); ++id) {
      if (scene->instance(id).active()) active.push_back(id);
    }
    ASSERT_EQ(all, active);
    ASSERT_EQ(boxes.bvh().liveObjects(), active.size());
    ASSERT_EQ(hasHierarchy(boxes.bvh()), scene->objectCount() > WideBvh::kFewObjects);
  }
}

TEST(PreparedBoxes, CountWhatAWalkBelowANodeWouldFind) {
  const SnapshotPtr scene = boxScene(randomBoxes(4000, {0, 0, 0}, 50.0, 5));
  const WideBvh bvh = WideBvh::build(*scene);
  for (int n = 0; n < 20; ++n) {
    const FrustumTest frustum(lookingFrom(5.0 * n - 50.0), bvh);
    std::vector<ObjectId> ids;
    appendInFrustum(bvh, frustum, Deadline(steadyClock(), {}, {}), ids);
    EXPECT_EQ(countInFrustum(bvh, frustum, WideBvh::kRoot, frustum.planes()), ids.size());
    EXPECT_EQ(countInFrustum(bvh, frustum, WideBvh::kRoot, 0), 4000U);
  }
}

}  // namespace
}  // namespace culld::testing
