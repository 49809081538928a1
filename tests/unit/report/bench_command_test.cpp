// The command with methods of the test's own: exit codes and first lines when a promise is broken.
#include "server/bench_command.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "tests/scenes/known_scenes.h"
#include "tests/unit/report/bench_scene.h"

namespace culld::report {
namespace {

namespace fs = std::filesystem;

class BenchCommand : public testing::Test {
 protected:
  void SetUp() override {
    dir_ =
        fs::temp_directory_path() / ("culld-bench-" + std::to_string(getpid()) + "-" +
                                     testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::create_directories(dir_);
    for (scenes::KnownScene& known : scenes::knownScenes()) {
      if (known.name == "wall_hides_box") known_ = std::move(known);
    }
    const std::vector<std::byte> glb = scenes::toGlb(known_.model);
    std::string bytes(glb.size(), '\0');
    std::transform(glb.begin(), glb.end(), bytes.begin(),
                   [](std::byte b) { return static_cast<char>(b); });
    write("wall.glb", bytes);
    write("wall.cameras.json", scenes::toJson(std::span(&known_.camera, 1)));
  }
  void TearDown() override { fs::remove_all(dir_); }

  std::string path(const char* name) const { return (dir_ / name).string(); }
  void write(const char* name, const std::string& text) const {
    std::ofstream(path(name), std::ios::binary) << text;
  }
  std::string firstLine(const char* name) const {
    std::ifstream in(path(name));
    std::string line;
    std::getline(in, line);
    return line;
  }
  int bench(const std::vector<const Method*>& methods) {
    testing::internal::CaptureStdout();
    const int code = runBench({path("wall.glb"), "--report", path("out"), "--samples", "1",
                               "--rays", "4", "--methods", "frustum,raster"},
                              methods);
    out_ = testing::internal::GetCapturedStdout();
    return code;
  }

  fs::path dir_;
  scenes::KnownScene known_;
  std::string out_;
};

TEST_F(BenchCommand, EndsWithOneAndSaysSoFirstWhenAVisibleObjectIsLeftOut) {
  const ScriptedMethod frustum("frustum", Guarantee::kConservative, std::vector<ObjectId>{0, 1});
  const ScriptedMethod wrong("raster", Guarantee::kConservative, known_.can_be_hidden);
  EXPECT_EQ(bench({&frustum, &wrong}), 1);
  const std::string verdict = "GUARANTEE BROKEN: wall.glb, raster, no limit, camera 0: object " +
                              std::to_string(known_.must_be_visible.at(0));
  EXPECT_EQ(out_.rfind(verdict, 0), 0U) << out_;
  EXPECT_EQ(firstLine("out/report.csv").rfind("# " + verdict, 0), 0U);
  EXPECT_EQ(firstLine("out/report.html").rfind("<!-- " + verdict, 0), 0U);
  EXPECT_EQ(firstLine("out/report.json").rfind("{\"verdict\":\"" + verdict, 0), 0U);
}

TEST_F(BenchCommand, EndsWithZeroWhenNothingIsMissing) {
  const ScriptedMethod frustum("frustum", Guarantee::kConservative, std::vector<ObjectId>{0, 1});
  const ScriptedMethod exact("raster", Guarantee::kConservative, known_.must_be_visible);
  EXPECT_EQ(bench({&frustum, &exact}), 0);
  EXPECT_EQ(out_.rfind("guarantees held in all 10 answers\n", 0), 0U) << out_;
}

}  // namespace
}  // namespace culld::report
