// Restarts stay quick after many edits, and an edit is seen at once although it is kept.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>

#include "tests/durability/known_scene.h"

namespace culld::testing {
namespace {

namespace fs = std::filesystem;
namespace wire = protocol;
using Clock = std::chrono::steady_clock;

#ifdef CULLD_SANITIZED
constexpr double kSlower = 10.0;
#else
constexpr double kSlower = 1.0;
#endif

double msSince(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

class RestartTimeTest : public ::testing::Test {
 protected:
  RestartTimeTest() {
    fs::remove_all(folder);
    fs::create_directories(folder);
  }
  ~RestartTimeTest() override {
    daemon.kill();
    fs::remove_all(folder);
  }

  const fs::path folder =
      fs::path(::testing::TempDir()) / ("culld_restart_time_" + std::to_string(::getpid()));
  Daemon daemon{folder / "data"};
};

TEST_F(RestartTimeTest, TwentyScenesWithAHundredThousandEditsAreReadyInASecond) {
  constexpr std::uint32_t kScenes = 20, kObjects = 2500, kEdits = 100'000, kBatch = 500;
  ASSERT_TRUE(daemon.start()) << daemon.log();
  const std::string glb = rowGlb(kObjects);
  SnapshotPtr last;
  for (std::uint32_t s = 0; s < kScenes; ++s) {
    const std::string name = "s" + std::to_string(s);
    ASSERT_EQ(daemon.ask("PUT", "/v1/scenes/" + name, glb).status, 201);
    LiveClient client(daemon.connect(), name);
    ASSERT_TRUE(client.hello().has_value());
    last = loaded(glb);
    for (std::uint32_t done = 0; done < kEdits / kScenes; done += kBatch) {
      std::vector<wire::EditItem> items;
      for (std::uint32_t i = 0; i < kBatch; ++i) {  // every object twice
        const double y = done + i;
        items.push_back(
            {wire::EditKind::kMove, (done + i) % kObjects, {1, 0, 0, 3, 0, 1, 0, y, 0, 0, 1, 0}});
      }
      ASSERT_TRUE(client.send(wire::Edit{0, items}, 1));
      ASSERT_TRUE(client.await<wire::Edited>().has_value());
      last = applied(last, items);
    }
  }
  double best_ms = 1e9;
  for (int i = 0; i < 5; ++i) {  // the machine has other things to do
    daemon.kill();
    const auto start = Clock::now();
    ASSERT_TRUE(daemon.start()) << daemon.log();
    best_ms = std::min(best_ms, msSince(start));
  }
  std::printf("ready %.0f ms after the start\n", best_ms);
  EXPECT_LT(best_ms, 1000.0 * kSlower);
  EXPECT_TRUE(same(askScene(daemon, "s19"), last));
}

TEST_F(RestartTimeTest, AnEditOfOneAmongTwoHundredThousandIsInTheNextAnswer) {
  constexpr std::uint32_t kObjects = 200'000;
  ASSERT_TRUE(daemon.start()) << daemon.log();
  ASSERT_EQ(daemon.ask("PUT", "/v1/scenes/many", rowGlb(kObjects)).status, 201);
  LiveClient client(daemon.connect(), "many");
  ASSERT_TRUE(client.hello().has_value());
  ASSERT_TRUE(client.openView(1, "frustum"));
  wire::LookAt look;
  look.eye = {1000, 0, 5};
  look.target = {1000, 0, 0};
  wire::CameraUpdate camera;
  camera.view = 1;
  camera.camera.pose = look;
  client.send(camera, 1);
  ASSERT_TRUE(client.await<wire::Answer>().has_value());  // the method is prepared
  std::vector<double> times_ms;
  for (std::uint32_t i = 0; i < 100; ++i) {
    const auto start = Clock::now();
    client.send(
        wire::Edit{0, {{i % 2 == 0 ? wire::EditKind::kHide : wire::EditKind::kShow, 1000, {}}}}, 2);
    client.send(camera, 3);
    const auto answer = client.await<wire::Answer>();
    ASSERT_TRUE(answer.has_value());
    times_ms.push_back(msSince(start));
    ASSERT_EQ(answer->scene_version, i + 2);
  }
  std::sort(times_ms.begin(), times_ms.end());
  std::printf("edit to answer: %.2f ms at best, median %.2f ms, worst %.2f ms\n", times_ms.front(),
              times_ms[50], times_ms.back());
  EXPECT_LT(times_ms.front(), 5.0 * kSlower);
}

}  // namespace
}  // namespace culld::testing
