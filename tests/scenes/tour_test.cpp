#include "tests/scenes/tour.h"

#include <gtest/gtest.h>

#include "culling/scene/scene_builder.h"

namespace culld::scenes {
namespace {

SnapshotPtr trianglesAt(const std::vector<glm::dvec3>& places) {
  SceneBuilder builder;
  RawSurface triangle;
  triangle.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  triangle.indices = {0, 1, 2};
  const MeshId mesh = builder.addMesh(makeMesh({triangle}));
  std::uint32_t node = 0;
  for (const glm::dvec3& p : places) {
    builder.addInstance(mesh, {1, 0, 0, p.x, 0, 1, 0, p.y, 0, 0, 1, p.z}, node++);
  }
  return builder.finish();
}

void expectAccepted(const std::vector<CameraSpec>& cameras) {
  for (const CameraSpec& camera : cameras) {
    const auto made = toCamera(camera);
    EXPECT_TRUE(made.ok()) << (made.ok() ? "" : made.error().message);
  }
}

TEST(Tour, GivesUsableCamerasForNoObjectOneObjectAndObjectsFarAway) {
  for (const SnapshotPtr& scene :
       {trianglesAt({}), trianglesAt({{5, 5, 5}}), trianglesAt({{6.4e6, 0, 1}, {6.4e6, 0, 9}})}) {
    const auto cameras = tourCameras(*scene, 8);
    EXPECT_EQ(cameras.size(), 8U);
    expectAccepted(cameras);
  }
}

TEST(Tour, StaysNearTheCrowdWhenOneObjectIsFarAway) {
  std::vector<glm::dvec3> places(100, glm::dvec3(0.0));
  for (std::size_t i = 0; i < places.size(); ++i) places[i].x = static_cast<double>(i);
  places.emplace_back(0.0, 0.0, 1e7);
  for (const CameraSpec& camera : tourCameras(*trianglesAt(places), 8)) {
    EXPECT_LT(std::abs(std::get<LookAt>(camera.pose).eye.z), 1000.0);
  }
}

}  // namespace
}  // namespace culld::scenes
