#include "culling/planner/auto_method.h"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <cmath>
#include <thread>

#include "culling/scene/edit.h"
#include "tests/scenes/row_of_objects.h"
#include "tests/unit/planner/counted_method.h"

namespace culld::testing {
namespace {

using std::chrono::microseconds;

using scenes::rowOfObjects;

Camera at(double x) {
  LookAt look;
  look.eye = {x, 0.5, 5.0};
  look.target = {x, 0.5, 0.0};
  return cameraFromLookAt(look, {}).value();
}

constexpr std::uint32_t kObjects = 1000;
constexpr double kMiddle = 500.0;  // of a row of as many

/// Frustum culling of everything for 10 us.
CountedMethod boxes() {
  return {"frustum", "boxes", [](const Camera&) {
            return CountedFrame{microseconds(10), kObjects, kObjects};
          }};
}

/// An occlusion stage of 1 ms that hides `hidden` objects.
CountedMethod hiding(std::uint32_t hidden) {
  return {"hider", "triangles", [hidden](const Camera&) {
            return CountedFrame{microseconds(1000), kObjects, kObjects - hidden};
          }};
}

std::unique_ptr<Culler> prepared(std::span<const Method* const> stages, const SnapshotPtr& scene) {
  auto culler = AutoMethod(stages).prepare(scene, steadyClock());
  EXPECT_TRUE(culler.ok()) << culler.error().message;
  return std::move(culler).value();
}

TEST(AutoMethod, UsesTheStageThatHidesMoreThanItCosts) {
  const CountedMethod frustum = boxes(), hider = hiding(500);
  const Method* stages[] = {&frustum, &hider};
  const auto culler = prepared(stages, rowOfObjects(kObjects));
  EXPECT_TRUE(planOf(*culler)->occlusion_built);
  ViewState view;
  const Answer answer = culler->cull(at(0), {}, view);
  EXPECT_EQ(answer.visible.size(), 500U);
  EXPECT_EQ(answer.made_by, "hider");
  EXPECT_TRUE(answer.note.empty());
}

TEST(AutoMethod, NeitherUsesNorKeepsAStageThatHidesNothing) {
  const CountedMethod frustum = boxes(), hider = hiding(0);
  const Method* stages[] = {&frustum, &hider};
  const auto culler = prepared(stages, rowOfObjects(kObjects));
  EXPECT_EQ(hider.alive, 0);
  EXPECT_EQ(culler->preparedBytes(), frustum.bytes);
  ViewState view;
  const Answer answer = culler->cull(at(0), {}, view);
  EXPECT_EQ(answer.made_by, "frustum");
  EXPECT_EQ(answer.note, "no occlusion: it does not pay here");
  EXPECT_NE(planOf(*culler)->why.find("pays in 0 of 32 sampled views"), std::string::npos);
}

TEST(AutoMethod, PreparesNoStageWhereNothingBlocks) {
  const CountedMethod frustum = boxes(), hider = hiding(500);
  const Method* stages[] = {&frustum, &hider};
  const auto culler = prepared(stages, rowOfObjects(kObjects, false));
  EXPECT_EQ(hider.prepared, 0);
  EXPECT_EQ(planOf(*culler)->occlusion, nullptr);
  EXPECT_EQ(planOf(*culler)->why, "nothing in the scene blocks a view");
}

TEST(AutoMethod, NeverTakesAMethodThatMayMiss) {
  const CountedMethod frustum = boxes();
  CountedMethod loose = hiding(900), sampled = hiding(900);
  loose.guarantee = Guarantee::kApproximate;
  sampled.guarantee = Guarantee::kSampled;
  const Method* stages[] = {&loose, &sampled, &frustum};
  const auto culler = prepared(stages, rowOfObjects(kObjects));
  ViewState view;
  EXPECT_EQ(culler->cull(at(0), {}, view).visible.size(), kObjects);
  EXPECT_EQ(loose.prepared + sampled.prepared, 0);
}

TEST(AutoMethod, GoesOnWithoutAStageThatDeclinesOrFails) {
  const CountedMethod frustum = boxes();
  CountedMethod declines = hiding(900), fails = hiding(900);
  declines.refusal = "too many triangles";
  fails.fails_to_prepare = true;
  const Method* with_declined[] = {&frustum, &declines};
  const Method* with_failed[] = {&frustum, &fails};
  for (const auto& [stages, why] : {std::pair(std::span(with_declined), "too many triangles"),
                                    std::pair(std::span(with_failed), "no memory")}) {
    const auto culler = prepared(stages, rowOfObjects(kObjects));
    const Plan& plan = *planOf(*culler);
    EXPECT_EQ(plan.occlusion, nullptr);
    EXPECT_EQ(plan.why, "no other conservative method is for this scene");
    ASSERT_EQ(plan.others.size(), 1U);
    EXPECT_EQ(plan.others[0].name, "hider");
    EXPECT_EQ(plan.others[0].why, why);
  }
}

/// Hides `hidden` objects in `work`.
CountedMethod stage(const char* name, std::uint32_t hidden, std::chrono::microseconds work) {
  return {name, "triangles", [=](const Camera&) {
            return CountedFrame{work, kObjects, kObjects - hidden};
          }};
}

TEST(AutoMethod, TakesOfManyStagesTheOneThatBringsMost) {
  using std::chrono::milliseconds;
  const CountedMethod frustum = boxes(), dear = stage("dear", 900, milliseconds(40)),
                      weak = stage("weak", 100, milliseconds(1)),
                      good = stage("good", 850, milliseconds(5));
  for (const std::array<const Method*, 4>& stages :
       {std::array<const Method*, 4>{&frustum, &dear, &weak, &good},
        {&good, &weak, &dear, &frustum}}) {
    const auto culler = prepared(stages, rowOfObjects(kObjects));
    const Plan& plan = *planOf(*culler);
    EXPECT_EQ(plan.occlusion, &good);
    EXPECT_EQ(plan.others.size(), 2U);
    ViewState view;
    EXPECT_EQ(culler->cull(at(0), {}, view).made_by, "good");
    EXPECT_EQ(dear.alive + weak.alive, 0) << "what is not used is not kept";
  }
}

TEST(AutoMethod, TakesACheapStageForItsBaseAndADearOneWhereItBringsMore) {
  const CountedMethod frustum = boxes(), cheap = stage("cheap", 500, microseconds(50));
  // It hides more only from the left.
  const CountedMethod dear("dear", "triangles", [](const Camera& camera) {
    const bool left = camera.origin_world[0] < kMiddle + 350;
    return CountedFrame{std::chrono::milliseconds(8), kObjects, left ? 50U : 500U};
  });
  const Method* stages[] = {&frustum, &dear, &cheap};
  const auto culler = prepared(stages, rowOfObjects(kObjects));
  const Plan& plan = *planOf(*culler);
  EXPECT_EQ(plan.base, &cheap);
  EXPECT_EQ(plan.occlusion, &dear);
  EXPECT_TRUE(plan.others.empty());
  EXPECT_EQ(plan.meanBaseShare(), 0.5);
  EXPECT_TRUE(plan.occlusion_built) << plan.why;
  EXPECT_EQ(frustum.alive, 0);
  ViewState view;
  for (int round = 0; round < 3; ++round) {
    for (const PlannedView& sampled : plan.views) {
      const bool pays = sampled.gain.count() > 0;
      EXPECT_EQ(culler->cull(sampled.camera, {}, view).made_by, pays ? "dear" : "cheap");
    }
  }
}

TEST(AutoMethod, NoBaseButTheFrustumIsTakenForALittle) {
  const CountedMethod frustum = boxes(), hider = stage("hider", 900, std::chrono::milliseconds(8)),
                      cheap = stage("cheap", 1, microseconds(20));
  const Method* stages[] = {&frustum, &hider, &cheap};
  const auto culler = prepared(stages, rowOfObjects(kObjects));
  EXPECT_EQ(planOf(*culler)->base, &frustum);
  EXPECT_EQ(planOf(*culler)->occlusion, &hider);
}

TEST(AutoMethod, TriesNoOtherStageIfTheFirstCostsNextToNothing) {
  const CountedMethod frustum = boxes(), hider = hiding(100), other = hiding(500);
  const Method* stages[] = {&frustum, &hider, &other};
  const auto culler = prepared(stages, rowOfObjects(kObjects));
  EXPECT_EQ(other.prepared, 0);
  ASSERT_EQ(planOf(*culler)->others.size(), 1U);
  EXPECT_EQ(planOf(*culler)->others[0].why, "not tried: hider costs too little to save");
}

TEST(AutoMethod, IsAnErrorIfNoConservativeMethodIsLeft) {
  CountedMethod loose = boxes();
  loose.guarantee = Guarantee::kApproximate;
  const Method* stages[] = {&loose};
  const AutoMethod method(stages);
  EXPECT_FALSE(method.accepts({}).ok());
  const auto culler = method.prepare(rowOfObjects(3), steadyClock());
  ASSERT_FALSE(culler.ok());
  EXPECT_EQ(culler.error().code, ErrorCode::kUnsupported);
}

TEST(AutoMethod, WatchesWhatOcclusionBringsUnderAMotionBoundToo) {
  for (const bool holds_in_motion : {true, false}) {
    const CountedMethod frustum = boxes();
    const CountedMethod hider("hider", "triangles", [&](const Camera& camera) {
      const bool hides = camera.motion.still() || holds_in_motion;
      return CountedFrame{std::chrono::microseconds(500), kObjects, hides ? 10U : kObjects};
    });
    const Method* stages[] = {&frustum, &hider};
    const auto culler = prepared(stages, rowOfObjects(kObjects));
    Camera camera = at(0);
    camera.motion.radius_m = 0.5;
    ViewState view;
    Answer answer;
    for (int frame = 0; frame < 100; ++frame) answer = culler->cull(camera, {}, view);
    EXPECT_EQ(answer.made_by, holds_in_motion ? "hider" : "frustum");
  }
}

TEST(AutoMethod, AnswersEqualSequencesOfCamerasEqually) {
  const CountedMethod
      frustum = boxes(),
      hider = {"hider", "triangles", [](const Camera&camera) {
                 const bool dense = camera.origin_world.x < 500.0;
                 return CountedFrame{microseconds(1000), kObjects, dense ? 100 : kObjects};
               }};
  const Method* stages[] = {&frustum, &hider};
  const auto culler = prepared(stages, rowOfObjects(kObjects));
  ViewState first, second;
  for (int i = 0; i < 3000; ++i) {
    const Camera camera = at(500.0 + 499.0 * std::sin(i * 0.01));
    ASSERT_EQ(culler->cull(camera, {}, first).visible, culler->cull(camera, {}, second).visible);
  }
}

TEST(AutoMethod, BuildsAStageThatIsWantedLaterOnceForAllViews) {
  std::atomic<bool> dense = false;
  const CountedMethod frustum = boxes();
  const CountedMethod hider("hider", "triangles", [&](const Camera&) {
    return CountedFrame{microseconds(100), kObjects, dense ? 10 : kObjects};
  });
  const Method* stages[] = {&frustum, &hider};
  const auto culler = prepared(stages, rowOfObjects(kObjects));
  EXPECT_EQ(hider.alive, 0);
  const std::size_t bytes = culler->preparedBytes();
  dense = true;
  std::array<int, 3> taken_at{};  // the frame, which must not hang on the other views
  {
    std::vector<std::jthread> threads;
    for (int& frame : taken_at) {
      threads.emplace_back([&] {
        ViewState view;
        while (frame < 200'000 && culler->cull(at(0), {}, view).made_by != "hider") ++frame;
      });
    }
  }
  EXPECT_LT(taken_at[0], 200'000);
  EXPECT_EQ(taken_at[1], taken_at[0]);
  EXPECT_EQ(taken_at[2], taken_at[0]);
  EXPECT_EQ(hider.prepared, 2);
  EXPECT_EQ(hider.alive, 1);
  EXPECT_GT(culler->preparedBytes(), bytes);
}

TEST(AutoMethod, RefitsWhatItHasBuiltAndKeepsItsPlan) {
  const CountedMethod frustum = boxes(), hider = hiding(0), good = hiding(900);
  SnapshotPtr scene = rowOfObjects(kObjects);
  const auto edit = applyEdits(scene, std::vector<Edit>{HideObject{3}});
  ASSERT_TRUE(edit.ok());
  const Method* without[] = {&frustum, &hider};
  const auto plain = prepared(without, scene);
  const auto next = plain->edited(edit.value().snapshot, edit.value().changed);
  ASSERT_TRUE(next.ok());
  EXPECT_EQ(frustum.refitted, 1);
  EXPECT_EQ(hider.refitted, 0);
  EXPECT_EQ(planOf(*next.value()), planOf(*plain));
  const Method* with[] = {&frustum, &good};
  const auto both = prepared(with, scene);
  ASSERT_TRUE(both->edited(edit.value().snapshot, edit.value().changed).ok());
  EXPECT_EQ(good.refitted, 1);
}

TEST(AutoMethod, PlansAnewForASceneTwiceOrHalfAsLarge) {
  const CountedMethod frustum = boxes(), good = hiding(900);
  const Method* stages[] = {&frustum, &good};
  SnapshotPtr scene = rowOfObjects(kObjects);
  std::unique_ptr<Culler> culler = prepared(stages, scene);
  ViewState view;
  const auto hide = [&](ObjectId from, ObjectId to) {
    std::vector<Edit> edits;
    for (ObjectId id = from; id < to; ++id) edits.push_back(HideObject{id});
    auto next = applyEdits(scene, edits);
    ASSERT_TRUE(next.ok());
    auto edited = culler->edited(next.value().snapshot, next.value().changed);
    ASSERT_TRUE(edited.ok());
    scene = next.value().snapshot;
    culler = std::move(edited).value();
    view.sceneEdited();
    EXPECT_FALSE(culler->cull(at(0), {}, view).visible.empty());
  };
  hide(0, 300);
  hide(100, 450);
  EXPECT_EQ(good.prepared, 1);
  EXPECT_EQ(planOf(*culler)->profile.objects, kObjects);
  hide(450, 501);
  EXPECT_EQ(good.prepared, 2);
  EXPECT_EQ(planOf(*culler)->profile.objects, kObjects - 501);
  std::vector<Edit> shown;
  for (ObjectId id = 0; id < 501; ++id) shown.push_back(ShowObject{id});
  const auto all = applyEdits(scene, shown);
  ASSERT_TRUE(all.ok());
  const auto grown = culler->edited(all.value().snapshot, all.value().changed);
  ASSERT_TRUE(grown.ok());
  EXPECT_EQ(planOf(*grown.value())->profile.objects, kObjects);
}

}  // namespace
}  // namespace culld::testing
