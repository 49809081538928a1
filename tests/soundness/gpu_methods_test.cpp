// Methods on a GPU with a backend that works: they keep what they promise on random scenes, after
// edits, within motion bounds and at every end of their settings, hide something, and stay right
// when the GPU is lost under them. Without a backend they answer what `frustum` does; the other
// soundness tests hold them to that.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <thread>

#include "culling/planner/scene_profile.h"
#include "culling/raster/cell_view.h"
#include "culling/scene/edit.h"
#include "tests/scenes/random_scene.h"
#include "tests/scenes/rounds.h"
#include "tests/soundness/judge.h"
#include "tests/unit/gpu/opened_backend.h"

namespace culld {
namespace {

/// Methods that refuse every scene without a backend.
bool needsGpu(const Method& method) { return method.info().needs == "OpenGL 4.5"; }

std::vector<std::string> gpuMethods() {
  std::vector<std::string> names;
  for (const Method* method : allMethods()) {
    if (needsGpu(*method)) names.emplace_back(method->info().name);
  }
  return names;
}

/// Those that the oracle holds to all it sees. tests/unit/gpu/item_buffer_test.cpp: the other one.
bool conservative(const Method& method) {
  return needsGpu(method) && method.info().guarantee == Guarantee::kConservative;
}

/// What the method is made to answer.
Demand demandOf(const std::string& name) {
  return {.guarantee = findMethod(name)->info().guarantee};
}

/// Each method with one setting at one of its ends, others for another `turn`.
std::vector<std::string> gpuMethodsAtAnEnd(std::uint64_t turn) {
  std::vector<std::string> names;
  for (const Method* method : allMethods()) {
    if (!conservative(*method)) continue;
    std::vector<std::string> ends;
    for (const Setting& setting : method->settings()) {
      for (const double value : {setting.least, setting.most}) {
        if (value == setting.standard) continue;
        ends.push_back(std::string(method->info().name) + ":" + std::string(setting.name) + "=" +
                       valueText(setting, value));
      }
    }
    if (!ends.empty()) names.push_back(ends[turn % ends.size()]);
  }
  return names;
}

/// As it is, or an image of a quarter of its sides, which a software renderer draws in a tenth of
/// the time; what can be seen does not hang on it.
Camera cameraOf(scenes::CameraSpec spec, bool small) {
  if (small) {
    spec.image.width_px = std::max(spec.image.width_px / 4, 1U);
    spec.image.height_px = std::max(spec.image.height_px / 4, 1U);
  }
  return scenes::toCamera(spec).value();
}

class GpuMethods : public gpu::WithBackend {
 protected:
  std::vector<PreparedMethod> prepare(const SnapshotPtr& scene,
                                      const std::vector<std::string>& names) {
    std::vector<PreparedMethod> out;
    for (const std::string& name : names) {
      const Method* method = configured_.find(name).value();
      EXPECT_TRUE(method->accepts(profileScene(*scene)).ok()) << name;
      out.push_back({name, method->prepare(scene).value(), ViewState{}});
    }
    return out;
  }
  std::vector<PreparedMethod> prepare(const SnapshotPtr& scene, std::uint64_t turn) {
    std::vector<std::string> names = gpuMethodsAtAnEnd(turn);
    for (const Method* method : allMethods()) {
      if (conservative(*method)) names.emplace_back(method->info().name);
    }
    return prepare(scene, names);
  }

  static std::vector<ObjectId> inFrustum(const SnapshotPtr& scene, const Camera& camera) {
    ViewState fresh;
    return findMethod("frustum")->prepare(scene).value()->cull(camera, {}, fresh).visible;
  }

