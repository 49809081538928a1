// Real scenes, when CULLD_SCENES=DIR is set: no method may lack an object that the oracle sees.
// CULLD_SCENES_EVERY=N takes each N-th camera only.
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "culling/scene/gltf_loader.h"
#include "protocol/camera_file.h"
#include "server/translate.h"
#include "tests/soundness/judge.h"

namespace culld {
namespace {

namespace fs = std::filesystem;

std::size_t cameraStep() {
  const char* every = std::getenv("CULLD_SCENES_EVERY");
  return every == nullptr ? 1 : std::max(1UL, std::strtoul(every, nullptr, 10));
}

void judgeScene(const fs::path& file, const fs::path& cameras_file, MotionBound motion,
                std::size_t step) {
  SCOPED_TRACE(file.filename().string());
  auto scene = loadGltfFile(file.string());
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  auto cameras = protocol::readCameraFile(cameras_file.string());
  ASSERT_TRUE(cameras.ok()) << cameras.error().message;
  auto oracle = Oracle::build(scene.value());
  ASSERT_TRUE(oracle.ok()) << oracle.error().message;
  std::vector<PreparedMethod> methods = prepareAll(scene.value());
  std::vector<std::size_t> answered(methods.size(), 0), missed(methods.size(), 0);
  OracleOptions options;
  options.lattice = 1;  // one sample a pixel: all cameras of all scenes within an hour
  std::size_t visible = 0, looks = 0;
  for (std::size_t c = 0; c < cameras.value().size(); c += step) {
    SCOPED_TRACE("camera " + std::to_string(c));
    auto camera = server::toEngine(cameras.value()[c]);
    ASSERT_TRUE(camera.ok()) << camera.error().message;
    if (!motion.still()) camera.value().motion = motion;
    auto truth = oracle.value()->look(camera.value(), options);
    ASSERT_TRUE(truth.ok()) << truth.error().message;
    visible += truth.value().visible.size();
    ++looks;
    for (std::size_t m = 0; m < methods.size(); ++m) {
      const Answer answer = methods[m].culler->cull(camera.value(), {}, methods[m].view);
      expectWellFormed(answer, *scene.value());
      const auto lost = missing(truth.value().visible, answer.visible);
      EXPECT_TRUE(lost.empty()) << methods[m].name << " lacks object " << lost.front();
      answered[m] += answer.visible.size();
      missed[m] += lost.size();
    }
  }
  for (std::size_t m = 0; m < methods.size(); ++m) {
    std::printf("%-28s %-8s cameras %3zu  visible %8.1f  answered %8.1f  missed %zu\n",
                file.stem().c_str(), methods[m].name.c_str(), looks,
                static_cast<double>(visible) / static_cast<double>(looks),
                static_cast<double>(answered[m]) / static_cast<double>(looks), missed[m]);
  }
}

/// False if there are no real scenes to judge.
bool judgeAll(MotionBound motion, std::size_t step) {
  const char* dir = std::getenv("CULLD_SCENES");
  if (dir == nullptr) return false;
  std::size_t judged = 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(dir)) {
    const fs::path cameras = fs::path(entry.path()).replace_extension(".cameras.json");
    if (entry.path().extension() != ".glb" || !fs::exists(cameras)) continue;
    judgeScene(entry.path(), cameras, motion, step);
    ++judged;
  }
  EXPECT_GT(judged, 0U) << "no X.glb with X.cameras.json in " << dir;
  return true;
}

constexpr const char* kNoScenes = "CULLD_SCENES is not set: only generated scenes were judged";

TEST(RealScenes, NoMethodLacksAnObjectThatTheOracleSees) {
  if (!judgeAll({}, cameraStep())) GTEST_SKIP() << kNoScenes;
}

/// Of each tenth camera, as every one of them is a look from thirteen poses.
TEST(RealScenes, NoMethodLacksWhatAPoseWithinAMotionBoundSees) {
  if (!judgeAll({.radius_m = 0.5, .angle_rad = 0.05}, 10 * cameraStep())) GTEST_SKIP() << kNoScenes;
}

}  // namespace
}  // namespace culld
