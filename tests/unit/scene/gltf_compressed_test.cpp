// Draco and meshopt: streams made by their own encoders, then broken.
#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#include <gtest/gtest.h>
#include <meshoptimizer.h>

#include <array>
#include <memory>
#include <string>

#include "tests/unit/scene/gltf_file.h"

namespace culld::test {
namespace {

using Stream = std::vector<std::uint8_t>;

/// A grid of n x n quads over [0, n] x [0, n].
std::vector<std::array<float, 9>> gridTriangles(int n) {
  std::vector<std::array<float, 9>> all;
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      const auto x = static_cast<float>(i);
      const auto y = static_cast<float>(j);
      all.push_back({x, y, 0, x + 1, y, 0, x + 1, y + 1, 0});
      all.push_back({x, y, 0, x + 1, y + 1, 0, x, y + 1, 0});
    }
  }
  return all;
}

Stream dracoOf(const std::vector<std::array<float, 9>>& triangles, int method) {
  draco::TriangleSoupMeshBuilder builder;
  builder.Start(static_cast<int>(triangles.size()));
  const int position =
      builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    const float* xyz = triangles[t].data();
    builder.SetAttributeValuesForFace(position, draco::FaceIndex(t), xyz, xyz + 3, xyz + 6);
  }
  const std::unique_ptr<draco::Mesh> mesh = builder.Finalize();
  draco::Encoder encoder;
  encoder.SetEncodingMethod(method);
  encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, 14);
  draco::EncoderBuffer out;
  EXPECT_TRUE(encoder.EncodeMeshToBuffer(*mesh, &out).ok());
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(out.data());
  return {bytes, bytes + out.size()};
}

/// As the extension has it: accessors without a buffer view, the stream in a view of its own.
GltfFile dracoFile(const Stream& stream, std::size_t triangles) {
  GltfFile file;
  const int view = file.view(stream);
  const int positions = file.accessor(-1, 5126, 3 * triangles, "VEC3");
  const int indices = file.accessor(-1, 5125, 3 * triangles, "SCALAR");
  file.mesh(positions, indices,
            R"(,"extensions":{"KHR_draco_mesh_compression":{"bufferView":)" + std::to_string(view) +
                R"(,"attributes":{"POSITION":0}}})");
  file.nodeWith(0);
  file.top(R"("extensionsRequired":["KHR_draco_mesh_compression"])");
  return file;
}

TEST(GltfDraco, DecodesBothMethods) {
  const auto grid = gridTriangles(8);
  for (const int method : {draco::MESH_SEQUENTIAL_ENCODING, draco::MESH_EDGEBREAKER_ENCODING}) {
    const auto scene = load(dracoFile(dracoOf(grid, method), grid.size()).glb());
    ASSERT_TRUE(scene.ok()) << scene.error().message;
    const Mesh& mesh = scene.value()->mesh(0);
    EXPECT_EQ(mesh.triangles.size(), grid.size());
    EXPECT_EQ(mesh.positions.size(), 81U);
    EXPECT_NEAR(mesh.bounds.max.x, 8.0, 1e-3);
    EXPECT_NEAR(mesh.bounds.min.x, 0.0, 1e-3);
  }
}

TEST(GltfDraco, RefusesBrokenStreams) {
  const auto grid = gridTriangles(2);
  const Stream good = dracoOf(grid, draco::MESH_EDGEBREAKER_ENCODING);
  EXPECT_EQ(errorOf(dracoFile(Stream(64, 7), grid.size()).glb()),
            "t.glb: mesh 0: not a Draco stream");
  Stream version = good;
  version[6] = 1;
  EXPECT_EQ(errorOf(dracoFile(version, grid.size()).glb()),
            "t.glb: mesh 0: Draco bitstream 2.1 instead of 2.2");
  const Stream cut(good.begin(), good.begin() + 20);
  EXPECT_EQ(errorOf(dracoFile(cut, grid.size()).glb()),
            "t.glb: mesh 0: the Draco stream is broken");
}

TEST(GltfDraco, RefusesAHeaderThatAnnouncesFarTooMuch) {
  Stream bomb = {'D', 'R', 'A', 'C', 'O', 2, 2, 1, 0, 0, 0};
  for (int i = 0; i < 2; ++i) bomb.insert(bomb.end(), {0xFF, 0xFF, 0xFF, 0xFF, 0x0F});
  EXPECT_EQ(
      errorOf(dracoFile(bomb, 1).glb()),
      "t.glb: mesh 0: Draco header announces 4294967295 triangles and 4294967295 vertices in 21 "
      "bytes");
}

