// tinygltf as an independent reader: the same objects, triangles and places must come out of both.
// It shares no code with the loader; what it cannot read (Draco, meshopt) is left to other tests.
#include <gtest/gtest.h>
#include <tiny_gltf.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <glm/gtc/quaternion.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <glm/mat4x4.hpp>
#include <iterator>
#include <string>

#include "tests/unit/scene/gltf_file.h"

namespace culld::test {
namespace {

glm::dmat4 localOf(const tinygltf::Node& node) {
  glm::dmat4 m(1.0);
  if (node.matrix.size() == 16) return glm::make_mat4(node.matrix.data());
  if (node.translation.size() == 3) {
    m[3] = {node.translation[0], node.translation[1], node.translation[2], 1.0};
  }
  if (node.rotation.size() == 4) {
    const auto& q = node.rotation;
    m = m * glm::mat4_cast(glm::dquat(q[3], q[0], q[1], q[2]));
  }
  if (node.scale.size() == 3) {
    for (int i = 0; i < 3; ++i) m[i] *= node.scale[static_cast<std::size_t>(i)];
  }
  return m;
}

/// World matrices of the nodes of the default scene, by their numbers.
std::vector<std::pair<int, glm::dmat4>> placesOf(const tinygltf::Model& model) {
  std::vector<std::pair<int, glm::dmat4>> open;
  std::vector<std::pair<int, glm::dmat4>> all;
  const auto scene = static_cast<std::size_t>(std::max(model.defaultScene, 0));
  for (const int root : model.scenes[scene].nodes) open.emplace_back(root, glm::dmat4(1.0));
  while (!open.empty()) {
    auto [number, world] = open.back();
    open.pop_back();
    const tinygltf::Node& node = model.nodes[static_cast<std::size_t>(number)];
    world = world * localOf(node);
    if (node.mesh >= 0) all.emplace_back(number, world);
    for (const int child : node.children) open.emplace_back(child, world);
  }
  std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  return all;
}

/// Corners of the triangle lists of a mesh, in drawing order. Only floats and plain views.
std::vector<glm::dvec3> cornersOf(const tinygltf::Model& model, int mesh) {
  std::vector<glm::dvec3> corners;
  const auto bytesOf = [&](const tinygltf::Accessor& a) {
    const auto& view = model.bufferViews[static_cast<std::size_t>(a.bufferView)];
    return model.buffers[static_cast<std::size_t>(view.buffer)].data.data() + view.byteOffset +
           a.byteOffset;
  };
  const auto strideOf = [&](const tinygltf::Accessor& a) {
    return static_cast<std::size_t>(
        a.ByteStride(model.bufferViews[static_cast<std::size_t>(a.bufferView)]));
  };
  for (const auto& primitive : model.meshes[static_cast<std::size_t>(mesh)].primitives) {
    const auto& xyz =
        model.accessors[static_cast<std::size_t>(primitive.attributes.at("POSITION"))];
    const auto& index = model.accessors[static_cast<std::size_t>(primitive.indices)];
    for (std::size_t i = 0; i < index.count; ++i) {
      std::uint32_t vertex = 0;
      const std::size_t size = strideOf(index);
      std::memcpy(&vertex, bytesOf(index) + i * size, size);
      glm::vec3 p;
      std::memcpy(&p, bytesOf(xyz) + vertex * strideOf(xyz), sizeof p);
      corners.emplace_back(p);
    }
  }
  return corners;
}

void expectSamePlace(const Instance& instance, const glm::dmat4& world) {
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      const double ours = instance.world_from_mesh[static_cast<std::size_t>(4 * row + column)];
      const double theirs = world[column][row];
      EXPECT_NEAR(ours, theirs, 1e-9 * (1.0 + std::abs(theirs))) << row << " " << column;
    }
  }
}

void expectCornersInside(const Box& box, const std::vector<glm::dvec3>& corners,
                         const glm::dmat4& world) {
  for (const glm::dvec3& corner : corners) {
    const glm::dvec3 p(world * glm::dvec4(corner, 1.0));
    for (int axis = 0; axis < 3; ++axis) {
      const double slack = 1e-9 * (1.0 + std::abs(p[axis]));
      ASSERT_LE(box.min[axis], p[axis] + slack);
      ASSERT_GE(box.max[axis], p[axis] - slack);
    }
  }
}

void compare(const std::string& bytes, const std::string& name) {
  tinygltf::TinyGLTF judge;
  tinygltf::Model model;
  std::string error;
  std::string warning;
  ASSERT_TRUE(judge.LoadBinaryFromMemory(&model, &error, &warning,
                                         reinterpret_cast<const unsigned char*>(bytes.data()),
                                         static_cast<unsigned>(bytes.size())))
      << error;
  const auto scene = loadGltfBytes(std::as_bytes(std::span(bytes)), name);
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  const auto places = placesOf(model);
  ASSERT_EQ(scene.value()->objectCount(), places.size());
  ASSERT_GT(places.size(), 0U);
  for (ObjectId id = 0; id < places.size(); ++id) {
    const auto& [number, world] = places[id];
    const Instance& instance = scene.value()->instance(id);
    const Mesh& mesh = scene.value()->mesh(instance.mesh);
    ASSERT_EQ(instance.node, static_cast<std::uint32_t>(number));
    const auto corners = cornersOf(model, model.nodes[static_cast<std::size_t>(number)].mesh);
    EXPECT_EQ(mesh.triangles.size() + mesh.dropped_triangles, corners.size() / 3);
    expectSamePlace(instance, world);
    if (mesh.dropped_triangles == 0) expectCornersInside(instance.bounds_world, corners, world);
  }
}

TEST(GltfJudge, AgreesOnASceneMadeInMemory) {
  GltfFile file;
  const int square = file.positions(kSquare);
  file.mesh(square, file.indices({0, 1, 2, 0, 2, 3}));
  file.mesh(square, file.indices({0, 1, 2}));
  file.node(R"({"children":[1,2],"translation":[1e6,2,3],"rotation":[0.5,0.5,0.5,0.5]})");
  file.node(R"({"mesh":0,"scale":[-2,3,0.5],"children":[3]})");
  file.node(R"({"mesh":1,"matrix":[1,0.5,0,0, 0,1,0.25,0, 0,0,1,0, 7,8,9,1]})");
  file.node(R"({"mesh":1,"rotation":[0,0,0.6,0.8],"scale":[1,2,3]})");
  file.top(R"("scene":0,"scenes":[{"nodes":[0]}])");
  const Bytes glb = file.glb();
  compare(std::string(reinterpret_cast<const char*>(glb.data()), glb.size()), "made");
}

TEST(GltfJudge, AgreesOnRealScenes) {
  const char* folder = std::getenv("CULLD_SCENES");
  if (folder == nullptr) GTEST_SKIP() << "CULLD_SCENES=DIR is not set";
  std::size_t compared = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() != ".glb") continue;
    std::ifstream in(entry.path(), std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(in), {}};
    if (bytes.find("EXT_mesh_gpu_instancing") != bytes.npos) continue;
    SCOPED_TRACE(entry.path().string());
    compare(bytes, entry.path().filename().string());
    ++compared;
  }
  EXPECT_GT(compared, 5U);
}

}  // namespace
}  // namespace culld::test
