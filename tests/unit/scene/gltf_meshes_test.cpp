// Primitives: how they are stored, drawn and what their materials mean.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <limits>
#include <string>

#include "tests/unit/scene/gltf_file.h"

namespace culld::test {
namespace {

using Corner = std::array<float, 3>;
using Triangle = std::array<Corner, 3>;

/// The triangles of a mesh as coordinates, each from its smallest corner on, winding kept, sorted.
std::vector<Triangle> trianglesOf(const Mesh& mesh) {
  std::vector<Triangle> all;
  for (const auto& t : mesh.triangles) {
    Triangle corners;
    for (std::size_t i = 0; i < 3; ++i) {
      const glm::vec3 p = mesh.positions[t[i]];
      corners[i] = {p.x, p.y, p.z};
    }
    std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
    all.push_back(corners);
  }
  std::sort(all.begin(), all.end());
  return all;
}

/// Loads a file with a node on mesh 0, and gives that mesh.
Mesh loadMesh(GltfFile& file) {
  file.nodeWith(0);
  const auto scene = load(file.glb());
  EXPECT_TRUE(scene.ok()) << scene.error().message;
  return scene.ok() ? scene.value()->mesh(0) : Mesh();
}

std::vector<Triangle> squareOfTwo() {
  return {{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}}}, {{{0, 0, 0}, {1, 1, 0}, {0, 1, 0}}}};
}

