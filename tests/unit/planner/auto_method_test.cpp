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
  ASSERT_EQ(planOf(*culler)->stages.size(), 1U);
  EXPECT_TRUE(planOf(*culler)->stages[0].built);
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
  EXPECT_TRUE(planOf(*culler)->stages.empty());
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
    EXPECT_TRUE(plan.stages.empty());
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
    ASSERT_EQ(plan.stages.size(), 1U);
    EXPECT_EQ(plan.stages[0].method, &good);
    EXPECT_EQ(plan.others.size(), 2U);
    ViewState view;
    EXPECT_EQ(culler->cull(at(0), {}, view).made_by, "good");
    EXPECT_EQ(dear.alive + weak.alive, 0) << "what is not used is not kept";
  }
}

TEST(AutoMethod, AnswersEachPlaceByTheStageThatPaysThere) {
  // Cheap and good in the larger half, dear and better at the end; in between neither hides.
  const auto in = [](double from, double to, const Camera& camera) {
    return from <= camera.origin_world[0] && camera.origin_world[0] < to;
  };
  const CountedMethod frustum = boxes();
  const CountedMethod cheap("cheap", "triangles", [&](const Camera& camera) {
    return CountedFrame{microseconds(200), kObjects, in(450, 550, camera) ? kObjects : 500U};
  });
  const CountedMethod dear("dear", "triangles", [&](const Camera& camera) {
    return CountedFrame{std::chrono::milliseconds(8), kObjects,
                        in(550, 5000, camera) ? 50U : kObjects};
  });
  const Method* methods[] = {&frustum, &dear, &cheap};
  const auto culler = prepared(methods, rowOfObjects(kObjects));
  const Plan& plan = *planOf(*culler);
  ASSERT_EQ(plan.stages.size(), 2U);
  EXPECT_EQ(plan.stages[0].method, &cheap);
  EXPECT_EQ(plan.stages[1].method, &dear);
  EXPECT_TRUE(plan.others.empty());
  ViewState view;
  const auto madeBy = [&](double x) {
    std::string_view by;
    for (int i = 0; i < 20'000; ++i) by = culler->cull(at(x), {}, view).made_by;
    return by;
  };
  EXPECT_EQ(madeBy(100), "cheap");
  EXPECT_EQ(madeBy(500), "frustum") << "open country costs what the frustum costs";
  EXPECT_EQ(madeBy(900), "dear");
}

TEST(AutoMethod, TakesNoSecondStageForALittle) {
  const CountedMethod frustum = boxes(), hider = stage("hider", 900, std::chrono::milliseconds(8)),
                      cheap = stage("cheap", 1, microseconds(20));
  const Method* methods[] = {&frustum, &hider, &cheap};
  const auto culler = prepared(methods, rowOfObjects(kObjects));
  ASSERT_EQ(planOf(*culler)->stages.size(), 1U);
  EXPECT_EQ(planOf(*culler)->stages[0].method, &hider);
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

TEST(AutoMethod, CannotFollowToASceneTwiceOrHalfAsLarge) {
  const CountedMethod frustum = boxes(), good = hiding(900);
  const Method* methods[] = {&frustum, &good};
  const auto hidden = [](const SnapshotPtr& scene, ObjectId from, ObjectId to, bool hide) {
    std::vector<Edit> edits;
    for (ObjectId id = from; id < to; ++id) {
      edits.push_back(hide ? Edit(HideObject{id}) : Edit(ShowObject{id}));
    }
    return applyEdits(scene, edits).value();
  };
  const SnapshotPtr scene = rowOfObjects(kObjects);
  const auto culler = prepared(methods, scene);
  const auto fewer = hidden(scene, 0, 400, true);
  const auto half = culler->edited(fewer.snapshot, fewer.changed);
  ASSERT_TRUE(half.ok());
  const auto same = hidden(fewer.snapshot, 100, 500, true);  // 300 of them were hidden before
  ASSERT_TRUE(half.value()->edited(same.snapshot, same.changed).ok());
  const auto less = hidden(fewer.snapshot, 400, 501, true);
  EXPECT_FALSE(half.value()->edited(less.snapshot, less.changed).ok());
  // From there it is planned anew, and then it is too small for all.
  const auto anew = prepared(methods, less.snapshot);
  EXPECT_EQ(planOf(*anew)->profile.objects, 499U);
  const auto all = hidden(less.snapshot, 0, 501, false);
  EXPECT_FALSE(anew->edited(all.snapshot, all.changed).ok());
}

}  // namespace
}  // namespace culld::testing
