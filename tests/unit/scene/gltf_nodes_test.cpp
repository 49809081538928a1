// Trees, transforms, scenes and instances.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>

#include "tests/unit/scene/gltf_file.h"

namespace culld::test {
namespace {

using Rows = std::array<double, 12>;

Rows worldOf(const SnapshotPtr& scene, ObjectId id) { return scene->instance(id).world_from_mesh; }

GltfFile fileWithTriangle() {
  GltfFile file;
  file.mesh(file.positions(kTriangle));
  return file;
}

TEST(GltfNodes, LoadsTheNodesThatCarryAMeshInTheOrderOfTheirNumbers) {
  GltfFile file = fileWithTriangle();
  file.node(R"({"children":[3,1]})");
  file.nodeWith(0);
  file.node(R"({"name":"empty"})");
  file.nodeWith(0);
  const auto scene = load(file.glb());
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  ASSERT_EQ(scene.value()->objectCount(), 2U);
  EXPECT_EQ(scene.value()->instance(0).node, 1U);
  EXPECT_EQ(scene.value()->instance(1).node, 3U);
  EXPECT_EQ(scene.value()->meshCount(), 1U) << "instances share their mesh";
  EXPECT_EQ(scene.value()->triangleCount(), 2U);
}

TEST(GltfNodes, ComposesTranslationRotationScaleFromParentToChild) {
  GltfFile file = fileWithTriangle();
  file.node(R"({"children":[1],"translation":[10,20,30],
               "rotation":[0,0,0.70710678118654752,0.70710678118654752],"scale":[2,3,4]})");
  file.nodeWith(0, R"(,"translation":[1,0,0])");
  const auto scene = load(file.glb());
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  // A quarter turn about z takes x to y; scale comes before it.
  const Rows expected = {0, -3, 0, 10, 2, 0, 0, 22, 0, 0, 4, 30};
  for (std::size_t i = 0; i < 12; ++i)
    EXPECT_NEAR(worldOf(scene.value(), 0)[i], expected[i], 1e-14);
}

TEST(GltfNodes, ReadsMatricesColumnByColumn) {
  GltfFile file = fileWithTriangle();
  file.nodeWith(0, R"(,"matrix":[1,2,3,0, 4,5,6,0, 7,8,9,0, 10,11,12,1])");
  const auto scene = load(file.glb());
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  EXPECT_EQ(worldOf(scene.value(), 0), (Rows{1, 4, 7, 10, 2, 5, 8, 11, 3, 6, 9, 12}));
}

TEST(GltfNodes, KeepsDoublePrecisionFarFromTheOrigin) {
  GltfFile file = fileWithTriangle();
  file.node(R"({"children":[1],"translation":[6378137.123456789,0,0]})");
  file.nodeWith(0, R"(,"translation":[-6378137,0,0])");
  const auto scene = load(file.glb());
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  EXPECT_NEAR(worldOf(scene.value(), 0)[3], 0.123456789, 1e-8);
}

TEST(GltfNodes, TakesNegativeAndZeroScales) {
  GltfFile file = fileWithTriangle();
  file.nodeWith(0, R"(,"scale":[-1,1,1])");
  file.nodeWith(0, R"(,"scale":[-1,-1,1])");
  file.nodeWith(0, R"(,"scale":[0,1,1])");
  const auto scene = load(file.glb());
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  EXPECT_EQ(worldOf(scene.value(), 0), (Rows{-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}));
  EXPECT_EQ(worldOf(scene.value(), 1), (Rows{-1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1, 0}));
  EXPECT_EQ(worldOf(scene.value(), 2), (Rows{0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}));
}

TEST(GltfNodes, WalksHierarchiesThatAreTenThousandDeep) {
  GltfFile file = fileWithTriangle();
  constexpr int kDepth = 10'000;
  std::string nodes;
  for (int i = 0; i < kDepth; ++i) {
    nodes += R"({"translation":[1,0,0],"children":[)" + std::to_string(i + 1) + "]},";
  }
  file.node(nodes + R"({"mesh":0})");
  const auto scene = load(file.glb());
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  ASSERT_EQ(scene.value()->objectCount(), 1U);
  EXPECT_EQ(scene.value()->instance(0).node, static_cast<std::uint32_t>(kDepth));
  EXPECT_EQ(worldOf(scene.value(), 0)[3], static_cast<double>(kDepth));
}

TEST(GltfNodes, ShowsTheChosenSceneElseTheFirstElseEverything) {
  const auto nodesOf = [](const std::string& scenes) {
    GltfFile file = fileWithTriangle();
    file.nodeWith(0);
    file.nodeWith(0);
    file.nodeWith(0);
    if (!scenes.empty()) file.top(scenes);
    const auto scene = load(file.glb());
    EXPECT_TRUE(scene.ok()) << scene.error().message;
    std::vector<std::uint32_t> nodes;
    for (ObjectId id = 0; id < scene.value()->objectCount(); ++id) {
      nodes.push_back(scene.value()->instance(id).node);
    }
    return nodes;
  };
  using Nodes = std::vector<std::uint32_t>;
  EXPECT_EQ(nodesOf(R"("scene":1,"scenes":[{"nodes":[0]},{"nodes":[2,1]}])"), (Nodes{1, 2}));
  EXPECT_EQ(nodesOf(R"("scenes":[{"nodes":[0]},{"nodes":[2,1]}])"), Nodes{0});
  EXPECT_EQ(nodesOf(""), (Nodes{0, 1, 2}));
}

TEST(GltfNodes, MakesOneObjectPerGpuInstance) {
  GltfFile file = fileWithTriangle();
  const int translation = file.positions({1, 0, 0, 2, 0, 0, 3, 0, 0});
  // Quaternions as normalized bytes: the identity, and half a turn about z.
  const std::vector<std::int8_t> turns = {0, 0, 0, 127, 0, 0, 127, 0, 0, 0, 0, 127};
  const int rotation = file.accessor(file.view(turns), 5120, 3, "VEC4", R"(,"normalized":true)");
  const int scale = file.positions({1, 1, 1, 2, 2, 2, -1, 1, 1});
  file.nodeWith(
      0, R"(,"translation":[100,0,0],"extensions":{"EXT_mesh_gpu_instancing":{"attributes":
      {"TRANSLATION":)" +
             std::to_string(translation) + R"(,"ROTATION":)" + std::to_string(rotation) +
             R"(,"SCALE":)" + std::to_string(scale) + R"(,"_ID":)" + std::to_string(translation) +
             "}}}");
  file.nodeWith(0);
  file.top(R"("extensionsRequired":["EXT_mesh_gpu_instancing"])");
  const auto scene = load(file.glb());
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  ASSERT_EQ(scene.value()->objectCount(), 4U);
  for (std::uint32_t i = 0; i < 3; ++i) {
    EXPECT_EQ(scene.value()->instance(i).node, 0U);
    EXPECT_EQ(scene.value()->instance(i).instance_number, i);
    EXPECT_EQ(worldOf(scene.value(), i)[3], 101.0 + i);
  }
  EXPECT_EQ(worldOf(scene.value(), 1)[0], -2.0);
  EXPECT_EQ(worldOf(scene.value(), 2)[0], -1.0);
  EXPECT_EQ(scene.value()->instance(3).node, 1U);
}

TEST(GltfNodes, KeepsWhatAViewerMayMoveOrSwitch) {
  GltfFile file = fileWithTriangle();
  file.nodeWith(0);                  // 0: at rest
  file.nodeWith(0, R"(,"skin":0)");  // 1
  file.nodeWith(0, R"(,"extensions":{"KHR_node_visibility":{"visible":false}})");
  file.node(R"({"children":[4]})");  // 3: animated
  file.nodeWith(0);
  file.nodeWith(0);  // 5: animated by a pointer
  file.top(R"("skins":[{"joints":[0]}],"animations":[{"channels":[
      {"sampler":0,"target":{"node":3,"path":"translation"}},
      {"sampler":0,"target":{"path":"pointer","extensions":
          {"KHR_animation_pointer":{"pointer":"/nodes/5/translation"}}}}]}])");
  const auto scene = load(file.glb());
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  ASSERT_EQ(scene.value()->objectCount(), 5U);
  EXPECT_FALSE(scene.value()->instance(0).always_kept);
  for (ObjectId id = 1; id < 5; ++id) EXPECT_TRUE(scene.value()->instance(id).always_kept) << id;
  EXPECT_EQ(scene.value()->meshCount(), 2U) << "one at rest, one without bounds";
}

