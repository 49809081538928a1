#include "server/translate.h"

#include <gtest/gtest.h>

#include "server/http_api.h"

namespace culld::server {
namespace {

TEST(Translate, PacksFlagsLowestBitFirst) {
  const std::vector<std::uint8_t> flags = {1, 0, 0, 1, 0, 0, 0, 0, 0, 1};
  EXPECT_EQ(packBits(flags), (std::vector<std::uint8_t>{0b1001, 0b10}));
  EXPECT_TRUE(packBits({}).empty());
}

TEST(Translate, CarriesALookAtOver) {
  protocol::LookAt look;
  look.eye = {1, 2, 3};
  look.target = {1, 2, 0};
  protocol::Camera camera;
  camera.pose = look;
  camera.width_px = 640;
  camera.radius_m = 0.5;
  const auto engine = toEngine(camera);
  ASSERT_TRUE(engine.ok()) << engine.error().message;
  EXPECT_EQ(engine.value().origin_world, glm::dvec3(1, 2, 3));
  EXPECT_EQ(engine.value().width_px, 640U);
  EXPECT_EQ(engine.value().motion.radius_m, 0.5);
}

TEST(Translate, CarriesEveryKindOfEditOver) {
  std::array<double, 12> rows{};
  rows[3] = 7;
  const std::vector<protocol::EditItem> items = {{protocol::EditKind::kMove, 1, rows},
                                                 {protocol::EditKind::kHide, 2, {}},
                                                 {protocol::EditKind::kShow, 3, {}},
                                                 {protocol::EditKind::kRemove, 4, {}},
                                                 {protocol::EditKind::kAdd, 5, rows}};
  const auto edits = toEngine(items);
  ASSERT_EQ(edits.size(), 5U);
  EXPECT_EQ(std::get<MoveObject>(edits[0]).world_from_mesh[3], 7);
  EXPECT_EQ(std::get<HideObject>(edits[1]).object, 2U);
  EXPECT_EQ(std::get<ShowObject>(edits[2]).object, 3U);
  EXPECT_EQ(std::get<RemoveObject>(edits[3]).object, 4U);
  EXPECT_EQ(std::get<AddInstance>(edits[4]).like, 5U);
}

TEST(Routes, TakePathsApart) {
  using Kind = Route::Kind;
  const std::vector<std::tuple<const char*, Kind, const char*>> table = {
      {"/", Kind::kPage, ""},
      {"/livez", Kind::kLivez, ""},
      {"/readyz?x=1", Kind::kReadyz, ""},
      {"/version", Kind::kVersion, ""},
      {"/metrics", Kind::kMetrics, ""},
      {"/v1/status", Kind::kStatus, ""},
      {"/v1/scenes", Kind::kScenes, ""},
      {"/v1/scenes/city", Kind::kScene, "city"},
      {"/v1/scenes/", Kind::kScene, ""},
      {"/v1/scenes/city/objects", Kind::kObjects, "city"},
      {"/v1/scenes/city/live", Kind::kLive, "city"},
      {"/v1/scenes/city/else", Kind::kUnknown, ""},
      {"/v1/scenes/a/b/live", Kind::kUnknown, ""},
      {"/v1/scenesX", Kind::kUnknown, ""},
      {"", Kind::kUnknown, ""},
      {"http://host/livez", Kind::kLivez, ""},
      {"HTTP://host:7420/v1/scenes/city?x=/y", Kind::kScene, "city"},
      {"https://host/v1/scenes/a/live", Kind::kLive, "a"},
      {"http://host", Kind::kPage, ""},
      {"http://host?x=1", Kind::kPage, ""},
      {"http://", Kind::kUnknown, ""},
      {"http:///livez", Kind::kUnknown, ""},
      {"ftp://host/livez", Kind::kUnknown, ""},
      {"*", Kind::kUnknown, ""}};
  for (const auto& [target, kind, scene] : table) {
    const Route route = routeOf(target);
    EXPECT_EQ(static_cast<int>(route.kind), static_cast<int>(kind)) << target;
    EXPECT_EQ(route.scene, scene) << target;
  }
}

}  // namespace
}  // namespace culld::server
