#include "culling/planner/watch.h"

#include <gtest/gtest.h>

namespace culld {
namespace {

using std::chrono::microseconds;
using std::chrono::nanoseconds;

constexpr nanoseconds kPrice = microseconds(50);
constexpr WatchedFrame kBase{microseconds(10), 1000, 1000};
constexpr WatchedFrame kUseless{microseconds(1000), 1000, 1000};
constexpr WatchedFrame kUseful{microseconds(1000), 1000, 500};

Camera at(double x) {
  LookAt look;
  look.eye = {x, 0.0, 0.0};
  look.target = {x, 0.0, -1.0};
  return cameraFromLookAt(look, {}).value();
}

PlannedView sampled(double x, nanoseconds gain) {
  return {at(x), 1000, 1000, 500, microseconds(10), microseconds(1000), gain};
}

std::shared_ptr<const Plan> planWith(std::vector<PlannedView> views) {
  Plan plan;
  plan.object_price = kPrice;
  PlannedStage stage;
  stage.views = std::move(views);
  stage.built = stage.meanGain().count() > 0;
  plan.stages.push_back(std::move(stage));
  return std::make_shared<const Plan>(std::move(plan));
}

std::shared_ptr<const Plan> goodPlan() { return planWith({sampled(0, microseconds(5000))}); }
std::shared_ptr<const Plan> badPlan() { return planWith({sampled(0, -microseconds(1000))}); }

/// `frames` frames of a view where the stage shows `with`; returns how many were made with it.
int fly(Watch& watch, const Camera& camera, const WatchedFrame& with, int frames) {
  int with_stage = 0;
  for (int i = 0; i < frames; ++i) {
    if (watch.wantsStage(camera)) {
      watch.sawStage(with);
      ++with_stage;
    } else {
      watch.sawBase(kBase);
    }
  }
  return with_stage;
}

TEST(Watch, BeginsAsThePlanSays) {
  EXPECT_TRUE(Watch(goodPlan(), 0).wantsStage(at(0)));
  EXPECT_FALSE(Watch(badPlan(), 0).wantsStage(at(0)));
  EXPECT_FALSE(Watch(planWith({}), 0).wantsStage(at(0)));
}

TEST(Watch, StaysOnWhileTheStagePays) {
  Watch watch(goodPlan(), 0);
  EXPECT_EQ(fly(watch, at(0), kUseful, 1000), 1000);
  EXPECT_EQ(watch.switches(), 0U);
}

TEST(Watch, SwitchesOffAfterOneWastedFrameOnAFreshView) {
  Watch watch(goodPlan(), 0);
  EXPECT_EQ(fly(watch, at(0), kUseless, 100), 1);
}

TEST(Watch, ForgivesAFewWastedFramesAfterAGoodTimeAndNotMore) {
  Watch watch(goodPlan(), 0);
  fly(watch, at(0), kUseful, 100);
  const int wasted = fly(watch, at(0), kUseless, 100);
  EXPECT_GE(wasted, 2);
  EXPECT_LE(wasted, 6);
}

TEST(Watch, DoesNotFlickerWhereTheStageAboutBreaksEven) {
  Watch watch(goodPlan(), 0);
  for (int i = 0; i < 2000; ++i) {
    // 15 or 25 objects hidden for the price of 20.
    const WatchedFrame even{microseconds(1000), 1000, i % 2 == 0 ? 975U : 985U};
    if (watch.wantsStage(at(0))) {
      watch.sawStage(even);
    } else {
      watch.sawBase(kBase);
    }
  }
  EXPECT_LE(watch.switches(), 2U);
}

TEST(Watch, RetriesForAFewPerCentOfTheFrustumsWork) {
  Watch watch(badPlan(), 0);
  const int frames = 100'000;
  const int with_stage = fly(watch, at(0), kUseless, frames);
  EXPECT_GE(with_stage, 10);
  EXPECT_LE(with_stage * kUseless.work, 0.035 * frames * kBase.work);
  EXPECT_EQ(watch.retries(), static_cast<std::uint32_t>(with_stage));
}

TEST(Watch, RetriesSoonerOnceTheViewHasChanged) {
  const auto framesToRetry = [](std::uint32_t in_frustum) {
    Watch watch(badPlan(), 0);
    fly(watch, at(0), kUseless, 20'000);
    while (!watch.wantsStage(at(0))) watch.sawBase(kBase);
    watch.sawStage(kUseless);
    int frames = 0;
    while (!watch.wantsStage(at(0))) {
      watch.sawBase({microseconds(10), in_frustum, in_frustum});
      ++frames;
    }
    return frames;
  };
  EXPECT_LT(framesToRetry(3000) * 3, framesToRetry(1000));
}

TEST(Watch, NeverRetriesWhereEvenHidingEverythingCouldNotPay) {
  Watch watch(badPlan(), 0);
  for (int i = 0; i < 100'000; ++i) {
    ASSERT_FALSE(watch.wantsStage(at(0)));
    watch.sawBase({microseconds(10), 15, 15});
  }
  for (int i = 0; i < 100'000; ++i) watch.sawBase(kBase);  // saves up for a retry
  EXPECT_TRUE(watch.wantsStage(at(0)));
  watch.sawBase({microseconds(10), 0, 0});
  EXPECT_FALSE(watch.wantsStage(at(0))) << "nothing is in the frustum";
}

TEST(Watch, SwitchesOnAgainWhenARetryPays) {
  Watch watch(badPlan(), 0);
  const int frames = 20'000;
  EXPECT_GT(fly(watch, at(0), kUseful, frames), frames / 2);
  EXPECT_EQ(watch.retries(), 1U);
}

TEST(Watch, KnowsPlacesApart) {
  Watch watch(planWith({sampled(0, microseconds(5000)), sampled(100, microseconds(-6000)),
                        sampled(200, microseconds(5000))}),
              0);
  EXPECT_TRUE(watch.wantsStage(at(10)));
  watch.sawStage(kUseful);
  EXPECT_FALSE(watch.wantsStage(at(110)));
  watch.sawBase(kBase);
  EXPECT_TRUE(watch.wantsStage(at(190)));
  watch.sawStage(kUseless);
  EXPECT_FALSE(watch.wantsStage(at(190)));  // off here
  watch.sawBase(kBase);
  EXPECT_TRUE(watch.wantsStage(at(10)));  // and still on there
}

TEST(Watch, CountsAFrameCutShortAsNoGainItCannotProve) {
  Watch watch(goodPlan(), 0);
  const WatchedFrame cut{microseconds(1000), 0, 1000};
  EXPECT_LE(fly(watch, at(0), cut, 100), 2);
}

TEST(Watch, BelievesThePlanNoLessWhereItRightlySaidNo) {
  std::vector<PlannedView> views;
  for (int i = 0; i < 30; ++i) views.push_back(sampled(10.0 * i, -microseconds(10'000)));
  views.push_back(sampled(1000.0, microseconds(320'000)));
  Watch watch(planWith(std::move(views)), 0);
  for (int i = 0; i < 30; ++i) {
    fly(watch, at(10.0 * i), kUseless, 15'000);  // long enough for a retry, which is useless
  }
  EXPECT_GE(watch.retries(), 30U);
  EXPECT_EQ(watch.switches(), 0U);
  watch.sawBase({microseconds(10), 5, 5});  // so few that no retry could pay
  EXPECT_FALSE(watch.wantsStage(at(290)));
  EXPECT_TRUE(watch.wantsStage(at(1000)));
}

}  // namespace
}  // namespace culld
