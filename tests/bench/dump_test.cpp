#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "culling/culler.h"
#include "tests/bench/dump_scene.h"
#include "tests/scenes/shapes.h"

namespace culld::bench {
namespace {

namespace fs = std::filesystem;

/// A wall at z = -5; behind it a small box, beside it another one, one behind the camera.
Dump wallDump() {
  Dump dump;
  const scenes::Triangles wall = scenes::box({-2, -2, -5.2F}, {2, 2, -5});
  for (const glm::vec3& p : wall.positions) dump.vertices.push_back({p.x, p.y, p.z});
  dump.indices = wall.indices;
  dump.meshes.push_back({0,
                         static_cast<std::uint32_t>(wall.indices.size()),
                         0,
                         static_cast<std::uint32_t>(wall.positions.size()),
                         {-2, -2, -5.2F},
                         {2, 2, -5}});
  dump.objects = {{{-0.5F, -0.5F, -9}, {0.5F, 0.5F, -8}},
                  {{5, -0.5F, -9}, {6, 0.5F, -8}},
                  {{-1, -1, 5}, {1, 1, 6}}};
  DumpCamera camera{};
  const float near = 0.1F, far = 100.0F, f = 1.0F;
  for (std::size_t i = 0; i < 4; ++i) camera.view[5 * i] = 1.0F;
  camera.projection[0] = camera.projection[5] = f;
  camera.projection[10] = -(far + near) / (far - near);
  camera.projection[11] = -1.0F;
  camera.projection[14] = -2.0F * far * near / (far - near);
  camera.view_projection = camera.projection;
  dump.cameras.push_back(camera);
  return dump;
}

class DumpTest : public testing::Test {
 protected:
  void SetUp() override {
    dir_ =
        fs::temp_directory_path() / ("culld-dump-" + std::to_string(getpid()) + "-" +
                                     testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::create_directories(dir_);
  }
  void TearDown() override { fs::remove_all(dir_); }
  std::string path(const char* name) const { return (dir_ / name).string(); }

  std::string messageFor(const Dump& dump) const {
    writeDump(path("bad.bin"), dump);
    const auto read = readDump(path("bad.bin"));
    return read.ok() ? "no error" : read.error().message;
  }

 private:
  fs::path dir_;
};

TEST_F(DumpTest, ComesBackAsItWasWritten) {
  const Dump dump = wallDump();
  writeDump(path("a.bin"), dump);
  const auto read = readDump(path("a.bin"));
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read.value().vertices, dump.vertices);
  EXPECT_EQ(read.value().indices, dump.indices);
  EXPECT_EQ(read.value().objects.size(), 3U);
  EXPECT_EQ(read.value().cameras.front().projection, dump.cameras.front().projection);
  const Truth truth{640, 360, {{0, 2, {{1, 17}}}}};
  writeTruth(path("a.truth"), truth);
  const auto back = readTruth(path("a.truth"), dump);
  ASSERT_TRUE(back.ok()) << back.error().message;
  EXPECT_EQ(back.value().frames.front().seen, truth.frames.front().seen);
}

TEST_F(DumpTest, NamesTheFileAndWhatIsWrongWithIt) {
  EXPECT_NE(readDump(path("none.bin")).error().message.find("none.bin: cannot open"),
            std::string::npos);
  Dump dump = wallDump();
  dump.indices[4] = 99;
  EXPECT_NE(messageFor(dump).find("mesh 0: index 99 >="), std::string::npos) << messageFor(dump);
  dump = wallDump();
  dump.meshes[0].index_count = 39;
  EXPECT_NE(messageFor(dump).find("mesh 0: its triangles"), std::string::npos);
  writeDump(path("cut.bin"), wallDump());
  const auto size = fs::file_size(path("cut.bin"));
  for (const std::uintmax_t left : {std::uintmax_t{0}, std::uintmax_t{31}, size - 1}) {
    fs::resize_file(path("cut.bin"), left);
    EXPECT_FALSE(readDump(path("cut.bin")).ok()) << left;
    writeDump(path("cut.bin"), wallDump());
  }
  std::ofstream(path("cut.bin"), std::ios::app) << "x";
  EXPECT_NE(readDump(path("cut.bin")).error().message.find("after its end"), std::string::npos);
}

TEST_F(DumpTest, TruthOfAnotherDumpIsRefused) {
  const Dump dump = wallDump();
  writeTruth(path("t"), {1, 1, {{7, 0, {}}}});
  EXPECT_NE(readTruth(path("t"), dump).error().message.find("frame 0: no such camera"),
            std::string::npos);
  writeTruth(path("t"), {1, 1, {{0, 0, {{3, 1}}}}});
  EXPECT_NE(readTruth(path("t"), dump).error().message.find("frame 0: no such object"),
            std::string::npos);
  writeDump(path("t"), dump);
  EXPECT_NE(readTruth(path("t"), dump).error().message.find("not a truth file"), std::string::npos);
}

TEST(DumpScene, RasterHidesTheBoxBehindTheWall) {
  const Dump dump = wallDump();
  const auto camera = toCamera(dump.cameras.front(), {640, 360});
  ASSERT_TRUE(camera.ok()) << camera.error().message;
  const auto culler = findMethod("raster")->prepare(toSnapshot(dump)).value();
  ViewState view;
  for (const bool own_triangles : {true, false}) {
    Demand demand;
    demand.own_triangles = own_triangles;
    EXPECT_EQ(culler->cull(camera.value(), demand, view).visible, (std::vector<ObjectId>{1, 3}));
  }
  EXPECT_EQ(scanBoxes(dump.objects, dump.cameras.front()), 2U);
}

}  // namespace
}  // namespace culld::bench
