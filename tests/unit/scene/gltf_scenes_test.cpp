// The loader over a folder of real, special and broken files, given by the environment variable
// CULLD_SCENES. Each folder says itself what to expect of its files.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "culling/scene/gltf_loader.h"

namespace culld::test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

/// Generous for a loaded machine with sanitizers; a file that loops or bombs takes far longer.
constexpr std::chrono::seconds kBoundedTime{60};

class GltfScenes : public testing::Test {
 protected:
  void SetUp() override {
    const char* folder = std::getenv("CULLD_SCENES");
    if (folder == nullptr) GTEST_SKIP() << "CULLD_SCENES=DIR is not set";
    folder_ = folder;
    ASSERT_TRUE(fs::is_directory(folder_)) << folder_;
  }
  static Json readJson(const fs::path& path) {
    std::ifstream in(path);
    EXPECT_TRUE(in.good()) << path;
    return Json::parse(in);
  }
  fs::path folder_;
};

/// Loads, and holds every file to: one line or a scene, in bounded time.
Result<SnapshotPtr> loadAnything(const fs::path& path) {
  const auto begin = std::chrono::steady_clock::now();
  Result<SnapshotPtr> scene = loadGltfFile(path.string());
  EXPECT_LT(std::chrono::steady_clock::now() - begin, kBoundedTime) << path;
  if (!scene.ok()) {
    const std::string& line = scene.error().message;
    EXPECT_EQ(line.find('\n'), std::string::npos) << line;
    EXPECT_TRUE(line.starts_with(path.string() + ": ")) << line;
  }
  return scene;
}

std::vector<fs::path> gltfFilesBelow(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const std::string extension = entry.path().extension().string();
    if (extension == ".gltf" || extension == ".glb") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::uint64_t droppedTriangles(const SceneSnapshot& scene) {
  std::uint64_t dropped = 0;
  for (ObjectId id = 0; id < scene.objectCount(); ++id) {
    dropped += scene.mesh(scene.instance(id).mesh).dropped_triangles;
  }
  return dropped;
}

std::uint64_t pointsAndLines(const SceneSnapshot& scene) {
  std::uint64_t thin = 0;
  for (ObjectId id = 0; id < scene.objectCount(); ++id) {
    thin += scene.mesh(scene.instance(id).mesh).points_and_lines;
  }
  return thin;
}

/// Nodes with a mesh, where an instanced one counts as often as it has instances.
std::uint64_t expectedObjects(const Json& entry, const SceneSnapshot& scene) {
  const auto mesh_nodes = entry["mesh_nodes"].get<std::uint64_t>();
  const auto gpu_instances = entry["gpu_instances"].get<std::uint64_t>();
  if (gpu_instances == 0) return mesh_nodes;
  std::uint64_t instanced_nodes = 0;
  for (ObjectId id = 0; id < scene.objectCount(); ++id) {
    if (scene.instance(id).instance_number == 1) ++instanced_nodes;
  }
  return mesh_nodes - instanced_nodes + gpu_instances;
}

bool anyAlwaysKept(const SceneSnapshot& scene) {
  for (ObjectId id = 0; id < scene.objectCount(); ++id) {
    if (scene.instance(id).always_kept) return true;
  }
  return false;
}

void expectBounds(const Json& bounds, const SceneSnapshot& scene) {
  Box world;
  for (ObjectId id = 0; id < scene.objectCount(); ++id) world.grow(scene.instance(id).bounds_world);
  for (int axis = 0; axis < 3; ++axis) {
    const double low = bounds[0][static_cast<std::size_t>(axis)];
    const double high = bounds[1][static_cast<std::size_t>(axis)];
    const double slack = 1e-3 * (1.0 + high - low);
    EXPECT_LE(world.min[axis], low + slack) << "axis " << axis;
    EXPECT_GE(world.max[axis], high - slack) << "axis " << axis;
  }
}

TEST_F(GltfScenes, EverySceneHasTheCountsOfTheIndex) {
  for (const Json& entry : readJson(folder_ / "index.json")) {
    const std::string file = entry["file"];
    SCOPED_TRACE(file);
    const auto scene = loadAnything(folder_ / file);
    ASSERT_TRUE(scene.ok()) << scene.error().message;
    const SceneSnapshot& s = *scene.value();
    EXPECT_EQ(s.objectCount(), expectedObjects(entry, s));
    const std::uint64_t triangles = s.triangleCount() + droppedTriangles(s);
    if (pointsAndLines(s) == 0) {
      EXPECT_EQ(triangles, entry["triangles"].get<std::uint64_t>());
    } else {
      EXPECT_LE(triangles, entry["triangles"].get<std::uint64_t>());
    }
    if (!anyAlwaysKept(s)) expectBounds(entry["bounds"], s);
  }
}

TEST_F(GltfScenes, BrokenFilesDoWhatIsExpectedOfThem) {
  std::size_t seen = 0;
  for (const Json& entry : readJson(folder_ / "broken" / "expectations.json")) {
    const std::string file = entry["file"];
    const std::string expect = entry["expect"];
    SCOPED_TRACE(file + ": " + entry["why"].get<std::string>());
    const auto scene = loadAnything(folder_ / "broken" / file);
    const bool as_expected = expect == "either" || scene.ok() == (expect == "load");
    EXPECT_TRUE(as_expected) << (scene.ok() ? "it loads" : scene.error().message);
    ++seen;
  }
  EXPECT_GT(seen, 100U);
}

/// The validator's report lies beside each of its files. What it finds clean must load, unless the
/// file leaves out bytes or needs a newer glTF.
TEST_F(GltfScenes, TheKhronosValidatorsFilesLoadIfTheyAreClean) {
  std::size_t clean = 0;
  for (const fs::path& path : gltfFilesBelow(folder_ / "khronos_validator_tests")) {
    SCOPED_TRACE(path.string());
    const auto scene = loadAnything(path);
    const fs::path report = path.string() + ".report.json";
    if (scene.ok() || !fs::exists(report)) continue;
    const Json issues = readJson(report)["issues"];
    if (issues["numErrors"] == 0) {
      const std::string& line = scene.error().message;
      const bool told = line.find("has no bytes") != line.npos ||
                        line.find("minVersion is not 2.0") != line.npos ||
                        line.find("is not supported") != line.npos ||
                        line.find("No such file") != line.npos ||
                        line.find("only data: and relative paths") != line.npos;
      EXPECT_TRUE(told) << line;
    }
    ++clean;
  }
  EXPECT_GT(clean, 50U);
}

TEST_F(GltfScenes, AssimpsFilesLoadOrSayWhyNot) {
  std::size_t loaded = 0;
  for (const fs::path& path : gltfFilesBelow(folder_ / "assimp_gltf2")) {
    SCOPED_TRACE(path.string());
    if (loadAnything(path).ok()) ++loaded;
  }
  EXPECT_GT(loaded, 30U);
}

}  // namespace
}  // namespace culld::test
