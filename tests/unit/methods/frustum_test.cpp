#include "culling/methods/frustum.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <thread>

#include "culling/core/simd.h"
#include "culling/spatial/prepared_boxes.h"
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

double uniform(std::mt19937_64& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

Camera perspectiveCamera(std::mt19937_64& random, const glm::dvec3& centre, double extent) {
  const auto point = [&] {
    return centre + extent * glm::dvec3(uniform(random, -1, 1), uniform(random, -1, 1),
                                        uniform(random, -1, 1));
  };
  LookAt look;
  look.eye = point();
  look.target = point();
  look.yfov_rad = uniform(random, 2e-4, 3.12);  // 0.01 to 179 degrees
  look.aspect = std::exp(uniform(random, -3, 3));
  look.znear_m = extent * std::pow(10.0, uniform(random, -6, -1));
  if (random() % 2 == 0) look.zfar_m = extent * std::pow(10.0, uniform(random, -0.5, 9));
  return cameraFromLookAt(look, {}).value();
}

/// Off-centre, and mirrored, reversed or orthographic now and then.
Camera matrixCamera(std::mt19937_64& random, const glm::dvec3& centre, double extent) {
  const Camera pose = perspectiveCamera(random, centre, extent);
  const glm::dvec3 w = glm::normalize(glm::dvec3(pose.w_row));
  const glm::dvec3 x = glm::normalize(glm::dvec3(pose.x_row)) * (random() % 3 == 0 ? -1.0 : 1.0);
  const glm::dvec3 y = glm::normalize(glm::dvec3(pose.y_row));
  const glm::dvec3 eye = pose.origin_world;
  const glm::dmat4 view =
      glm::transpose(glm::dmat4(glm::dvec4(x, -glm::dot(x, eye)), glm::dvec4(y, -glm::dot(y, eye)),
                                glm::dvec4(-w, glm::dot(w, eye)), glm::dvec4(0, 0, 0, 1)));
  const double near = extent * 1e-3, far = extent * 2.0;
  const double sx = uniform(random, 0.3, 5), sy = uniform(random, 0.3, 5);
  const double ox = uniform(random, -2, 2), oy = uniform(random, -2, 2);
  glm::dmat4 projection(0.0);
  if (random() % 3 == 0) {  // orthographic, `extent` wide or so
    projection[0][0] = sx / extent;
    projection[1][1] = sy / extent;
    projection[2][2] = -2.0 / (far - near);
    projection[3] = glm::dvec4(ox, oy, -(far + near) / (far - near), 1.0);
  } else {
    const bool reversed = random() % 2 == 0;
    const double sign = reversed ? -1.0 : 1.0;
    projection[0][0] = sx;
    projection[1][1] = sy;
    projection[2] = glm::dvec4(ox, oy, -sign * (far + near) / (far - near), -1.0);
    projection[3][2] = -sign * 2.0 * far * near / (far - near);
  }
  auto camera = cameraFromMatrices(view, projection, {});
  EXPECT_TRUE(camera.ok());
  return camera.value();
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

std::unique_ptr<Culler> withSettings(const std::string& settings, const SnapshotPtr& scene) {
  const Method* const table[] = {&frustumMethod()};
  ConfiguredMethods methods(table);
  return methods.find("frustum" + settings).value()->prepare(scene, steadyClock()).value();
}

struct Work {
  std::size_t answered = 0;
  std::uint64_t plane_tests = 0;
};

/// A camera that turns a little from frame to frame.
Work turningView(const Culler& culler, bool remembers = true) {
  Work work;
  ViewState view;
  for (int n = 0; n < 60; ++n) {
    LookAt look;
    look.target = {std::sin(0.02 * n), 0.1, -std::cos(0.02 * n)};
    look.zfar_m = 120.0;
    if (!remembers) view = ViewState();
    const Answer answer = culler.cull(cameraFromLookAt(look, {}).value(), {}, view);
    work.answered += answer.visible.size();
    work.plane_tests += answer.stats.plane_tests;
  }
  return work;
}

SnapshotPtr manyBoxes() { return boxScene(randomBoxes(20'000, {0, 0, 0}, 100.0, 21)); }

TEST(FrustumSettings, MaskingAsksFewerPlanesForTheSameAnswer) {
  const SnapshotPtr scene = manyBoxes();
  const Work masked = turningView(*withSettings("", scene));
  const Work all = turningView(*withSettings(":masking=off", scene));
  EXPECT_EQ(masked.answered, all.answered);
  EXPECT_LT(masked.plane_tests, all.plane_tests);
}

TEST(FrustumSettings, OctantsAskFewerPlanesForTheSameAnswer) {
  const SnapshotPtr scene = manyBoxes();
  const Work plain = turningView(*withSettings(":masking=off", scene));
  const Work octants = turningView(*withSettings(":masking=off:octants=on", scene));
  EXPECT_EQ(octants.answered, plain.answered);
  EXPECT_LT(octants.plane_tests, plain.plane_tests);
}

TEST(FrustumSettings, CoherenceAsksFewerPlanesWithAMemoryThanWithout) {
  const SnapshotPtr scene = manyBoxes();
  const auto culler = withSettings(":coherence=on", scene);
  const Work kept = turningView(*culler), dropped = turningView(*culler, false);
  EXPECT_EQ(kept.answered, dropped.answered);
  EXPECT_EQ(kept.answered, turningView(*withSettings("", scene)).answered);
  EXPECT_LT(kept.plane_tests, dropped.plane_tests);
}

/// Long boxes, turned in all ways.
SnapshotPtr turnedBoxes() {
  std::mt19937_64 random(31);
  std::vector<std::array<double, 12>> boxes;
  for (int i = 0; i < 4'000; ++i) {
    const double a = uniform(random, 0, 6.28), b = uniform(random, 0, 6.28);
    const double ca = std::cos(a), sa = std::sin(a), cb = std::cos(b), sb = std::sin(b);
    const glm::dvec3 size(uniform(random, 5, 20), 0.5, 0.5);
    const auto at = [&] { return uniform(random, -60, 60); };
    boxes.push_back({ca * size.x, -sa * cb * size.y, sa * sb * size.z, at(), sa * size.x,
                     ca * cb * size.y, -ca * sb * size.z, at(), 0, sb * size.y, cb * size.z, at()});
  }
  return boxScene(boxes);
}

TEST(FrustumSettings, OrientedBoxesLeaveOutMoreAndSpheresComeFirst) {
  const SnapshotPtr scene = turnedBoxes();
  const Work plain = turningView(*withSettings("", scene));
  const Work oriented = turningView(*withSettings(":oriented=on", scene));
  EXPECT_LT(20 * oriented.answered, 19 * plain.answered);
  const Work no_sphere = turningView(*withSettings(":oriented=on:sphere=off", scene));
  EXPECT_EQ(no_sphere.answered, oriented.answered);
  EXPECT_NE(no_sphere.plane_tests, oriented.plane_tests);
}

TEST(FrustumSettings, OrientedBoxesKeepAllThatReachesIntoTheFrustum) {
  const SnapshotPtr scene = turnedBoxes();
  const auto culler = withSettings(":oriented=on:octants=on:coherence=on", scene);
  std::mt19937_64 random(41);
  ViewState view;
  for (int n = 0; n < 60; ++n) {
    Camera camera = n % 2 == 0 ? perspectiveCamera(random, {0, 0, 0}, 60.0)
                               : matrixCamera(random, {0, 0, 0}, 60.0);
    const Answer answer = culler->cull(camera, {}, view);
    for (ObjectId id = 0; id < scene->objectCount(); ++id) {
      if (std::binary_search(answer.visible.begin(), answer.visible.end(), id)) continue;
      const Instance& instance = scene->instance(id);
      bool out = false;
      for (const QuadPlane& plane : exactPlanes(camera)) {
        bool all = true;
        for (const glm::vec3& corner : scene->mesh(instance.mesh).positions) {
          const glm::dvec3 p(corner);
          Quad value = plane.d;
          for (std::size_t i = 0; i < 3; ++i) {
            const double* row = &instance.world_from_mesh[4 * i];
            const auto axis = static_cast<int>(i);
            value +=
                plane.n[i] * (static_cast<Quad>(row[0]) * p.x + static_cast<Quad>(row[1]) * p.y +
                              static_cast<Quad>(row[2]) * p.z + static_cast<Quad>(row[3]) -
                              camera.origin_world[axis]);
          }
          all = all && value < 0;
        }
        out = out || all;
      }
      ASSERT_TRUE(out) << "camera " << n << " object " << id;
    }
  }
}

TEST(FrustumSettings, WhatWaitsBesideTheTreeIsAnsweredWhereItIs) {
  std::mt19937_64 random(51);
  SnapshotPtr scene = boxScene(randomBoxes(2'000, {0, 0, 0}, 50.0, 52));
  std::unique_ptr<Culler> late = withSettings(":late=64", scene), now = withSettings("", scene);
  ViewState a, b;
  std::size_t waited = 0;
  for (int n = 0; n < 150; ++n) {
    const auto id = static_cast<ObjectId>(random() % 2'000);
    auto t = scene->instance(id).world_from_mesh;
    t[3] += uniform(random, -20, 20);
    const Edit choices[] = {MoveObject{id, t}, MoveObject{id, t}, HideObject{id}, ShowObject{id},
                            AddInstance{id, t}};
    const auto edited =
        applyEdits(scene, std::vector<Edit>{choices[random() % (n % 20 == 0 ? 5 : 4)]});
    ASSERT_TRUE(edited.ok());
    scene = edited.value().snapshot;
    late = std::move(late->edited(scene, edited.value().changed)).value();
    now = std::move(now->edited(scene, edited.value().changed)).value();
    const Camera camera = perspectiveCamera(random, {0, 0, 0}, 50.0);
    const Answer x = late->cull(camera, {}, a), y = now->cull(camera, {}, b);
    ASSERT_EQ(x.visible, y.visible) << n;
    ASSERT_EQ(x.stats.outside, y.stats.outside);
    waited += dynamic_cast<const HoldsBoxes&>(*late).boxes() == nullptr ? 1U : 0U;
  }
  EXPECT_GT(waited, 100U);
}

TEST(Frustum, HoldsAtMost45BytesPerObject) {
  const auto scene = boxScene(randomBoxes(50000, {0, 0, 0}, 100.0, 9));
  EXPECT_LE(prepared(scene)->preparedBytes(), 45U * 50000U);
}

}  // namespace
}  // namespace culld::testing
