// What must hold between the answers of two scenes that differ in a known way: one object less, all
// of it moved or scaled, a mesh cut in two, other ids.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "culling/scene/edit.h"
#include "tests/scenes/random.h"
#include "tests/scenes/random_scene.h"
#include "tests/scenes/rounds.h"
#include "tests/soundness/judge.h"

namespace culld {
namespace {

using scenes::CameraSpec;
using scenes::Model;
using scenes::Rows;

constexpr std::uint64_t kSeeds = scenes::rounds(48);

/// Not so far out that moving the scene would round away what can be seen.
Model usualModel(std::uint64_t seed) {
  scenes::RandomSceneOptions options;
  options.max_offset_m = 100.0;
  options.any_scale = false;
  return scenes::randomModel(seed, options);
}

std::vector<ObjectId> visibleIn(const SnapshotPtr& scene, const CameraSpec& spec) {
  const auto oracle = Oracle::build(scene);
  EXPECT_TRUE(oracle.ok());
  OracleOptions options;
  options.lattice = 1;
  options.max_samples = 20'000;
  const auto truth = oracle.value()->look(scenes::toCamera(spec).value(), options);
  EXPECT_TRUE(truth.ok());
  return truth.value().visible;
}

struct NamedAnswer {
  std::string method;
  std::vector<ObjectId> visible;
};

std::vector<NamedAnswer> answersFor(const SnapshotPtr& scene, const CameraSpec& spec) {
  std::vector<NamedAnswer> answers;
  const Camera camera = scenes::toCamera(spec).value();
  // Not `auto`: it answers as one of the others, and which one hangs on the views that it samples.
  for (const Method* method : allMethods()) {
    if (method->info().name == "auto") continue;
    const auto culler = method->prepare(scene);
    EXPECT_TRUE(culler.ok()) << method->info().name;
    if (!culler.ok()) continue;
    ViewState view;
    answers.push_back(
        {std::string(method->info().name), culler.value()->cull(camera, {}, view).visible});
  }
  return answers;
}

void expectNothingLost(const std::vector<ObjectId>& visible, const SnapshotPtr& scene,
                       const CameraSpec& spec) {
  for (const NamedAnswer& answer : answersFor(scene, spec)) {
    const auto lost = missing(visible, answer.visible);
    EXPECT_TRUE(lost.empty()) << answer.method << " lacks object " << lost.front();
  }
}

/// Calls `check` with a scene and a camera of it, often.
template <typename Check>
void forEachLook(const Check& check) {
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const Model model = usualModel(seed);
    const SnapshotPtr scene = scenes::toSnapshot(model);
    for (const CameraSpec& spec : scenes::randomCameras(seed, *scene, 2)) {
      SCOPED_TRACE("seed " + std::to_string(seed) + " camera " + spec.what);
      scenes::Random random(seed);
      check(model, scene, spec, random);
    }
  }
}

TEST(Properties, AnAnswerHoldsAllThatTheOracleSees) {
  forEachLook([](const Model&, const SnapshotPtr& scene, const CameraSpec& spec, scenes::Random&) {
    expectNothingLost(visibleIn(scene, spec), scene, spec);
  });
}

TEST(Properties, RemovingAnObjectRemovesNoVisibleOneFromTheAnswer) {
  std::size_t removed = 0, appeared = 0;
  forEachLook([&](const Model&, const SnapshotPtr& scene, const CameraSpec& spec,
                  scenes::Random& random) {
    const std::vector<ObjectId> visible = visibleIn(scene, spec);
    if (visible.empty()) return;
    for (int i = 0; i < 3; ++i) {
      const ObjectId gone =
          visible[random.below(static_cast<std::uint32_t>(visible.size()))];  // seen: may occlude
      auto edited = applyEdits(scene, std::vector<Edit>{RemoveObject{gone}});
      ASSERT_TRUE(edited.ok());
      std::vector<ObjectId> left = visible;
      std::erase(left, gone);
      expectNothingLost(left, edited.value().snapshot, spec);
      const std::vector<ObjectId> now = visibleIn(edited.value().snapshot, spec);
      expectNothingLost(now, edited.value().snapshot, spec);
      ++removed;
      appeared += missing(now, visible).size();
    }
  });
  EXPECT_GT(removed, kSeeds);
  EXPECT_GT(appeared, 0U);  // some of them did hide something
}

glm::dvec3 applied(const Rows& m, const glm::dvec3& p, double w) {
  return {m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3] * w,
          m[4] * p.x + m[5] * p.y + m[6] * p.z + m[7] * w,
          m[8] * p.x + m[9] * p.y + m[10] * p.z + m[11] * w};
}

