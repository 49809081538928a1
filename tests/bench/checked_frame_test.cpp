#include "tests/bench/checked_frame.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "tests/scenes/known_scenes.h"

namespace culld::bench {
namespace {

namespace fs = std::filesystem;

/// Two boxes, one before the other, as files.
class CheckedFrameTest : public testing::Test {
 protected:
  void SetUp() override {
    dir_ =
        fs::temp_directory_path() / ("culld-check-" + std::to_string(getpid()) + "-" +
                                     testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::create_directories(dir_);
    for (scenes::KnownScene& known : scenes::knownScenes()) {
      if (known.name == "wall_hides_box") known_ = std::move(known);
    }
    ASSERT_EQ(known_.must_be_visible.size(), 1U);
    ASSERT_EQ(known_.can_be_hidden.size(), 1U);
    const std::vector<std::byte> glb = scenes::toGlb(known_.model);
    std::string bytes(glb.size(), '\0');
    std::transform(glb.begin(), glb.end(), bytes.begin(),
                   [](std::byte b) { return static_cast<char>(b); });
    write("scene.glb", bytes);
    write("cameras.json", scenes::toJson(std::span(&known_.camera, 1)));
  }
  void TearDown() override { fs::remove_all(dir_); }

  std::string path(const char* name) const { return (dir_ / name).string(); }
  void write(const char* name, const std::string& text) const {
    std::ofstream(path(name), std::ios::binary) << text;
  }
  Result<Inputs> read(const std::string& frames) const {
    write("answers.json", R"({"method":"m","guarantee":"conservative","frames":)" + frames + "}");
    return readInputs(path("scene.glb"), path("cameras.json"), path("answers.json"));
  }
  CheckedFrame check(const std::string& frames) const {
    auto inputs = read(frames);
    EXPECT_TRUE(inputs.ok()) << (inputs.ok() ? "" : inputs.error().message);
    auto oracle = Oracle::build(inputs.value().scene);
    auto frame = checkFrame(inputs.value(), inputs.value().frames.at(0), *oracle.value(),
                            {.max_samples = 20'000});
    EXPECT_TRUE(frame.ok());
    return std::move(frame).value();
  }
  std::string node(ObjectId id) const { return std::to_string(known_.snapshot->instance(id).node); }

  fs::path dir_;
  scenes::KnownScene known_;
};

TEST_F(CheckedFrameTest, FindsNothingMissedInAnAnswerWithAllThatIsVisible) {
  const std::string seen = node(known_.must_be_visible[0]), hidden = node(known_.can_be_hidden[0]);
  const CheckedFrame frame = check(R"([{"camera":0,"visible":[)" + seen + "," + hidden + "]}]");
  EXPECT_EQ(frame.missed + frame.missed_subpixel, 0U);
  EXPECT_EQ(frame.answered, 2U);
  EXPECT_EQ(frame.visible, 1U);
  EXPECT_EQ(frame.in_frustum, 2U);
  EXPECT_DOUBLE_EQ(frame.excess(), 2.0);
  EXPECT_EQ(frame.answered_triangles, frame.frustum_triangles);
}

TEST_F(CheckedFrameTest, FindsAVisibleObjectThatIsNotAnswered) {
  const std::string hidden = node(known_.can_be_hidden[0]);
  const CheckedFrame frame = check(R"([{"camera":0,"visible":[)" + hidden + "]}]");
  EXPECT_EQ(frame.missed, 1U);
  EXPECT_GT(frame.missed_px, 100.0);
  ASSERT_EQ(frame.examples.size(), 1U);
  EXPECT_EQ(std::to_string(frame.examples[0].node), node(known_.must_be_visible[0]));
}

TEST_F(CheckedFrameTest, LooksFromOtherPosesWithinTheMotionBound) {
  auto inputs = read(R"([{"camera":0,"visible":[)" + node(known_.must_be_visible[0]) + "]}]");
  ASSERT_TRUE(inputs.ok());
  inputs.value().cameras[0].motion.radius_m = 7.0;  // far enough to look behind the wall
  auto oracle = Oracle::build(inputs.value().scene);
  const auto frame = checkFrame(inputs.value(), inputs.value().frames[0], *oracle.value(),
                                {.max_samples = 20'000});
  ASSERT_TRUE(frame.ok());
  EXPECT_EQ(frame.value().missed + frame.value().missed_subpixel, 1U);
}

TEST_F(CheckedFrameTest, DrawsTwoPicturesOfAFrame) {
  auto inputs = read(R"([{"camera":0,"visible":[]}])");
  ASSERT_TRUE(inputs.ok());
  auto oracle = Oracle::build(inputs.value().scene);
  const AnsweredFrame& answered = inputs.value().frames[0];
  const auto frame = checkFrame(inputs.value(), answered, *oracle.value(), {.max_samples = 20'000});
  ASSERT_TRUE(frame.ok());
  ASSERT_TRUE(drawFrame(inputs.value(), answered, frame.value(), *oracle.value(), dir_).ok());
  EXPECT_TRUE(fs::exists(path("camera-000.png")));
  EXPECT_TRUE(fs::exists(path("above-000.png")));
}

TEST_F(CheckedFrameTest, NamesTheFileAndPlaceOfABadAnswer) {
  const auto message = [this](const std::string& frames) {
    const auto inputs = read(frames);
    return inputs.ok() ? std::string("read") : inputs.error().message;
  };
  const std::string file = path("answers.json") + ": ";
  EXPECT_EQ(message(R"([{"camera":7,"visible":[]}])"),
            file + "camera 7 is not in the cameras file");
  EXPECT_EQ(message(R"([{"camera":0,"visible":[99]}])"),
            file + "camera 0: node 99 is not in the scene");
  EXPECT_EQ(message(R"([{"camera":0,"visible":[0],"instances":{"0":[5]}}])"),
            file + "camera 0: node 0 is not in the scene");
  EXPECT_NE(message(R"([{"camera":0}])").find(file + "not an answers file"), std::string::npos);
  EXPECT_NE(message("[").find(file + "not an answers file"), std::string::npos);
}

}  // namespace
}  // namespace culld::bench
