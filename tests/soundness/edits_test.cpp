// Edited scenes: a refitted culler promises what a fresh one does, and an edit shows in the next
// answer.
#include <gtest/gtest.h>

#include <cstdio>
#include <ctime>
#include <random>

#include "culling/scene/edit.h"
#include "culling/scene/scene_builder.h"
#include "tests/scenes/random_scene.h"
#include "tests/scenes/rounds.h"
#include "tests/soundness/judge.h"

namespace culld {
namespace {

class RandomEdits {
 public:
  explicit RandomEdits(std::uint64_t seed) : random_(seed) {}

  std::vector<Edit> next(const SceneSnapshot& scene) {
    std::vector<Edit> edits;
    for (std::uint64_t i = random_() % 3 + 1; i > 0; --i) {
      const auto id = static_cast<ObjectId>(random_() % scene.objectCount());
      if (scene.instance(id).removed) continue;
      const bool named = std::any_of(edits.begin(), edits.end(), [&](const Edit& edit) {
        const auto* remove = std::get_if<RemoveObject>(&edit);
        return remove != nullptr && remove->object == id;
      });
      if (!named) edits.push_back(edit(scene, id));
    }
    return edits;
  }

 private:
  Edit edit(const SceneSnapshot& scene, ObjectId id) {
    switch (random_() % 5) {
      case 0:
        return HideObject{id};
      case 1:
        return ShowObject{id};
      case 2:
        return RemoveObject{id};
      case 3:
        return AddInstance{id, moved(scene, id)};
      default:
        return MoveObject{id, moved(scene, id)};
    }
  }

  /// The object somewhere else among the others.
  std::array<double, 12> moved(const SceneSnapshot& scene, ObjectId id) {
    std::array<double, 12> world = scene.instance(id).world_from_mesh;
    const auto other = static_cast<ObjectId>(random_() % scene.objectCount());
    for (const std::size_t i : {3U, 7U, 11U}) world[i] = scene.instance(other).world_from_mesh[i];
    return world;
  }

  std::mt19937_64 random_;
};

TEST(Edits, ARefittedCullerMissesNothingAndAnswersNoHiddenObject) {
  for (std::uint64_t seed = 1; seed <= scenes::rounds(40); ++seed) {
    SnapshotPtr scene = scenes::randomScene(seed);
    std::vector<PreparedMethod> methods = prepareAll(scene, kFrustumSettings);
    RandomEdits edits(seed);
    for (int step = 0; step < 12; ++step) {
      auto edited = applyEdits(scene, edits.next(*scene));
      ASSERT_TRUE(edited.ok()) << edited.error().message;
      scene = edited.value().snapshot;
      for (PreparedMethod& method : methods) {
        auto next = method.culler->edited(scene, edited.value().changed);
        ASSERT_TRUE(next.ok());
        method.culler = std::move(next).value();
      }
    }
    auto oracle = Oracle::build(scene);
    ASSERT_TRUE(oracle.ok());
    const Camera camera = scenes::toCamera(scenes::randomCameras(seed, *scene, 1)[0]).value();
    OracleOptions options;
    options.max_samples = 20'000;
    auto truth = oracle.value()->look(camera, options);
    ASSERT_TRUE(truth.ok());
    for (PreparedMethod& method : methods) {
      const Answer answer = method.culler->cull(camera, {}, method.view);
      expectWellFormed(answer, *scene);
      EXPECT_TRUE(missing(truth.value().visible, answer.visible).empty()) << method.name << seed;
      for (ObjectId id : answer.visible) EXPECT_TRUE(scene->instance(id).active());
    }
  }
}

/// `side` cubed boxes on a grid, one mesh.
SnapshotPtr boxGrid(int side) {
  RawSurface surface;
  for (int i = 0; i < 8; ++i) surface.positions.emplace_back(i & 1, i >> 1 & 1, i >> 2);
  surface.indices = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                     2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
  SceneBuilder builder;
  const MeshId mesh = builder.addMesh(makeMesh({surface}));
  std::uint32_t node = 0;
  for (int z = 0; z < side; ++z) {
    for (int y = 0; y < side; ++y) {
      for (int x = 0; x < side; ++x) {
        builder.addInstance(mesh, {1, 0, 0, 3.0 * x, 0, 1, 0, 3.0 * y, 0, 0, 1, 3.0 * z}, node++);
      }
    }
  }
  return builder.finish();
}

TEST(Edits, OneAmong200000ShowsInTheNextAnswerWithinMilliseconds) {
#ifdef NDEBUG
  constexpr double kLimitMs = 5.0;
#else
  constexpr double kLimitMs = 100.0;  // assertions and sanitizers take their time
#endif
  SnapshotPtr scene = boxGrid(59);  // 205 379 objects
  LookAt look;
  look.eye = {-10.0, 88.0, 88.0};
  look.target = {0.0, 88.0, 88.0};
  const Camera camera = cameraFromLookAt(look, {}).value();
  for (PreparedMethod& method : prepareAll(scene)) {
    SnapshotPtr current = scene;
    const ObjectId object = method.culler->cull(camera, {}, method.view).visible.front();
    double best_ms = 1e9;
    for (int round = 0; round < 10; ++round) {
      const std::clock_t start = std::clock();
      const Edit edit = round % 2 == 0 ? Edit(HideObject{object}) : Edit(ShowObject{object});
      auto edited = applyEdits(current, std::vector<Edit>{edit});
      ASSERT_TRUE(edited.ok());
      current = edited.value().snapshot;
      auto next = method.culler->edited(current, edited.value().changed);
      ASSERT_TRUE(next.ok());
      const std::clock_t ready = std::clock();
      method.culler = std::move(next).value();
      best_ms = std::min(best_ms, 1e3 * static_cast<double>(ready - start) / CLOCKS_PER_SEC);
      const Answer answer = method.culler->cull(camera, {}, method.view);
      const bool answered =
          std::binary_search(answer.visible.begin(), answer.visible.end(), object);
      EXPECT_EQ(answered, round % 2 != 0) << method.name;
    }
    std::printf("%s: an edit among %zu objects takes %.3f ms of CPU time\n", method.name.c_str(),
                scene->objectCount(), best_ms);
    EXPECT_LT(best_ms, kLimitMs) << method.name;
  }
}

}  // namespace
}  // namespace culld