Model moved(Model model, const Rows& by) {
  for (scenes::ModelNode& node : model.nodes) {
    node.parent_from_node = scenes::composed(by, node.parent_from_node);
  }
  return model;
}

/// The camera that goes with a rigid motion.
CameraSpec moved(CameraSpec spec, const Rows& by) {
  if (auto* look = std::get_if<LookAt>(&spec.pose)) {
    look->eye = applied(by, look->eye, 1.0);
    look->target = applied(by, look->target, 1.0);
    look->up = applied(by, look->up, 0.0);
    return spec;
  }
  glm::dmat4 back(1.0);  // the inverse: the transpose, and the shift turned back
  for (int column = 0; column < 3; ++column) {
    for (int row = 0; row < 3; ++row) {
      back[column][row] = by[static_cast<std::size_t>(4 * column + row)];
    }
  }
  back[3] = glm::dvec4(-(glm::dmat3(back) * glm::dvec3(by[3], by[7], by[11])), 1.0);
  auto& matrices = std::get<scenes::ViewProjection>(spec.pose);
  matrices.view = matrices.view * back;
  return spec;
}

TEST(Properties, MovingSceneAndCameraTogetherLosesNothing) {
  forEachLook([](const Model& model, const SnapshotPtr& scene, const CameraSpec& spec,
                 scenes::Random& random) {
    const glm::dvec3 shift{random.uniform(-50, 50), random.uniform(-50, 50), 17.0};
    const Rows turn{0.36, 0.48, -0.8, 0, -0.8, 0.6, 0, 0, 0.48, 0.64, 0.6, 0};  // exact to rounding
    const Rows by = scenes::composed(scenes::turnedAndMoved(random.uniform(-3, 3), shift), turn);
    const SnapshotPtr there = scenes::toSnapshot(moved(model, by));
    const CameraSpec from_there = moved(spec, by);
    expectNothingLost(visibleIn(scene, spec), there, from_there);
    expectNothingLost(visibleIn(there, from_there), there, from_there);
  });
}

/// The camera that goes with a scaling of the world by a power of two: the same clip coordinates.
CameraSpec scaled(CameraSpec spec, double by) {
  if (auto* look = std::get_if<LookAt>(&spec.pose)) {
    look->eye *= by;
    look->target *= by;
    look->znear_m *= by;
    if (look->zfar_m) *look->zfar_m *= by;
    return spec;
  }
  auto& matrices = std::get<scenes::ViewProjection>(spec.pose);
  matrices.view[3] = glm::dvec4(glm::dvec3(matrices.view[3]) * by, 1.0);
  for (int column = 0; column < 3; ++column) matrices.projection[column] /= by;
  return spec;
}

