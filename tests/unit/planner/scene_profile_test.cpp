#include "culling/planner/scene_profile.h"

#include <gtest/gtest.h>

#include "culling/scene/edit.h"
#include "culling/scene/scene_builder.h"

namespace culld {
namespace {

constexpr std::array<double, 12> kIdentity{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

RawSurface triangles(std::uint32_t count, bool blocks) {
  RawSurface s;
  s.blocks = blocks;
  for (std::uint32_t i = 0; i < count; ++i) {
    const float x = static_cast<float>(i);
    s.positions.insert(s.positions.end(), {{x, 0, 0}, {x + 1, 0, 0}, {x, 1, 0}});
    s.indices.insert(s.indices.end(), {3 * i, 3 * i + 1, 3 * i + 2});
  }
  return s;
}

TEST(SceneProfile, IsZeroForAnEmptyScene) {
  const SceneProfile profile = profileScene(*SceneBuilder().finish());
  EXPECT_EQ(profile.objects, 0U);
  EXPECT_EQ(profile.triangles, 0U);
  EXPECT_EQ(profile.blocking_triangles, 0U);
}

TEST(SceneProfile, CountsEachInstanceAndOnlySurfacesThatBlock) {
  SceneBuilder builder;
  const MeshId mixed = builder.addMesh(makeMesh({triangles(5, true), triangles(3, false)}));
  for (std::uint32_t i = 0; i < 4; ++i) builder.addInstance(mixed, kIdentity, i);
  const SceneProfile profile = profileScene(*builder.finish());
  EXPECT_EQ(profile.objects, 4U);
  EXPECT_EQ(profile.triangles, 32U);
  EXPECT_EQ(profile.blocking_triangles, 20U);
}

TEST(SceneProfile, CountsNoBlockersAmongUnboundedMeshes) {
  SceneBuilder builder;
  Mesh skinned = makeMesh({triangles(5, true)});
  skinned.unbounded = true;
  builder.addInstance(builder.addMesh(std::move(skinned)), kIdentity, 0);
  const SceneProfile profile = profileScene(*builder.finish());
  EXPECT_EQ(profile.objects, 1U);
  EXPECT_EQ(profile.triangles, 5U);
  EXPECT_EQ(profile.blocking_triangles, 0U);
}

TEST(SceneProfile, LeavesOutHiddenAndRemovedObjects) {
  SceneBuilder builder;
  const MeshId mesh = builder.addMesh(makeMesh({triangles(2, true)}));
  for (std::uint32_t i = 0; i < 5; ++i) builder.addInstance(mesh, kIdentity, i);
  const auto edited =
      applyEdits(builder.finish(), std::vector<Edit>{HideObject{0}, RemoveObject{3}});
  ASSERT_TRUE(edited.ok());
  const SceneProfile profile = profileScene(*edited.value().snapshot);
  EXPECT_EQ(profile.objects, 3U);
  EXPECT_EQ(profile.blocking_triangles, 6U);
}

}  // namespace
}  // namespace culld