TEST(GltfDraco, SurvivesEveryFlippedByte) {
  const auto grid = gridTriangles(3);
  for (const int method : {draco::MESH_SEQUENTIAL_ENCODING, draco::MESH_EDGEBREAKER_ENCODING}) {
    const Stream good = dracoOf(grid, method);
    for (std::size_t i = 0; i < good.size(); ++i) {
      for (const int flip : {1, 0x80, 0xFF}) {
        Stream changed = good;
        changed[i] = static_cast<std::uint8_t>(changed[i] ^ flip);
        const std::string line = errorOf(dracoFile(changed, grid.size()).glb());
        EXPECT_TRUE(line.empty() || line.starts_with("t.glb: ")) << line;
      }
    }
  }
}

struct Packed {
  Stream stream;
  std::size_t count = 0;
  std::size_t stride = 0;
  std::string mode = "ATTRIBUTES";
  std::string filter = "NONE";
};

template <typename T>
Packed packVertices(const std::vector<T>& data, std::size_t stride) {
  Packed packed;
  packed.stride = stride;
  packed.count = data.size() * sizeof(T) / stride;
  packed.stream.resize(meshopt_encodeVertexBufferBound(packed.count, stride));
  packed.stream.resize(meshopt_encodeVertexBuffer(packed.stream.data(), packed.stream.size(),
                                                  data.data(), packed.count, stride));
  return packed;
}

Packed packTriangles(const std::vector<unsigned>& indices) {
  Packed packed;
  packed.mode = "TRIANGLES";
  packed.stride = 4;
  packed.count = indices.size();
  packed.stream.resize(meshopt_encodeIndexBufferBound(indices.size(), 100));
  packed.stream.resize(meshopt_encodeIndexBuffer(packed.stream.data(), packed.stream.size(),
                                                 indices.data(), indices.size()));
  return packed;
}

Packed packSequence(const std::vector<unsigned>& indices) {
  Packed packed;
  packed.mode = "INDICES";
  packed.stride = 4;
  packed.count = indices.size();
  packed.stream.resize(meshopt_encodeIndexSequenceBound(indices.size(), 100));
  packed.stream.resize(meshopt_encodeIndexSequence(packed.stream.data(), packed.stream.size(),
                                                   indices.data(), indices.size()));
  return packed;
}

/// A view whose own bytes are a fallback that does not exist. Returns the view.
int addPacked(GltfFile& file, const Packed& packed) {
  const int stored = file.view(packed.stream);
  (void)stored;
  const std::size_t begin = file.binary().size() - packed.stream.size();
  return file.rawView(
      R"({"buffer":1,"byteLength":)" + std::to_string(packed.count * packed.stride) +
      R"(,"extensions":{"EXT_meshopt_compression":{"buffer":0,"byteOffset":)" +
      std::to_string(begin) + R"(,"byteLength":)" + std::to_string(packed.stream.size()) +
      R"(,"byteStride":)" + std::to_string(packed.stride) + R"(,"count":)" +
      std::to_string(packed.count) + R"(,"mode":")" + packed.mode + R"(","filter":")" +
      packed.filter + "\"}}}");
}

GltfFile meshoptFile(const Packed& vertices, const Packed& indices, int component = 5126) {
  GltfFile file;
  const int vertex_view = addPacked(file, vertices);
  const int index_view = addPacked(file, indices);
  file.mesh(file.accessor(vertex_view, component, vertices.count, "VEC3"),
            file.accessor(index_view, 5125, indices.count, "SCALAR"));
  file.nodeWith(0);
  file.buffers(
      R"({"byteLength":)" + std::to_string(file.binary().size()) +
      R"(},{"byteLength":1000000,"extensions":{"EXT_meshopt_compression":{"fallback":true}}})");
  file.top(R"("extensionsRequired":["EXT_meshopt_compression","KHR_mesh_quantization"])");
  return file;
}

const std::vector<unsigned> kTwoTriangles = {0, 1, 2, 0, 2, 3};

