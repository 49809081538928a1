// What broken files get: one line with file, place and what is wrong. Never a crash, never a guess.
#include <gtest/gtest.h>

#include <string>

#include "tests/unit/scene/gltf_file.h"

namespace culld::test {
namespace {

/// A square with indices that are fine; tests break one thing.
GltfFile goodFile() {
  GltfFile file;
  file.mesh(file.positions(kSquare), file.indices({0, 1, 2, 0, 2, 3}));
  file.nodeWith(0);
  return file;
}

std::string lineOfJson(const std::string& members) {
  return errorOf(glbOf(R"({"asset":{"version":"2.0"},)" + members + "}", {}));
}

/// The line for a triangle whose position accessor is written by the test.
std::string lineOfPositions(const std::string& accessor, const std::string& view_more = "") {
  GltfFile file;
  file.view(kTriangle, view_more);
  file.mesh(0);
  file.nodeWith(0);
  file.top(R"("accessors":[)" + accessor + "]");
  return errorOf(file.glb());
}

TEST(GltfErrors, NamesTheBadIndexAndTheNumberOfVertices) {
  GltfFile file;
  std::vector<float> xyz;
  for (int i = 0; i < 88; ++i) xyz.insert(xyz.end(), {static_cast<float>(i), 0, 0});
  const int positions = file.positions(xyz);
  for (int i = 0; i < 3; ++i) file.mesh(positions);
  file.nodeWith(file.mesh(positions, file.indices({0, 1, 91})));
  const auto scene = loadGltfBytes(file.glb(), "city.glb");
  ASSERT_FALSE(scene.ok());
  EXPECT_EQ(scene.error().message, "city.glb: mesh 3: index 91 >= 88 vertices");
  EXPECT_EQ(scene.error().code, ErrorCode::kInvalidInput);
}

TEST(GltfErrors, NamesThePrimitiveWhereAMeshHasSeveral) {
  GltfFile file;
  const int positions = file.positions(kTriangle);
  const int bad = file.indices({0, 1, 7});
  file.nodeWith(file.meshOf({GltfFile::primitive(positions), GltfFile::primitive(positions, bad)}));
  EXPECT_EQ(errorOf(file.glb()), "t.glb: mesh 0 primitive 1: index 7 >= 3 vertices");
}

TEST(GltfErrors, EveryTruncationIsRefused) {
  const Bytes whole = goodFile().glb();
  ASSERT_EQ(errorOf(whole), "");
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const Bytes cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
    const std::string line = errorOf(cut);
    EXPECT_NE(line, "") << size;
    EXPECT_EQ(line.find('\n'), std::string::npos) << size;
  }
  const Bytes cut(whole.begin(), whole.end() - 4);
  EXPECT_EQ(errorOf(cut), "t.glb: header: " + std::to_string(whole.size()) +
                              " bytes announced, the file has " + std::to_string(cut.size()));
}

TEST(GltfErrors, EveryFlippedByteLoadsOrIsRefusedWithOneLine) {
  const Bytes whole = goodFile().glb();
  for (std::size_t i = 0; i < whole.size(); ++i) {
    for (const int flip : {0x01, 0x80, 0xFF}) {
      Bytes changed = whole;
      changed[i] ^= static_cast<std::byte>(flip);
      const std::string line = errorOf(changed);
      EXPECT_EQ(line.find('\n'), std::string::npos);
      EXPECT_TRUE(line.empty() || line.starts_with("t.glb: ")) << line;
    }
  }
}

TEST(GltfErrors, RefusesBrokenContainers) {
  EXPECT_EQ(errorOf({}), "t.glb: file: is empty");
  EXPECT_EQ(errorOf(bytesOf("PNG ")), "t.glb: file: is neither GLB nor a JSON object");
  EXPECT_EQ(errorOf(bytesOf("[1]")), "t.glb: file: is neither GLB nor a JSON object");
  EXPECT_EQ(errorOf(bytesOf("glTF\1\0\0\0")), "t.glb: header: the file ends within it");
  Bytes version = goodFile().glb();
  version[4] = std::byte{1};
  EXPECT_EQ(errorOf(version), "t.glb: header: GLB version 1 instead of 2");
  Bytes chunk = goodFile().glb();
  chunk[16] = std::byte{'B'};
  EXPECT_EQ(errorOf(chunk), "t.glb: chunk at byte 12: the first chunk is not JSON");
}

TEST(GltfErrors, IgnoresUnknownChunksAndWhatFollowsTheAnnouncedEnd) {
  Bytes file = goodFile().glb();
  append(file, std::uint64_t{0xABCDEF});
  EXPECT_EQ(errorOf(file), "");
  file.resize(file.size() - 8);
  append(file, std::uint32_t{4});
  append(file, std::uint32_t{0x58585858});
  append(file, std::uint32_t{7});
  file[8] = static_cast<std::byte>(file.size() & 0xFF);
  file[9] = static_cast<std::byte>(file.size() >> 8);
  EXPECT_EQ(errorOf(file), "");
}

TEST(GltfErrors, RefusesJsonThatIsNestedTooDeep) {
  std::string deep = R"({"asset":{"version":"2.0"},"extras":)";
  deep += std::string(300'000, '[') + std::string(300'000, ']') + "}";
  EXPECT_EQ(errorOf(glbOf(deep, {})), "t.glb: JSON: nested deeper than 256");
  EXPECT_EQ(lineOfJson(R"("extras":"[[[[[[")"), "") << "brackets in strings do not nest";
}

TEST(GltfErrors, JsonDoesNotEndAtAZeroByte) {
  const std::string json = R"({"asset":{"version":"2.0"}})";
  const std::string zero(1, '\0');
  EXPECT_EQ(errorOf(glbOf(json + zero + "[[[", {})), "t.glb: JSON: a zero byte at byte 27");
  EXPECT_EQ(errorOf(glbOf(json + zero, {})), errorOf(glbOf(json, {})))
      << "padding of old exporters";
}

TEST(GltfErrors, RefusesOtherVersions) {
  EXPECT_EQ(errorOf(bytesOf("{}")), "t.glb: asset: is missing");
  EXPECT_EQ(errorOf(bytesOf(R"({"asset":{}})")), "t.glb: asset: version is missing");
  EXPECT_EQ(errorOf(bytesOf(R"({"asset":{"version":"1.0"}})")), "t.glb: asset: version is not 2.x");
  EXPECT_EQ(errorOf(bytesOf(R"({"asset":{"version":"2.1","minVersion":"2.1"}})")),
            "t.glb: asset: minVersion is not 2.0");
}

TEST(GltfErrors, NamesARequiredExtensionThatIsNotSupported) {
  const auto scene = load(glbOf(
      R"({"asset":{"version":"2.0"},"extensionsRequired":["KHR_texture_basisu","EXT_shape"]})",
      {}));
  ASSERT_FALSE(scene.ok());
  EXPECT_EQ(scene.error().message, "t.glb: extensionsRequired: EXT_shape is not supported");
  EXPECT_EQ(scene.error().code, ErrorCode::kUnsupported);
  EXPECT_EQ(lineOfJson(R"("extensionsRequired":["KHR_materials_unlit","KHR_lights_punctual"])"),
            "");
}

TEST(GltfErrors, NamesIndicesThatPointNowhere) {
  EXPECT_EQ(lineOfJson(R"("nodes":[{"mesh":4294967296}])"),
            "t.glb: node 0: mesh 4294967296 >= 0 meshes");
  EXPECT_EQ(lineOfJson(R"("nodes":[{"children":[-1]}])"),
            "t.glb: node 0: child is not a whole number from 0");
  EXPECT_EQ(lineOfJson(R"("scene":3,"scenes":[{}])"), "t.glb: default scene: scene 3 >= 1 scenes");
  EXPECT_EQ(lineOfJson(R"("scenes":[{"nodes":[2]}])"), "t.glb: scene 0: node 2 >= 0 nodes");
  EXPECT_EQ(lineOfJson(R"("bufferViews":[{"buffer":0,"byteLength":1}])"),
            "t.glb: bufferView 0: buffer 0 >= 0 buffers");
  EXPECT_EQ(lineOfJson(R"("meshes":[{"primitives":[{"attributes":{"POSITION":5}}]}])"),
            "t.glb: mesh 0 primitive 0: POSITION 5 >= 0 accessors");
}

TEST(GltfErrors, AWholeNumberMayBeWrittenAsAFraction) {
  GltfFile file;
  file.mesh(file.positions(kTriangle));
  file.node(R"({"mesh":0.0})");
  const auto scene = load(file.glb());
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  EXPECT_EQ(scene.value()->objectCount(), 1U);
  EXPECT_EQ(lineOfJson(R"("nodes":[{"mesh":0.5}])"),
            "t.glb: node 0: mesh is not a whole number from 0");
}

TEST(GltfErrors, RefusesAccessorsBeyondTheirBytes) {
  EXPECT_EQ(lineOfPositions(R"({"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"})"),
            "t.glb: accessor 0: 4 elements of 12 bytes from byte 0 do not fit into 36 bytes");
  EXPECT_EQ(
      lineOfPositions(
          R"({"bufferView":0,"componentType":5126,"count":2305843009213693952,"type":"VEC3"})"),
      "t.glb: accessor 0: 2305843009213693952 elements of 12 bytes from byte 0 do not fit into "
      "36 bytes");
  EXPECT_EQ(
      lineOfPositions(R"({"bufferView":0,"componentType":5126,"count":1,"type":"VEC3",
                                "byteOffset":18446744073709551615})"),
      "t.glb: accessor 0: 1 elements of 12 bytes from byte 18446744073709551615 do not fit into "
      "36 bytes");
  EXPECT_EQ(lineOfPositions(R"({"bufferView":0,"componentType":5126,"count":2,"type":"VEC3"})",
                            R"(,"byteStride":8)"),
            "t.glb: accessor 0: byteStride 8 < 12 bytes of an element");
  EXPECT_EQ(lineOfPositions(R"({"componentType":5126,"count":1000000000,"type":"VEC3"})"),
            "t.glb: accessor 0: 1000000000 elements without a bufferView > limit of 1048576");
  EXPECT_EQ(lineOfPositions(R"({"bufferView":0,"componentType":5126,"count":0,"type":"VEC3"})"),
            "t.glb: accessor 0: count is 0");
}

TEST(GltfErrors, RefusesAccessorsThatHoldSomethingElse) {
  EXPECT_EQ(lineOfPositions(R"({"bufferView":0,"componentType":5126,"count":3,"type":"VEC2"})"),
            "t.glb: mesh 0: accessor 0 holds no positions");
  EXPECT_EQ(lineOfPositions(R"({"bufferView":0,"componentType":5130,"count":1,"type":"VEC3"})"),
            "t.glb: accessor 0: unknown componentType 5130");
  EXPECT_EQ(lineOfPositions(R"({"bufferView":0,"componentType":5126,"count":1,"type":"VEC5"})"),
            "t.glb: accessor 0: unknown type");
  GltfFile file;
  const int positions = file.positions(kTriangle);
  file.nodeWith(file.mesh(positions, file.accessor(file.view(kTriangle), 5126, 3, "SCALAR")));
  EXPECT_EQ(errorOf(file.glb()), "t.glb: mesh 0: accessor 1 holds no indices");
}

TEST(GltfErrors, RefusesSparseIndicesThatPointNowhereOrGoBack) {
  const auto lineOf = [](const std::vector<std::uint8_t>& targets) {
    GltfFile file;
    const std::string count = std::to_string(targets.size());
    const int indices = file.view(targets);
    const int values = file.view(kTriangle);
    file.mesh(file.accessor(-1, 5126, 3, "VEC3",
                            R"(,"sparse":{"count":)" + count +
                                R"(,"indices":{"componentType":5121,"bufferView":)" +
                                std::to_string(indices) + R"(},"values":{"bufferView":)" +
                                std::to_string(values) + "}}"));
    file.nodeWith(0);
    return errorOf(file.glb());
  };
  EXPECT_EQ(lineOf({0, 2}), "");
  EXPECT_EQ(lineOf({0, 3}), "t.glb: accessor 0: sparse index 3 >= 3 elements");
  EXPECT_EQ(lineOf({2, 1}), "t.glb: accessor 0: sparse indices do not increase");
  EXPECT_EQ(lineOf({0, 1, 2, 2}), "t.glb: accessor 0: 4 sparse elements > 3");
}

TEST(GltfErrors, RefusesViewsBeyondTheirBuffer) {
  GltfFile file;
  file.view(kTriangle);
  file.viewOf(30, 7);
  EXPECT_EQ(errorOf(file.glb()), "t.glb: bufferView 1: bytes 30 + 7 > 36 of buffer 0");
  GltfFile wraps;
  wraps.view(kTriangle);
  wraps.viewOf(0xFFFFFFFFFFFFFFF0U, 64);
  EXPECT_EQ(errorOf(wraps.glb()),
            "t.glb: bufferView 1: bytes 18446744073709551600 + 64 > 36 of buffer 0");
}

TEST(GltfErrors, RefusesABufferLargerThanTheBinaryChunk) {
  GltfFile file;
  file.view(kTriangle);
  file.buffers(R"({"byteLength":4398046511104})");
  EXPECT_EQ(errorOf(file.glb()),
            "t.glb: buffer 0: 4398046511104 bytes announced, the BIN chunk has 36");
}

TEST(GltfErrors, HoldsVerticesAndMemoryToTheLimits) {
  GltfFile file = goodFile();
  LoadOptions options;
  options.limits.max_vertices = 3;
  const auto vertices = load(file.glb(), options);
  ASSERT_FALSE(vertices.ok());
  EXPECT_EQ(vertices.error().message, "t.glb: scene: more than 3 vertices");
  EXPECT_EQ(vertices.error().code, ErrorCode::kLimit);
  options = {};
  options.limits.max_decoded_bytes = 1000;
  EXPECT_EQ(errorOf(file.glb(), options), "t.glb: scene: more than 1000 decoded bytes");
  options = {};
  options.limits.max_file_bytes = 100;
  EXPECT_EQ(errorOf(file.glb(), options),
            "t.glb: file: " + std::to_string(file.glb().size()) + " bytes > limit of 100");
}

TEST(GltfErrors, ManyPrimitivesOnOneAccessorDoNotMultiplyIt) {
  GltfFile file;
  std::vector<float> xyz(30'000);
  const int positions = file.positions(xyz);
  const int indices = file.indices({0, 1, 2});
  const std::string one = GltfFile::primitive(positions, indices);
  std::string primitives = one;
  for (int i = 0; i < 10'000; ++i) primitives.append(",").append(one);
  file.meshOf({primitives});
  file.nodeWith(0);
  LoadOptions options;
  options.limits.max_vertices = 40'000;
  EXPECT_EQ(errorOf(file.glb(), options), "");
}

TEST(GltfErrors, KeepsControlCharactersOfNamesOutOfTheLine) {
  const auto scene = loadGltfBytes({}, "a\nb\x1b[31m.glb");
  ASSERT_FALSE(scene.ok());
  EXPECT_EQ(scene.error().message, "a?b?[31m.glb: file: is empty");
}

}  // namespace
}  // namespace culld::test
