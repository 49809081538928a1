#include <gtest/gtest.h>

#include <set>

#include "culling/culler.h"
#include "culling/scene/scene_builder.h"
#include "tests/scenes/shapes.h"

namespace culld {
namespace {

TEST(AllMethods, HaveDistinctNamesThatFindThem) {
  std::set<std::string_view> names;
  for (const Method* method : allMethods()) {
    const MethodInfo info = method->info();
    EXPECT_FALSE(info.name.empty());
    EXPECT_FALSE(info.source.empty()) << info.name;
    EXPECT_TRUE(names.insert(info.name).second) << info.name;
    EXPECT_EQ(findMethod(info.name), method);
  }
  EXPECT_TRUE(names.contains("frustum"));
}

TEST(AllMethods, AreNotFoundByAnyOtherName) {
  EXPECT_EQ(findMethod(""), nullptr);
  EXPECT_EQ(findMethod("Frustum"), nullptr);
  EXPECT_EQ(findMethod("frustum "), nullptr);
}

TEST(AllMethods, AnswerNothingForAnEmptyScene) {
  const SnapshotPtr empty = std::make_shared<const SceneSnapshot>();
  for (const Method* method : allMethods()) {
    auto culler = method->prepare(empty);
    ASSERT_TRUE(culler.ok()) << method->info().name << ": " << culler.error().message;
    ViewState view;
    const Answer answer = culler.value()->cull(cameraFromLookAt({}, {}).value(), {}, view);
    EXPECT_TRUE(answer.visible.empty());
    EXPECT_FALSE(answer.out_of_budget);
  }
}

/// Occluders of few blocking triangles, with far more vertices than the cells they are on: what is
/// transformed is all of them.
TEST(AllMethods, DrawNoMeshWithMuchMoreDetailThanCells) {
  scenes::Random random(1);
  for (const std::uint32_t rings : {4U, 100U}) {
    const scenes::Triangles glass = scenes::ball(rings, 0.0, random);
    const scenes::Triangles pane = scenes::quad({-1, -1, 0}, {2, 0, 0}, {0, 2, 0});
    SceneBuilder builder;
    const MeshId mesh = builder.addMesh(makeMesh({{glass.positions, glass.indices, false, false},
                                                  {pane.positions, pane.indices, true, false}}));
    for (std::uint32_t i = 0; i < 16; ++i) {
      const double x = 3.0 * (i % 4) - 4.5, y = 3.0 * (i / 4) - 4.5;
      builder.addInstance(mesh, {1, 0, 0, x, 0, 1, 0, y, 0, 0, 1, -40}, i);
    }
    const SnapshotPtr scene = builder.finish();
    for (const char* name : {"raster", "z-pyramid", "polygon-tiling", "horizon", "occlusion-map",
                             "layers", "backface-clusters"}) {
      const auto culler = findMethod(name)->prepare(scene).value();
      ViewState view;
      const Answer answer = culler->cull(cameraFromLookAt({}, {}).value(), {}, view);
      EXPECT_EQ(answer.stats.occluders_drawn, rings == 4 ? 16U : 0U) << name;
    }
  }
}

TEST(GuaranteeName, IsTheWordOfTheContract) {
  EXPECT_EQ(guaranteeName(Guarantee::kConservative), "conservative");
  EXPECT_EQ(guaranteeName(Guarantee::kHole), "hole");
  EXPECT_EQ(guaranteeName(Guarantee::kSampled), "sampled");
  EXPECT_EQ(guaranteeName(Guarantee::kApproximate), "approximate");
}

}  // namespace
}  // namespace culld
