#include "culling/methods/frustum.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <thread>

#include "culling/core/simd.h"
#include "tests/unit/methods/random_cameras.h"
#include "tests/unit/spatial/box_scene.h"
#include "tests/unit/spatial/exact.h"

namespace culld::testing {
namespace {

class TickingClock final : public Clock {
 public:
  std::chrono::nanoseconds now() const noexcept override {
    return std::chrono::nanoseconds(1000 * ++looks_);
  }

 private:
  mutable std::atomic<long> looks_{0};
};

std::unique_ptr<Culler> prepared(const SnapshotPtr& scene, const Clock& clock = steadyClock()) {
  auto culler = frustumMethod().prepare(scene, clock);
  EXPECT_TRUE(culler.ok());
  return std::move(culler).value();
}

class FrustumMethod : public ::testing::TestWithParam<std::string> {
 protected:
  void SetUp() override { ASSERT_TRUE(forceSimdTarget(GetParam()).ok()); }
  void TearDown() override { ASSERT_TRUE(forceSimdTarget("auto").ok()); }
};

TEST_P(FrustumMethod, LeavesOutNothingThatReachesIntoTheFrustumOfAnyCamera) {
  struct World {
    glm::dvec3 centre;
    double extent;
  };
  std::mt19937_64 random(1);
  std::size_t left_out = 0, answered = 0;
  for (const World& world :
       {World{{0, 0, 0}, 1.0}, World{{1e7, 1e7, -1e7}, 100.0}, World{{-6.4e6, 0, 0}, 0.5},
        World{{0, 0, 0}, 1e-30}, World{{0, 0, 0}, 1e12}, World{{0, 0, 0}, 1e30}}) {
    const auto scene = boxScene(randomBoxes(400, world.centre, world.extent, 3));
    const auto culler = prepared(scene);
    ViewState view;
    for (int n = 0; n < 60; ++n) {
      const Camera camera = n % 2 == 0 ? perspectiveCamera(random, world.centre, world.extent)
                                       : matrixCamera(random, world.centre, world.extent);
      const Answer answer = culler->cull(camera, {}, view);
      answered += answer.visible.size();
      ASSERT_TRUE(std::is_sorted(answer.visible.begin(), answer.visible.end()));
      ASSERT_EQ(std::adjacent_find(answer.visible.begin(), answer.visible.end()),
                answer.visible.end());
      for (ObjectId id = 0; id < scene->objectCount(); ++id) {
        if (std::binary_search(answer.visible.begin(), answer.visible.end(), id)) continue;
        ++left_out;
        ASSERT_TRUE(outsideExactly(camera, scene->instance(id).bounds_world))
            << "extent " << world.extent << " camera " << n << " object " << id;
      }
      ASSERT_EQ(answer.stats.outside + answer.stats.in_frustum, scene->objectCount());
      ASSERT_EQ(answer.stats.in_frustum, answer.visible.size());
    }
  }
  EXPECT_GT(left_out, 10000U);
  EXPECT_GT(answered, 5000U);
}

TEST_P(FrustumMethod, AnswersTheSameIdsAsTheBestTarget) {
  std::mt19937_64 random(2);
  const auto scene = boxScene(randomBoxes(5000, {1e6, 0, 0}, 100.0, 4));
  const auto culler = prepared(scene);
  ViewState view;
  for (int n = 0; n < 50; ++n) {
    const Camera camera = perspectiveCamera(random, {1e6, 0, 0}, 100.0);
    const Answer here = culler->cull(camera, {}, view);
    ASSERT_TRUE(forceSimdTarget("auto").ok());
    EXPECT_EQ(here.visible, culler->cull(camera, {}, view).visible);
    ASSERT_TRUE(forceSimdTarget(GetParam()).ok());
  }
}

INSTANTIATE_TEST_SUITE_P(Targets, FrustumMethod, ::testing::ValuesIn(simdTargets()),
                         [](const auto& target) { return target.param; });

TEST(Frustum, SaysWhatItIs) {
  const MethodInfo info = frustumMethod().info();
  EXPECT_EQ(info.name, "frustum");
  EXPECT_EQ(info.guarantee, Guarantee::kConservative);
  EXPECT_TRUE(frustumMethod().accepts({}).ok());
}

TEST(Frustum, AnswersWhatHasNoBoundInEveryView) {
  SceneBuilder builder;
  const MeshId cube = builder.addMesh(unitCube());
  Mesh skinned = unitCube();
  skinned.unbounded = true;
  const MeshId loose = builder.addMesh(std::move(skinned));
  for (std::uint32_t i = 0; i < 20; ++i) {  // all behind the camera
    builder.addInstance(i == 3 || i == 17 ? loose : cube, placed({0, 0, 10.0 + i}, {1, 1, 1}), i);
  }
  const SnapshotPtr scene = builder.finish();
  ViewState view;
  const Answer answer = prepared(scene)->cull(cameraFromLookAt({}, {}).value(), {}, view);
  EXPECT_EQ(answer.visible, (std::vector<ObjectId>{3, 17}));
  EXPECT_EQ(answer.stats.always_kept, 2U);
  EXPECT_EQ(answer.stats.outside, 18U);
  EXPECT_EQ(answer.stats.in_frustum, 2U);
}

TEST(Frustum, KeepsEverythingUndecidedWhenTimeRunsOutAndSaysSo) {
  const auto scene = boxScene(randomBoxes(20000, {0, 0, 0}, 100.0, 5));
  const TickingClock clock;
  const auto culler = prepared(scene, clock);
  std::mt19937_64 random(3);
  ViewState view;
  const Camera camera = perspectiveCamera(random, {0, 0, 0}, 100.0);
  const Answer whole = culler->cull(camera, {}, view);
  EXPECT_FALSE(whole.out_of_budget);
  EXPECT_TRUE(whole.note.empty());
  Demand demand;
  demand.time = std::chrono::nanoseconds(1);
  const Answer cut = culler->cull(camera, demand, view);
  EXPECT_TRUE(cut.out_of_budget);
  EXPECT_FALSE(cut.note.empty());
  EXPECT_GT(cut.visible.size(), whole.visible.size());
  EXPECT_TRUE(std::includes(cut.visible.begin(), cut.visible.end(), whole.visible.begin(),
                            whole.visible.end()));
  EXPECT_EQ(cut.stats.outside + cut.stats.in_frustum, 20000U);
}

TEST(Frustum, FollowsEditsWithoutLosingAnything) {
  std::mt19937_64 random(4);
  SnapshotPtr scene = boxScene(randomBoxes(300, {1e6, 0, 0}, 20.0, 6));
  std::unique_ptr<Culler> culler = prepared(scene);
  ViewState view;
  for (int n = 0; n < 100; ++n) {
    const auto id = static_cast<ObjectId>(random() % 300);
    auto t = scene->instance(id).world_from_mesh;
    t[3] += uniform(random, -20, 20);
    const Edit choices[] = {MoveObject{id, t}, AddInstance{id, t}, HideObject{id}, ShowObject{id}};
    const auto edited = applyEdits(scene, std::vector<Edit>{choices[random() % 4]});
    ASSERT_TRUE(edited.ok());
    scene = edited.value().snapshot;
    auto next = culler->edited(scene, edited.value().changed);
    ASSERT_TRUE(next.ok());
    culler = std::move(next).value();
    const Camera camera = perspectiveCamera(random, {1e6, 0, 0}, 20.0);
    const Answer answer = culler->cull(camera, {}, view);
    std::size_t active = 0;
    for (ObjectId i = 0; i < scene->objectCount(); ++i) {
      const Instance& instance = scene->instance(i);
      active += instance.active() ? 1U : 0U;
      const bool there = std::binary_search(answer.visible.begin(), answer.visible.end(), i);
      if (!instance.active()) {
        ASSERT_FALSE(there) << i;
      } else {
        ASSERT_TRUE(there || outsideExactly(camera, instance.bounds_world)) << i;
        ASSERT_FALSE(there && clearlyOutside(camera, instance.bounds_world, 1e-5)) << i;
      }
    }
    ASSERT_EQ(answer.stats.outside + answer.stats.in_frustum, active);
  }
}

TEST(Frustum, AnswersEveryPoseWithinTheMotionBound) {
  std::mt19937_64 random(7);
  const auto scene = boxScene(randomBoxes(500, {0, 0, 0}, 50.0, 8));
  const auto culler = prepared(scene);
  ViewState view;
  for (int n = 0; n < 100; ++n) {
    Camera still = perspectiveCamera(random, {0, 0, 0}, 50.0);
    Camera bound = still;
    bound.motion = {uniform(random, 0, 5), 0.0};
    const Answer all = culler->cull(bound, {}, view);
    for (int k = 0; k < 20; ++k) {
      glm::dvec3 step(uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1));
      step *= 0.999 * bound.motion.radius_m / std::max(glm::length(step), 1e-3);
      Camera pose = still;
      pose.origin_world += step;
      const Answer one = culler->cull(pose, {}, view);
      for (const ObjectId id : one.visible) {
        if (std::binary_search(all.visible.begin(), all.visible.end(), id)) continue;
        ASSERT_TRUE(outsideExactly(pose, scene->instance(id).bounds_world)) << id;
      }
    }
  }
}

TEST(Frustum, AnswersManyThreadsWhileNewerVersionsAreMade) {
  std::mt19937_64 random(10);
  SnapshotPtr scene = boxScene(randomBoxes(3000, {0, 0, 0}, 50.0, 11));
  const std::unique_ptr<Culler> first = prepared(scene);
  const Camera camera = perspectiveCamera(random, {0, 0, 0}, 50.0);
  ViewState view;
  const std::vector<ObjectId> expected = first->cull(camera, {}, view).visible;
  std::atomic<int> different{0};
  std::vector<std::jthread> readers;
  for (int t = 0; t < 3; ++t) {
    readers.emplace_back([&] {
      ViewState mine;
      for (int n = 0; n < 200; ++n)
        different += first->cull(camera, {}, mine).visible != expected ? 1 : 0;
    });
  }
  std::unique_ptr<Culler> newest;
  for (int n = 0; n < 100; ++n) {
    auto t = scene->instance(static_cast<ObjectId>(n)).world_from_mesh;
    t[7] += 30.0;
    auto edit = applyEdits(scene, std::vector<Edit>{MoveObject{static_cast<ObjectId>(n), t}});
    ASSERT_TRUE(edit.ok());
    scene = edit.value().snapshot;
    const Culler& base = n == 0 ? *first : *newest;  // the first edit starts from what others read
    auto next = base.edited(scene, edit.value().changed);
    ASSERT_TRUE(next.ok());
    newest = std::move(next).value();
  }
  readers.clear();
  EXPECT_EQ(different, 0);
}

TEST(Frustum, HoldsAtMost45BytesPerObject) {
  const auto scene = boxScene(randomBoxes(50000, {0, 0, 0}, 100.0, 9));
  EXPECT_LE(prepared(scene)->preparedBytes(), 45U * 50000U);
}

}  // namespace
}  // namespace culld::testing