  void judge(const SnapshotPtr& scene, const Oracle& oracle, std::vector<PreparedMethod>& methods,
             const Camera& camera) {
    OracleOptions options;
    options.lattice = 1;
    options.max_samples = 10'000;
    const auto truth = oracle.look(camera, options);
    ASSERT_TRUE(truth.ok()) << truth.error().message;
    frustum_ += inFrustum(scene, camera).size() * methods.size();
    for (PreparedMethod& method : methods) {
      const Answer answer = method.culler->cull(camera, {}, method.view);
      expectWellFormed(answer, *scene);
      EXPECT_EQ(answer.note.empty(), holdsInMotion(camera)) << answer.note;
      const auto lost = missing(truth.value().visible, answer.visible);
      EXPECT_TRUE(lost.empty()) << method.name << " lacks object " << lost.front();
      ViewState forgetful;
      EXPECT_EQ(method.culler->cull(camera, {}, forgetful).visible, answer.visible)
          << method.name << " depends on what the view remembers";
      answered_ += answer.visible.size();
      ++looks_;
    }
  }

  /// Not just now and then: one in fifty of what the frustum answers.
  void expectHidden() const {
    std::printf("%zu looks: frustum answered %zu, methods on the GPU %zu\n", looks_, frustum_,
                answered_);
    EXPECT_GT(looks_, 10U);
    EXPECT_LT(answered_, frustum_ - frustum_ / 50);
  }