TEST(Properties, ScalingSceneAndCameraByAPowerOfTwoChangesNoByte) {
  forEachLook(
      [](const Model& model, const SnapshotPtr& scene, const CameraSpec& spec, scenes::Random&) {
        const std::vector<NamedAnswer> answers = answersFor(scene, spec);
        for (const int power : {-30, -7, 1, 12, 40}) {
          const double by = std::ldexp(1.0, power);
          Model model_there = model;
          for (scenes::ModelNode& node : model_there.nodes) {
            for (double& entry : node.parent_from_node) entry *= by;
          }
          const SnapshotPtr there = scenes::toSnapshot(model_there);
          const std::vector<NamedAnswer> answers_there = answersFor(there, scaled(spec, by));
          for (std::size_t m = 0; m < answers.size(); ++m) {
            // `auto` looks from the height of eyes first, and so tells a metre from a kilometre.
            if (answers[m].method == "auto") continue;
            EXPECT_EQ(answers_there[m].visible, answers[m].visible)
                << answers[m].method << " scaled by 2^" << power;
          }
        }
      });
}

/// Every object in two halves: object o becomes 2 o and 2 o + 1.
Model halved(const Model& model) {
  Model halves = model;
  halves.meshes.clear();
  halves.nodes.clear();
  for (const scenes::ModelNode& node : model.nodes) {
    for (const bool second : {false, true}) {
      scenes::ModelMesh half = model.meshes[node.mesh];
      for (scenes::Part& part : half.parts) {
        auto& indices = part.triangles.indices;
        const auto middle = indices.begin() + static_cast<std::ptrdiff_t>(indices.size() / 6 * 3);
        second ? indices.erase(indices.begin(), middle) : indices.erase(middle, indices.end());
      }
      const std::uint32_t mesh = halves.addMesh(std::move(half));
      halves.addNode({scenes::kNone, mesh, node.parent_from_node, ""});
    }
  }
  return halves;
}

TEST(Properties, CuttingEveryMeshInTwoLosesNoObject) {
  forEachLook(
      [](const Model& model, const SnapshotPtr& scene, const CameraSpec& spec, scenes::Random&) {
        const SnapshotPtr cut = scenes::toSnapshot(halved(model));
        expectNothingLost(visibleIn(cut, spec), cut, spec);
        const std::vector<ObjectId> visible = visibleIn(scene, spec);
        for (const NamedAnswer& answer : answersFor(cut, spec)) {
          std::vector<ObjectId> whole;
          for (const ObjectId half : answer.visible) {
            if (whole.empty() || whole.back() != half / 2) whole.push_back(half / 2);
          }
          EXPECT_TRUE(missing(visible, whole).empty()) << answer.method;
        }
      });
}

TEST(Properties, OtherIdsGiveAnAnswerThatHoldsTheSameVisibleObjects) {
  std::size_t answers = 0, equal = 0;
  forEachLook([&](const Model& model, const SnapshotPtr& scene, const CameraSpec& spec,
                  scenes::Random& random) {
    std::vector<std::uint32_t> new_of(model.nodes.size());
    std::iota(new_of.begin(), new_of.end(), 0U);
    for (auto i = static_cast<std::uint32_t>(new_of.size()); i > 1; --i) {
      std::swap(new_of[i - 1], new_of[random.below(i)]);
    }
    Model shuffled = model;
    for (std::size_t i = 0; i < new_of.size(); ++i) shuffled.nodes[new_of[i]] = model.nodes[i];
    const SnapshotPtr other = scenes::toSnapshot(shuffled);
    const std::vector<ObjectId> visible = visibleIn(scene, spec);
    const std::vector<NamedAnswer> before = answersFor(scene, spec),
                                   after = answersFor(other, spec);
    const auto renamed = [&](std::vector<ObjectId> ids) {
      for (ObjectId& id : ids) id = new_of[id];
      std::sort(ids.begin(), ids.end());
      return ids;
    };
    for (std::size_t m = 0; m < after.size(); ++m) {
      EXPECT_TRUE(missing(renamed(visible), after[m].visible).empty()) << after[m].method;
      ++answers;
      if (renamed(before[m].visible) == after[m].visible) ++equal;
    }
  });
  std::printf("%zu of %zu answers are the same objects whatever their ids\n", equal, answers);
  EXPECT_GT(equal * 10, answers * 9);  // the order of equally near things may decide the rest
}

}  // namespace
}  // namespace culld