std::vector<Triangle> sorted(std::vector<Triangle> triangles) {
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

TEST(GltfMeshes, ReadsAllTypesOfIndices) {
  const auto read = [](auto example, int component) {
    using Index = decltype(example);
    GltfFile file;
    const int positions = file.positions(kSquare);
    const int view = file.view(std::vector<Index>{0, 1, 2, 0, 2, 3});
    file.mesh(positions, file.accessor(view, component, 6, "SCALAR"));
    return trianglesOf(loadMesh(file));
  };
  EXPECT_EQ(read(std::uint8_t{}, 5121), sorted(squareOfTwo()));
  EXPECT_EQ(read(std::uint16_t{}, 5123), sorted(squareOfTwo()));
  EXPECT_EQ(read(std::uint32_t{}, 5125), sorted(squareOfTwo()));
}

TEST(GltfMeshes, DrawsVerticesInOrderWithoutIndices) {
  GltfFile file;
  file.mesh(file.positions({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 0, 0, 1, 1, 0, 0, 1, 0}));
  EXPECT_EQ(trianglesOf(loadMesh(file)), sorted(squareOfTwo()));
}

TEST(GltfMeshes, AlternatesTheWindingOfStripsAndDropsTheirStitches) {
  GltfFile file;
  // 0 1 3 2: the square; then stitches to the same square one further up.
  const int positions = file.positions({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0,  //
                                        0, 0, 5, 1, 0, 5, 1, 1, 5, 0, 1, 5});
  file.mesh(positions, file.indices({0, 1, 3, 2, 2, 4, 4, 5, 7, 6}), R"(,"mode":5)");
  const Mesh mesh = loadMesh(file);
  EXPECT_EQ(mesh.triangles.size(), 4U);
  EXPECT_EQ(mesh.dropped_triangles, 0U);
  for (const auto& t : mesh.triangles) {
    const glm::vec3 a = mesh.positions[t[1]] - mesh.positions[t[0]];
    const glm::vec3 b = mesh.positions[t[2]] - mesh.positions[t[0]];
    EXPECT_GT(a.x * b.y - a.y * b.x, 0.0F) << "every triangle faces +z";
  }
}

TEST(GltfMeshes, FansAroundTheFirstVertex) {
  GltfFile file;
  file.mesh(file.positions(kSquare), -1, R"(,"mode":6)");
  EXPECT_EQ(trianglesOf(loadMesh(file)), sorted(squareOfTwo()));
}

TEST(GltfMeshes, CountsPointsAndLinesForBoundsOnly) {
  const auto read = [](int mode) {
    GltfFile file;
    file.mesh(file.positions({0, 0, 0, 1, 0, 0, 1, 2, 3}), -1,
              R"(,"mode":)" + std::to_string(mode));
    return loadMesh(file);
  };
  const std::uint32_t counts[] = {3, 1, 3, 2};  // points, lines, loop, strip
  for (int mode = 0; mode < 4; ++mode) {
    const Mesh mesh = read(mode);
    EXPECT_EQ(mesh.points_and_lines, counts[mode]) << mode;
    EXPECT_TRUE(mesh.triangles.empty());
    EXPECT_EQ(mesh.bounds.max, glm::dvec3(1, 2, 3));
    EXPECT_FALSE(mesh.unbounded);
  }
}

TEST(GltfMeshes, ReadsInterleavedVertices) {
  GltfFile file;
  struct Vertex {
    float x, y, z;
    float u, v;
  };
  const std::vector<Vertex> vertices = {{0, 0, 0, 9, 9}, {1, 0, 0, 9, 9}, {0, 1, 0, 9, 9}};
  const int view = file.view(vertices, R"(,"byteStride":20)");
  file.mesh(file.accessor(view, 5126, 3, "VEC3"));
  const Mesh mesh = loadMesh(file);
  EXPECT_EQ(mesh.bounds.max, glm::dvec3(1, 1, 0));
  EXPECT_EQ(mesh.triangles.size(), 1U);
}

TEST(GltfMeshes, AppliesSparseValuesOverDataAndOverZeros) {
  GltfFile file;
  const int base = file.view(kTriangle);
  const int indices = file.view(std::vector<std::uint8_t>{1, 2});
  const int values = file.view(std::vector<float>{4, 0, 0, 0, 5, 0});
  const std::string sparse =
      R"(,"sparse":{"count":2,"indices":{"componentType":5121,"bufferView":)" +
      std::to_string(indices) + R"(},"values":{"bufferView":)" + std::to_string(values) + "}}";
  const int over_data = file.accessor(base, 5126, 3, "VEC3", sparse);
  const int over_zeros = file.accessor(-1, 5126, 3, "VEC3", sparse);
  file.meshOf({GltfFile::primitive(over_data), GltfFile::primitive(over_zeros)});
  const Mesh mesh = loadMesh(file);
  EXPECT_EQ(mesh.bounds.max, glm::dvec3(4, 5, 0));
  EXPECT_EQ(mesh.triangles.size(), 2U);
}

TEST(GltfMeshes, ReadsQuantizedPositions) {
  const auto boundsOf = [](auto example, int component, bool normalized) {
    using Number = decltype(example);
    GltfFile file;
    constexpr Number kMost = std::numeric_limits<Number>::max();
    const std::vector<Number> xyz = {0, 0, 0, 0, kMost, 0, 0, 0, 0, kMost, 0, 0};
    const int view = file.view(xyz, R"(,"byteStride":)" + std::to_string(4 * sizeof(Number)));
    file.mesh(file.accessor(view, component, 3, "VEC3", normalized ? R"(,"normalized":true)" : ""));
    file.top(R"("extensionsRequired":["KHR_mesh_quantization"])");
    return loadMesh(file).bounds.max;
  };
  EXPECT_EQ(boundsOf(std::int8_t{}, 5120, false), glm::dvec3(127, 127, 0));
  EXPECT_EQ(boundsOf(std::uint8_t{}, 5121, false), glm::dvec3(255, 255, 0));
  EXPECT_EQ(boundsOf(std::int16_t{}, 5122, false), glm::dvec3(32767, 32767, 0));
  EXPECT_EQ(boundsOf(std::uint16_t{}, 5123, false), glm::dvec3(65535, 65535, 0));
  EXPECT_EQ(boundsOf(std::int8_t{}, 5120, true), glm::dvec3(1, 1, 0));
  EXPECT_EQ(boundsOf(std::uint8_t{}, 5121, true), glm::dvec3(1, 1, 0));
  EXPECT_EQ(boundsOf(std::int16_t{}, 5122, true), glm::dvec3(1, 1, 0));
  EXPECT_EQ(boundsOf(std::uint16_t{}, 5123, true), glm::dvec3(1, 1, 0));
}

TEST(GltfMeshes, NeverTrustsMinAndMax) {
  GltfFile file;
  file.mesh(file.accessor(file.view(kTriangle), 5126, 3, "VEC3",
                          R"(,"min":[0.4,0.4,0],"max":[0.5,0.5,0])"));
  EXPECT_EQ(loadMesh(file).bounds.max, glm::dvec3(1, 1, 0));
}

TEST(GltfMeshes, CopiesOnlyTheVerticesThatAPrimitiveDraws) {
  GltfFile file;
  std::vector<float> shared = kTriangle;
  for (int i = 0; i < 1000; ++i) shared.insert(shared.end(), {1000, 1000, 1000});
  file.mesh(file.positions(shared), file.indices({0, 1, 2}));
  const Mesh mesh = loadMesh(file);
  EXPECT_EQ(mesh.positions.size(), 3U);
  EXPECT_EQ(mesh.bounds.max, glm::dvec3(1, 1, 0));
}

TEST(GltfMeshes, OnlyOpaqueMaterialsBlock) {
  const auto surfaceOf = [](const std::string& material) {
    GltfFile file;
    file.material(material);
    file.mesh(file.positions(kTriangle), -1, R"(,"material":0)");
    const Mesh mesh = loadMesh(file);
    EXPECT_EQ(mesh.surfaces.size(), 1U);
    return mesh.surfaces.empty() ? Surface() : mesh.surfaces[0];
  };
  EXPECT_TRUE(surfaceOf("{}").blocks);
  EXPECT_TRUE(surfaceOf(R"({"alphaMode":"OPAQUE"})").blocks);
  EXPECT_FALSE(surfaceOf(R"({"alphaMode":"MASK"})").blocks);
  EXPECT_FALSE(surfaceOf(R"({"alphaMode":"BLEND"})").blocks);
  EXPECT_FALSE(surfaceOf(R"({"extensions":{"KHR_materials_transmission":{}}})").blocks);
  EXPECT_FALSE(surfaceOf("{}").double_sided);
  EXPECT_TRUE(surfaceOf(R"({"doubleSided":true})").double_sided);
}

TEST(GltfMeshes, ASurfaceBlocksOnlyIfAllItsVariantsDo) {
  GltfFile file;
  file.material("{}");
  file.material(R"({"alphaMode":"BLEND"})");
  file.mesh(file.positions(kTriangle), -1,
            R"(,"material":0,"extensions":{"KHR_materials_variants":{"mappings":[
                {"material":1,"variants":[0]}]}})");
  const Mesh mesh = loadMesh(file);
  ASSERT_EQ(mesh.surfaces.size(), 1U);
  EXPECT_FALSE(mesh.surfaces[0].blocks);
  EXPECT_TRUE(mesh.surfaces[0].double_sided);
}

