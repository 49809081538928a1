// A culler that runs out of time keeps what it has not decided, whenever that happens.
#include <gtest/gtest.h>

#include "tests/scenes/random_scene.h"
#include "tests/soundness/judge.h"

namespace culld {
namespace {

/// Each look at the clock costs a nanosecond: a limit of n ns ends the work at the n-th look.
class CountingClock final : public Clock {
 public:
  std::chrono::nanoseconds now() const noexcept override {
    return std::chrono::nanoseconds(++looks_);
  }

 private:
  mutable std::int64_t looks_ = 0;
};

TEST(TimeLimit, AnAnswerCutShortAnywhereIsASupersetOfTheFullOne) {
  scenes::RandomSceneOptions options;
  options.objects = 1200;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const SnapshotPtr scene = scenes::randomScene(seed, options);
    const Camera camera = scenes::toCamera(scenes::randomCameras(seed, *scene, 1)[0]).value();
    for (const Method* method : allMethods()) {
      const CountingClock clock;
      auto culler = method->prepare(scene, clock);
      ASSERT_TRUE(culler.ok());
      ViewState view;
      const Answer full = culler.value()->cull(camera, {}, view);
      EXPECT_FALSE(full.out_of_budget);
      bool finished = false, cut = false;
      for (int limit = 1; limit < 4000 && !finished; ++limit) {
        Demand demand;
        demand.time = std::chrono::nanoseconds(limit);
        // In turn a view that was cut short before, and a fresh one. `auto` learns from what a view
        // has seen and may answer by another method there: another superset of the truth.
        ViewState fresh;
        const bool again = limit % 2 == 0 && method->info().name != "auto";
        const Answer answer = culler.value()->cull(camera, demand, again ? view : fresh);
        expectWellFormed(answer, *scene);
        EXPECT_TRUE(missing(full.visible, answer.visible).empty()) << method->info().name << limit;
        cut = cut || answer.out_of_budget;
        finished = !answer.out_of_budget && limit % 2 != 0;
        if (finished) {
          EXPECT_EQ(answer.visible, full.visible);
        }
      }
      EXPECT_TRUE(cut) << method->info().name;
      EXPECT_TRUE(finished) << method->info().name;
    }
  }
}

}  // namespace
}  // namespace culld
