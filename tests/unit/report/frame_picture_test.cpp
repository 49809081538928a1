// Pictures are looked at by people; here only what can be read off: sizes, colours, errors.
#include "culling/report/frame_picture.h"

#include <cairo/cairo.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <memory>

#include "culling/scene/scene_builder.h"

namespace culld {
namespace {

RawSurface square(bool blocks) {
  return {{{-0.5F, -0.5F, 0}, {0.5F, -0.5F, 0}, {0.5F, 0.5F, 0}, {-0.5F, 0.5F, 0}},
          {0, 1, 2, 0, 2, 3},
          blocks,
          true};
}

/// A wall (0) that fills the view, one square hidden behind it (1), one outside of the view (2).
SnapshotPtr wallScene() {
  SceneBuilder builder;
  const MeshId mesh = builder.addMesh(makeMesh({square(true)}));
  builder.addInstance(mesh, {100, 0, 0, 0, 0, 100, 0, 0, 0, 0, 1, -5}, 0);
  builder.addInstance(mesh, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, -10}, 1);
  builder.addInstance(mesh, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 10}, 2);
  return builder.finish();
}

struct Pixel {
  unsigned red = 0, green = 0, blue = 0;
};

class Picture {
 public:
  explicit Picture(const std::string& path)
      : surface_(cairo_image_surface_create_from_png(path.c_str()), cairo_surface_destroy) {}
  bool ok() const { return cairo_surface_status(surface_.get()) == CAIRO_STATUS_SUCCESS; }
  int width() const { return cairo_image_surface_get_width(surface_.get()); }
  int height() const { return cairo_image_surface_get_height(surface_.get()); }
  Pixel at(int x, int y) const {
    const unsigned char* p = cairo_image_surface_get_data(surface_.get()) +
                             std::ptrdiff_t{y} * cairo_image_surface_get_stride(surface_.get()) +
                             std::ptrdiff_t{4} * x;
    return {p[2], p[1], p[0]};
  }

 private:
  std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)> surface_;
};

class FramePicture : public testing::Test {
 protected:
  void SetUp() override {
    scene_ = wallScene();
    auto oracle = Oracle::build(scene_);
    ASSERT_TRUE(oracle.ok());
    oracle_ = std::move(oracle).value();
    const auto camera = cameraFromLookAt({}, {320, 180});
    ASSERT_TRUE(camera.ok());
    camera_ = camera.value();
    auto truth = oracle_->look(camera_);
    ASSERT_TRUE(truth.ok());
    truth_ = std::move(truth).value();
    dir_ = std::filesystem::temp_directory_path() /
           ("culld-pictures-" + std::to_string(::testing::UnitTest::GetInstance()->random_seed()) +
            testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::create_directories(dir_);
  }
  void TearDown() override { std::filesystem::remove_all(dir_); }

  FrameToDraw frame(const std::vector<ObjectId>& answered) {
    verdicts_ = judge(*scene_, truth_, answered);
    return {scene_.get(), oracle_.get(), camera_, verdicts_, "a wall"};
  }
  std::string file(const char* name) const { return (dir_ / name).string(); }

  SnapshotPtr scene_;
  std::unique_ptr<Oracle> oracle_;
  Camera camera_;
  OracleAnswer truth_;
  std::vector<Verdict> verdicts_;
  std::filesystem::path dir_;
};

TEST_F(FramePicture, JudgesEachObjectByAnswerAndTruth) {
  using V = Verdict;
  EXPECT_EQ(judge(*scene_, truth_, std::vector<ObjectId>{0}),
            (std::vector<V>{V::kSeen, V::kLeftOut, V::kOutside}));
  EXPECT_EQ(judge(*scene_, truth_, std::vector<ObjectId>{0, 1, 2}),
            (std::vector<V>{V::kSeen, V::kKept, V::kKept}));
  EXPECT_EQ(judge(*scene_, truth_, std::vector<ObjectId>{1}),
            (std::vector<V>{V::kMissed, V::kKept, V::kOutside}));
}

TEST_F(FramePicture, ShowsSeenObjectsGreenishFromTheCamera) {
  ASSERT_TRUE(drawFromCamera(frame({0}), file("camera.png"), 320).ok());
  const Picture picture(file("camera.png"));
  ASSERT_TRUE(picture.ok());
  EXPECT_EQ(picture.width(), 320);
  EXPECT_EQ(picture.height(), 180 + 84 / 4);
  const Pixel corner = picture.at(20, 20);
  EXPECT_GT(corner.green, corner.red + 30);
}

TEST_F(FramePicture, ShowsMissedObjectsInLoudRed) {
  ASSERT_TRUE(drawFromCamera(frame({}), file("camera.png"), 320).ok());
  const Picture picture(file("camera.png"));
  ASSERT_TRUE(picture.ok());
  const Pixel corner = picture.at(20, 20);
  EXPECT_GT(corner.red, corner.green + 60);
  EXPECT_GT(corner.red, corner.blue + 60);
}

TEST_F(FramePicture, DrawsKeptObjectsThroughWhatHidesThem) {
  ASSERT_TRUE(drawFromCamera(frame({0}), file("without.png"), 320).ok());
  ASSERT_TRUE(drawFromCamera(frame({0, 1}), file("with.png"), 320).ok());
  const Picture without(file("without.png")), with(file("with.png"));
  int redder = 0, inner = 0;
  for (int y = 0; y < 180; ++y) {
    for (int x = 0; x < 320; ++x) {
      if (with.at(x, y).red <= without.at(x, y).red + 30) continue;
      ++redder;
      if (std::abs(x - 160) < 20 && std::abs(y - 90) < 20) ++inner;
    }
  }
  EXPECT_GT(inner, 20);  // the outline of the square, in the middle
  EXPECT_EQ(redder, inner);
}

TEST_F(FramePicture, DrawsAMapWithTheCameraAsAWhiteDot) {
  ASSERT_TRUE(drawFromAbove(frame({0, 1}), file("above.png"), 640).ok());
  const Picture picture(file("above.png"));
  ASSERT_TRUE(picture.ok());
  EXPECT_EQ(picture.width(), 640);
  int white = 0;
  for (int y = 0; y < 430; ++y) {
    for (int x = 0; x < 640; ++x) white += picture.at(x, y).blue > 230 ? 1 : 0;
  }
  EXPECT_GT(white, 15);
  EXPECT_LT(white, 400);
}

TEST_F(FramePicture, DrawsScenesWithoutAnythingInThem) {
  scene_ = SceneBuilder().finish();
  auto oracle = Oracle::build(scene_);
  ASSERT_TRUE(oracle.ok());
  oracle_ = std::move(oracle).value();
  truth_ = {};
  EXPECT_TRUE(drawFromCamera(frame({}), file("camera.png"), 320).ok());
  EXPECT_TRUE(drawFromAbove(frame({}), file("above.png"), 320).ok());
}

TEST_F(FramePicture, NamesTheFileThatCannotBeWritten) {
  const std::string path = file("no/such/directory.png");
  const auto drawn = drawFromAbove(frame({0}), path, 320);
  ASSERT_FALSE(drawn.ok());
  EXPECT_EQ(drawn.error().code, ErrorCode::kIo);
  EXPECT_NE(drawn.error().message.find(path), std::string::npos);
}

}  // namespace
}  // namespace culld