TEST(GltfMeshes, MorphTargetsTakeAwayTheBounds) {
  GltfFile file;
  const int positions = file.positions(kTriangle);
  file.mesh(positions, -1, R"(,"targets":[{"POSITION":)" + std::to_string(positions) + "}]");
  EXPECT_TRUE(loadMesh(file).unbounded);
}

TEST(GltfMeshes, NonFiniteVerticesAreWarnedAboutAndKeepTheObject) {
  for (const float bad :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    for (const char* mode : {"", R"(,"mode":0)"}) {
      GltfFile file;
      file.mesh(file.positions({0, 0, 0, 1, 0, 0, 0, bad, 0}), -1, mode);
      file.nodeWith(0);
      const auto scene = load(file.glb());
      ASSERT_TRUE(scene.ok()) << scene.error().message;
      EXPECT_TRUE(scene.value()->instance(0).always_kept);
      ASSERT_EQ(scene.value()->warnings().size(), 1U);
      EXPECT_EQ(scene.value()->warnings()[0],
                "mesh 0: 1 non-finite vertices; its objects are always kept");
    }
  }
}

TEST(GltfMeshes, AnObjectWithoutPositionsHasNothingToDraw) {
  GltfFile file;
  file.meshOf({R"({"attributes":{}})"});
  file.nodeWith(0);
  const auto scene = load(file.glb());
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  EXPECT_EQ(scene.value()->objectCount(), 1U);
  EXPECT_TRUE(scene.value()->mesh(0).triangles.empty());
}

TEST(GltfMeshes, LoadsTheSameSceneOnAnyNumberOfThreads) {
  GltfFile file;
  const int positions = file.positions(kSquare);
  for (int m = 0; m < 50; ++m) {
    file.mesh(positions, file.indices({0, 1, 2}));
    file.nodeWith(m, R"(,"translation":[)" + std::to_string(m) + ",0,0]");
  }
  LoadOptions one;
  one.threads = 1;
  LoadOptions many;
  many.threads = 8;
  std::size_t steps = 0;
  many.progress = [&](std::size_t done, std::size_t total) {
    EXPECT_EQ(done, ++steps);
    EXPECT_EQ(total, 52U);
  };
  const auto a = load(file.glb(), one);
  const auto b = load(file.glb(), many);
  ASSERT_TRUE(a.ok() && b.ok());
  EXPECT_EQ(a.value()->contentHash(), b.value()->contentHash());
  EXPECT_EQ(steps, 52U);
}

}  // namespace
}  // namespace culld::test