TEST(GltfMeshopt, DecodesAttributesTrianglesAndIndexSequences) {
  const Packed vertices = packVertices(kSquare, 12);
  for (const Packed& indices : {packTriangles(kTwoTriangles), packSequence(kTwoTriangles)}) {
    const auto scene = load(meshoptFile(vertices, indices).glb());
    ASSERT_TRUE(scene.ok()) << scene.error().message;
    EXPECT_EQ(scene.value()->mesh(0).triangles.size(), 2U);
    EXPECT_EQ(scene.value()->mesh(0).bounds.max, glm::dvec3(1, 1, 0));
  }
}

TEST(GltfMeshopt, DecodesQuantizedPositionsWithPadding) {
  const std::vector<std::int16_t> square = {0, 0, 0, 0, 500, 0, 0, 0, 500, 500, 0, 0, 0, 500, 0, 0};
  const auto scene =
      load(meshoptFile(packVertices(square, 8), packTriangles(kTwoTriangles), 5122).glb());
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  EXPECT_EQ(scene.value()->mesh(0).bounds.max, glm::dvec3(500, 500, 0));
}

TEST(GltfMeshopt, AppliesTheExponentialFilter) {
  // 2^e * m, with e in the upper 8 bits and m in the lower 24.
  const std::uint32_t three = (0xFFU << 24) | 6U;  // 6 * 2^-1
  const std::vector<std::uint32_t> square = {0, 0, 0, three, 0, 0, three, three, 0, 0, three, 0};
  Packed vertices = packVertices(square, 12);
  vertices.filter = "EXPONENTIAL";
  const auto scene = load(meshoptFile(vertices, packTriangles(kTwoTriangles)).glb());
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  EXPECT_EQ(scene.value()->mesh(0).bounds.max, glm::dvec3(3, 3, 0));
}

TEST(GltfMeshopt, RefusesStreamsThatDoNotFit) {
  const Packed good = packVertices(kSquare, 12);
  const Packed indices = packTriangles(kTwoTriangles);
  const auto lineOf = [&](const Packed& vertices) {
    return errorOf(meshoptFile(vertices, indices).glb());
  };
  Packed noise = good;
  noise.stream.assign(64, 0x5A);
  EXPECT_EQ(lineOf(noise), "t.glb: bufferView 1: the meshopt stream is broken");
  Packed stride = good;
  stride.stride = 13;
  EXPECT_EQ(lineOf(stride), "t.glb: bufferView 1: meshopt attributes need a byteStride of 4 n");
  Packed mode = good;
  mode.mode = "NOISE";
  EXPECT_EQ(lineOf(mode), "t.glb: bufferView 1: unknown meshopt mode");
  Packed filter = good;
  filter.filter = "OCTAHEDRAL";
  EXPECT_EQ(lineOf(filter),
            "t.glb: bufferView 1: the meshopt filter does not fit mode and byteStride");
}

TEST(GltfMeshopt, RefusesCountsThatTheBytesCannotHold) {
  GltfFile file;
  file.view(Stream(96, 0xA0));
  file.rawView(R"({"buffer":1,"byteLength":36,"extensions":{"EXT_meshopt_compression":{"buffer":0,
      "byteLength":96,"byteStride":12,"count":4000000000,"mode":"ATTRIBUTES"}}})");
  file.mesh(file.accessor(1, 5126, 3, "VEC3"));
  file.nodeWith(0);
  file.buffers(R"({"byteLength":96},
      {"byteLength":36,"extensions":{"EXT_meshopt_compression":{"fallback":true}}})");
  EXPECT_EQ(errorOf(file.glb()), "t.glb: bufferView 1: 4000000000 meshopt elements from 96 bytes");
}

TEST(GltfMeshopt, ChecksDecodedIndices) {
  const auto line =
      errorOf(meshoptFile(packVertices(kSquare, 12), packTriangles({0, 1, 2, 0, 2, 4})).glb());
  EXPECT_EQ(line, "t.glb: mesh 0: index 4 >= 4 vertices");
}

TEST(GltfMeshopt, AFallbackBufferWithoutTheExtensionOnItsViewHasNoBytes) {
  GltfFile file;
  file.view(kTriangle);
  file.rawView(R"({"buffer":1,"byteLength":36})");
  file.mesh(file.accessor(1, 5126, 3, "VEC3"));
  file.nodeWith(0);
  file.buffers(R"({"byteLength":36},
      {"byteLength":36,"extensions":{"EXT_meshopt_compression":{"fallback":true}}})");
  EXPECT_EQ(errorOf(file.glb()), "t.glb: accessor 0: buffer 1 has no bytes");
}

}  // namespace
}  // namespace culld::test