TEST(GltfNodes, KeepsObjectsWhosePlaceOverflows) {
  GltfFile file = fileWithTriangle();
  file.node(R"({"children":[1],"scale":[1e300,1,1]})");
  file.nodeWith(0, R"(,"scale":[1e300,1,1])");
  const auto scene = load(file.glb());
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  EXPECT_TRUE(scene.value()->instance(0).always_kept);
}

TEST(GltfNodes, AcceptsUnicodeNamesAndNamesWithNul) {
  GltfFile file = fileWithTriangle();
  file.nodeWith(0, R"(,"name":"Стол 木 \u0000 \ud83d\ude00")");
  EXPECT_EQ(errorOf(file.glb()), "");
}

TEST(GltfNodes, LoadsEmptyScenes) {
  const auto scene = load(glbOf(R"({"asset":{"version":"2.0"}})", {}));
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  EXPECT_EQ(scene.value()->objectCount(), 0U);
}

TEST(GltfNodes, RefusesTreesThatAreNone) {
  const auto lineOf = [](std::initializer_list<std::string> nodes, const std::string& top = "") {
    GltfFile file;
    for (const std::string& node : nodes) file.node(node);
    if (!top.empty()) file.top(top);
    return errorOf(file.glb());
  };
  EXPECT_EQ(lineOf({R"({"children":[0]})"}), "t.glb: node 0: is its own ancestor");
  EXPECT_EQ(lineOf({"{}", R"({"children":[2]})", R"({"children":[1]})"}),
            "t.glb: node 1: is its own ancestor");
  EXPECT_EQ(lineOf({R"({"children":[2]})", R"({"children":[2]})", "{}"}),
            "t.glb: node 2: has two parents, nodes 0 and 1");
  EXPECT_EQ(lineOf({R"({"children":[1,1]})", "{}"}),
            "t.glb: node 1: has two parents, nodes 0 and 0");
  EXPECT_EQ(lineOf({R"({"children":[1]})", "{}"}, R"("scenes":[{"nodes":[0,1]}])"),
            "t.glb: node 1: is a root of the scene and a child of node 0");
  EXPECT_EQ(lineOf({"{}"}, R"("scenes":[{"nodes":[0,0]}])"),
            "t.glb: node 0: is listed twice as a root of the scene");
}