  ConfiguredMethods configured_{allMethods()};
  std::size_t looks_ = 0, answered_ = 0, frustum_ = 0;
};

TEST_F(GpuMethods, LackNothingThatTheOracleSees) {
  for (std::uint64_t seed = 1; seed <= scenes::rounds(40); ++seed) {
    const SnapshotPtr scene = scenes::randomScene(seed);
    const auto oracle = Oracle::build(scene);
    ASSERT_TRUE(oracle.ok());
    std::vector<PreparedMethod> methods = prepare(scene, seed);
    for (const scenes::CameraSpec& spec : scenes::randomCameras(seed, *scene, 3)) {
      SCOPED_TRACE("seed " + std::to_string(seed) + " camera " + spec.what);
      judge(scene, *oracle.value(), methods, cameraOf(spec, looks_ % 16 != 0));
    }
  }
  expectHidden();
}

TEST_F(GpuMethods, LackNothingWithinAMotionBound) {
  for (std::uint64_t seed = 1; seed <= scenes::rounds(24); ++seed) {
    const SnapshotPtr scene = scenes::randomScene(seed, {.any_scale = false});
    const auto oracle = Oracle::build(scene);
    ASSERT_TRUE(oracle.ok());
    std::vector<PreparedMethod> methods = prepare(scene, seed);
    for (const scenes::CameraSpec& spec : scenes::randomCameras(seed, *scene, 2)) {
      SCOPED_TRACE("seed " + std::to_string(seed) + " camera " + spec.what);
      Camera camera = cameraOf(spec, true);
      camera.motion.radius_m = 0.02 * static_cast<double>(1 + seed % 4);
      camera.motion.angle_rad = 0.01 * static_cast<double>(seed % 3);
      judge(scene, *oracle.value(), methods, camera);
    }
  }
  expectHidden();
}

TEST_F(GpuMethods, LackNothingAfterEdits) {
  for (std::uint64_t seed = 1; seed <= scenes::rounds(24); ++seed) {
    SnapshotPtr scene = scenes::randomScene(seed);
    std::vector<PreparedMethod> methods = prepare(scene, seed);
    const Camera camera = cameraOf(scenes::randomCameras(seed, *scene, 1)[0], true);
    for (std::uint64_t step = 0; step < 4; ++step) {
      const auto id = static_cast<ObjectId>((seed * 7 + step * 13) % scene->objectCount());
      const auto to = static_cast<ObjectId>((seed * 11 + step * 5) % scene->objectCount());
      if (scene->instance(id).removed) continue;
      const Edit edits[] = {MoveObject{id, scene->instance(to).world_from_mesh}};
      auto edited = applyEdits(scene, edits);
      ASSERT_TRUE(edited.ok()) << edited.error().message;
      scene = edited.value().snapshot;
      for (PreparedMethod& method : methods) {
        method.culler = method.culler->edited(scene, edited.value().changed).value();
        method.view.sceneEdited();
      }
      const auto oracle = Oracle::build(scene);
      ASSERT_TRUE(oracle.ok());
      SCOPED_TRACE("seed " + std::to_string(seed) + " step " + std::to_string(step));
      judge(scene, *oracle.value(), methods, camera);
    }
  }
  expectHidden();
}

struct Trouble {
  std::atomic<bool>& fault;
  std::string note;  ///< of the call that meets it
  bool in_a_new_context = false;
};

TEST_F(GpuMethods, AnswerTheFrustumWhenTheGpuFailsInAFrameAndRecover) {
  using gpu::Faults;
  const Trouble troubles[] = {{Faults::reset, "the GPU was reset"},
                              {Faults::out_of_memory, "GL_OUT_OF_MEMORY"},
                              {Faults::no_buffer, "GL_OUT_OF_MEMORY"},
                              {Faults::no_shader, "a shader does not compile", true}};
  const SnapshotPtr scene = scenes::randomScene(5);
  const Camera camera = cameraOf(scenes::randomCameras(5, *scene, 1)[0], true);
  const auto frustum = inFrustum(scene, camera);
  for (const std::string& name : gpuMethods()) {
    const Demand demand = demandOf(name);
    for (const Trouble& trouble : troubles) {
      SCOPED_TRACE(name + ": " + trouble.note);
      auto method = std::move(prepare(scene, {name})[0]);
      const auto whole = method.culler->cull(camera, demand, method.view);
      EXPECT_EQ(whole.guarantee, demand.guarantee) << whole.note;
      EXPECT_LT(whole.visible.size(), frustum.size());
      method = std::move(prepare(scene, {name})[0]);  // not uploaded so far
      if (trouble.in_a_new_context) gpu::backend()->acquire().value().drop("by a test");
      trouble.fault = true;
      const auto lost = method.culler->cull(camera, demand, method.view);
      EXPECT_FALSE(trouble.fault) << "nothing met it";
      EXPECT_EQ(lost.visible, frustum);
      EXPECT_EQ(lost.guarantee, Guarantee::kConservative);
      EXPECT_TRUE(lost.note.find(trouble.note) != std::string::npos) << lost.note;
      constexpr int kMostCalls = 3;  // two failures in a row make one call answer at once
      Answer after = lost;
      for (int i = 0; i < kMostCalls && after.note != whole.note; ++i) {
        after = method.culler->cull(camera, demand, method.view);
      }
      EXPECT_EQ(after.visible, whole.visible);
      EXPECT_EQ(after.note, whole.note);
    }
  }
}

TEST_F(GpuMethods, ServeManyThreadsAtOnce) {
  const SnapshotPtr scene = scenes::randomScene(9);
  const auto specs = scenes::randomCameras(9, *scene, 4);
  for (PreparedMethod& method : prepare(scene, gpuMethods())) {
    const Demand demand = demandOf(method.name);
    std::vector<std::vector<ObjectId>> expected;
    for (const auto& spec : specs) {
      ViewState fresh;
      expected.push_back(method.culler->cull(cameraOf(spec, true), demand, fresh).visible);
    }
    std::atomic<int> wrong{0};
    std::vector<std::thread> threads;
    for (std::size_t t = 0; t < 4; ++t) {
      threads.emplace_back([&, t] {
        ViewState view;
        for (std::size_t i = 0; i < 12; ++i) {
          const std::size_t c = (t + i) % specs.size();
          const Camera camera = cameraOf(specs[c], true);
          if (method.culler->cull(camera, demand, view).visible != expected[c]) ++wrong;
        }
      });
    }
    for (std::thread& thread : threads) thread.join();
    EXPECT_EQ(wrong, 0) << method.name;
  }
}

TEST_F(GpuMethods, KeepEverythingWhenTimeRunsOut) {
  const SnapshotPtr scene = scenes::randomScene(5);
  const Camera camera = cameraOf(scenes::randomCameras(5, *scene, 1)[0], true);
  for (PreparedMethod& method : prepare(scene, gpuMethods())) {
    Demand demand = demandOf(method.name);
    const auto unlimited = method.culler->cull(camera, demand, method.view);
    demand.time = std::chrono::nanoseconds(1);
    const auto cut = method.culler->cull(camera, demand, method.view);
    EXPECT_TRUE(cut.out_of_budget);
    EXPECT_TRUE(missing(unlimited.visible, cut.visible).empty()) << method.name;
  }
}

}  // namespace
}  // namespace culld