TEST(GltfNodes, NamesTheNodeWithABrokenTransform) {
  const auto lineOf = [](const std::string& node) {
    GltfFile file;
    file.node(node);
    return errorOf(file.glb());
  };
  EXPECT_EQ(lineOf(R"({"matrix":[1,2,3]})"), "t.glb: node 0: matrix has 3 numbers instead of 16");
  EXPECT_EQ(lineOf(R"({"matrix":[1,0,0,0, 0,1,0,0, 0,0,1,0.5, 0,0,0,1]})"),
            "t.glb: node 0: the last row of matrix is not 0 0 0 1");
  EXPECT_EQ(lineOf(R"({"translation":[1,2]})"),
            "t.glb: node 0: translation has 2 numbers instead of 3");
  EXPECT_EQ(lineOf(R"({"rotation":[0,0,0,null]})"),
            "t.glb: node 0: rotation is not an array of numbers");
  EXPECT_EQ(lineOf(R"({"scale":"big"})"), "t.glb: node 0: scale is not an array");
}

TEST(GltfNodes, HoldsInstancesToTheLimits) {
  GltfFile file = fileWithTriangle();
  const int many = file.accessor(-1, 5126, 1'000'000'000, "VEC3");
  file.nodeWith(0, R"(,"extensions":{"EXT_mesh_gpu_instancing":{"attributes":{"TRANSLATION":)" +
                       std::to_string(many) + "}}}");
  EXPECT_EQ(errorOf(file.glb()), "t.glb: node 0: more than 16000000 objects");
  LoadOptions generous;
  generous.limits.max_objects = 4'000'000'000;
  EXPECT_EQ(errorOf(file.glb(), generous),
            "t.glb: accessor 1: 1000000000 elements without a bufferView > limit of 1048576");
}

TEST(GltfNodes, RefusesInstanceAttributesThatDoNotFitTogether) {
  GltfFile file = fileWithTriangle();
  const int two = file.positions({0, 0, 0, 1, 1, 1});
  const int three = file.positions({0, 0, 0, 1, 1, 1, 2, 2, 2});
  file.nodeWith(0, R"(,"extensions":{"EXT_mesh_gpu_instancing":{"attributes":{"SCALE":)" +
                       std::to_string(two) + R"(,"TRANSLATION":)" + std::to_string(three) + "}}}");
  EXPECT_EQ(errorOf(file.glb()), "t.glb: node 0: instance attributes of 2 and 3 elements");
}

}  // namespace
}  // namespace culld::test
