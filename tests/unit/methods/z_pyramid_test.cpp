#include "culling/methods/z_pyramid.h"

#include <gtest/gtest.h>

#include "culling/methods/frustum.h"
#include "culling/scene/edit.h"
#include "tests/scenes/city.h"
#include "tests/scenes/random_scene.h"
#include "tests/scenes/rounds.h"
#include "tests/unit/spatial/box_scene.h"

namespace culld::testing {
namespace {

std::unique_ptr<Culler> prepared(const SnapshotPtr& scene, const std::string& settings = "") {
  static ConfiguredMethods methods(allMethods());
  auto method = methods.find("z-pyramid" + settings);
  EXPECT_TRUE(method.ok()) << (method.ok() ? "" : method.error().message);
  auto culler = method.value()->prepare(scene);
  EXPECT_TRUE(culler.ok());
  return std::move(culler).value();
}

Camera lookingFrom(const glm::dvec3& eye, const glm::dvec3& target, MotionBound motion = {}) {
  LookAt look;
  look.eye = eye;
  look.target = target;
  return cameraFromLookAt(look, {640, 360}, motion).value();
}

/// Walls behind walls, and small things between them.
SnapshotPtr wallsAndThings() {
  std::vector<std::array<double, 12>> boxes;
  for (int wall = 0; wall < 12; ++wall) {
    for (int i = 0; i < 10; ++i) {
      if ((i + wall) % 5 != 0)
        boxes.push_back(placed({10.0 * i - 50.0, 0.0, -20.0 * wall}, {10.0, 30.0, 1.0}));
    }
    for (int i = 0; i < 60; ++i)
      boxes.push_back(placed({1.7 * i - 50.0, 1.0, -20.0 * wall - 3.0 - i % 13}, glm::dvec3(0.8)));
  }
  return boxScene(boxes);
}

std::vector<Camera> flight(std::size_t count) {
  std::vector<Camera> cameras;
  for (std::size_t i = 0; i < count; ++i) {
    const double t = static_cast<double>(i);
    cameras.push_back(lookingFrom({0.4 * t - 4.0, 6.0, 30.0 - t}, {0.2 * t, 5.0, -100.0}));
  }
  return cameras;
}

TEST(ZPyramid, AnswersTheSameWhateverItRemembers) {
  scenes::CityOptions options;
  options.objects = 3000;
  options.frames = 24;
  const scenes::City city = scenes::generateCity(options);
  const SnapshotPtr scene = scenes::toSnapshot(city.model);
  const auto culler = prepared(scene), elsewhere = prepared(wallsAndThings());
  ViewState remembering, strange;
  std::uint32_t differently = 0;
  for (std::size_t i = 0; i < city.cameras.size(); ++i) {
    const Camera camera = scenes::toCamera(city.cameras[i]).value();
    // Every fifth frame the camera is somewhere else altogether.
    if (i % 5 == 4) {
      const Camera cut = scenes::toCamera(city.cameras[(i + 11) % city.cameras.size()]).value();
      culler->cull(cut, {}, remembering);
    }
    elsewhere->cull(flight(3)[i % 3], {}, strange);
    ViewState fresh;
    const Answer without = culler->cull(camera, {}, fresh);
    const Answer with = culler->cull(camera, {}, remembering);
    EXPECT_EQ(with.visible, without.visible);
    EXPECT_EQ(culler->cull(camera, {}, strange).visible, without.visible);
    if (with.stats.occluders_drawn != without.stats.occluders_drawn) ++differently;
    EXPECT_LT(without.visible.size(), scene->objectCount());
  }
  EXPECT_GT(differently, 0U);  // it does remember something
}

TEST(ZPyramid, AnswersTheSameWhateverItRemembersOfRandomScenes) {
  for (std::uint64_t seed = 1; seed <= scenes::rounds(40); ++seed) {
    scenes::RandomSceneOptions options;
    options.objects = 400;
    const SnapshotPtr scene = scenes::randomScene(seed, options);
    const auto culler = prepared(scene);
    ViewState remembering;
    for (const auto& spec : scenes::randomCameras(seed, *scene, 8)) {
      const auto camera = scenes::toCamera(spec);
      ASSERT_TRUE(camera.ok()) << camera.error().message;
      ViewState fresh;
      EXPECT_EQ(culler->cull(camera.value(), {}, remembering).visible,
                culler->cull(camera.value(), {}, fresh).visible)
          << seed;
    }
  }
}

TEST(ZPyramid, DoesNotHideBehindAnOccluderThatWasThereBefore) {
  SnapshotPtr scene =
      boxScene({placed({-5, -5, -20}, {10, 10, 1}), placed({-1, -1, -40}, {2, 2, 2})});
  auto culler = prepared(scene);
  const Camera camera = lookingFrom({0, 0, 0}, {0, 0, -1});
  ViewState view;
  EXPECT_EQ(culler->cull(camera, {}, view).visible, std::vector<ObjectId>{0});
  const std::vector<Edit> away{MoveObject{0, placed({30, -5, -20}, {10, 10, 1})}};
  auto edited = applyEdits(scene, away);
  ASSERT_TRUE(edited.ok());
  auto next = culler->edited(edited.value().snapshot, edited.value().changed);
  ASSERT_TRUE(next.ok());
  view.sceneEdited();
  const Answer after = next.value()->cull(camera, {}, view);
  EXPECT_TRUE(std::binary_search(after.visible.begin(), after.visible.end(), 1U));
  // And the other way: what comes in front hides in the same frame.
  auto back = applyEdits(edited.value().snapshot,
                         std::vector<Edit>{MoveObject{0, placed({-5, -5, -20}, {10, 10, 1})}});
  ASSERT_TRUE(back.ok());
  auto again = next.value()->edited(back.value().snapshot, back.value().changed);
  ASSERT_TRUE(again.ok());
  EXPECT_EQ(again.value()->cull(camera, {}, view).visible, std::vector<ObjectId>{0});
}

struct Totals {
  std::uint64_t nodes = 0, tested = 0, comparisons = 0, drawn = 0, visible = 0;
};

Totals totals(const SnapshotPtr& scene, const std::string& settings,
              const std::vector<Camera>& cameras) {
  const auto culler = prepared(scene, settings);
  Demand boxes_only;
  boxes_only.own_triangles = false;
  ViewState view;
  Totals sum;
  for (const Camera& camera : cameras) {
    const Answer answer = culler->cull(camera, boxes_only, view);
    sum.nodes += answer.stats.nodes_visited;
    sum.tested += answer.stats.tested;
    sum.comparisons += answer.stats.depth_comparisons;
    sum.drawn += answer.stats.occluders_drawn;
    sum.visible += answer.visible.size();
  }
  return sum;
}

TEST(ZPyramid, LevelsSaveDepthComparisons) {
  const SnapshotPtr scene = wallsAndThings();
  const Totals all = totals(scene, "", flight(10)), none = totals(scene, ":levels=0", flight(10));
  EXPECT_EQ(all.visible, none.visible);
  EXPECT_LT(10 * all.comparisons, none.comparisons);
}

TEST(ZPyramid, FrontFacesHideWhatRectanglesKeep) {
  const SnapshotPtr scene = wallsAndThings();
  const Totals faces = totals(scene, "", flight(10));
  const Totals rectangles = totals(scene, ":faces=off", flight(10));
  EXPECT_LT(faces.visible, rectangles.visible);
}

TEST(ZPyramid, CoherenceDrawsNothingInVain) {
  // Octants are not strictly ordered by what they hold: what is behind may be drawn first, unless
  // the last frame says what hides it.
  const SnapshotPtr scene = boxScene(randomBoxes(4000, {0, 0, 0}, 60.0, 5));
  std::vector<Camera> still(6, lookingFrom({0, 10, 120}, {0, 0, 0}));
  const Totals with = totals(scene, "", still), without = totals(scene, ":coherence=off", still);
  EXPECT_EQ(with.visible, without.visible);
  EXPECT_LT(5 * with.drawn, 4 * without.drawn);
  EXPECT_LT(with.comparisons, without.comparisons);
}

TEST(ZPyramid, TheUpdateStepByStepChangesNoAnswer) {
  const SnapshotPtr scene = wallsAndThings();
  const Totals step_by_step = totals(scene, "", flight(3));
  const Totals rebuilt = totals(scene, ":incremental=off", flight(3));
  EXPECT_EQ(step_by_step.visible, rebuilt.visible);
  EXPECT_EQ(step_by_step.comparisons, rebuilt.comparisons);
}

TEST(ZPyramid, SmallObjectsInManyCubesAreTestedLess) {
  // Small things on the middle planes: bound to the largest cubes, they are tested in every frame.
  auto boxes = randomBoxes(3000, {0, 0, 0}, 20.0, 9);
  boxes.push_back(placed({-64.0, -64.0, -64.0}, {1.0, 1.0, 1.0}));
  boxes.push_back(placed({63.0, 63.0, 63.0}, {1.0, 1.0, 1.0}));
  for (int i = 0; i < 1200; ++i)
    boxes.push_back(placed({-0.05, -60.0 + 0.1 * i, 20.0}, {0.1, 0.1, 0.1}));
  const SnapshotPtr scene = boxScene(boxes);
  const std::vector<Camera> aside{lookingFrom({40, 40, 40}, {60, 60, 60})};
  EXPECT_LT(2 * totals(scene, "", aside).tested, totals(scene, ":small=0", aside).tested);
}

TEST(ZPyramid, AnswersTheFrustumsWhereTheCameraMayTurnTooFar) {
  const SnapshotPtr scene = wallsAndThings();
  const auto culler = prepared(scene);
  const auto frustum = frustumMethod().prepare(scene);
  ASSERT_TRUE(frustum.ok());
  const Camera camera = lookingFrom({0, 6, 30}, {0, 5, -100}, {.radius_m = 0.5, .angle_rad = 1.5});
  ViewState one, other;
  const Answer answer = culler->cull(camera, {}, one);
  EXPECT_FALSE(answer.note.empty());
  EXPECT_EQ(answer.visible, frustum.value()->cull(camera, {}, other).visible);
  const Camera slower = lookingFrom({0, 6, 30}, {0, 5, -100}, {.radius_m = 0.1, .angle_rad = 0.1});
  const Answer moving = culler->cull(slower, {}, one);
  EXPECT_TRUE(moving.note.empty());
  EXPECT_LT(moving.visible.size(), answer.visible.size());
}

TEST(ZPyramid, StopsAtALimitOfWorkInTheSamePlaceEveryTime) {
  const SnapshotPtr scene = wallsAndThings();
  const auto culler = prepared(scene);
  const Camera camera = flight(5)[4];
  ViewState view;
  const Answer whole = culler->cull(camera, {}, view);
  Demand demand;
  demand.work = whole.stats.work / 3;
  const Answer cut = culler->cull(camera, demand, view);
  ViewState fresh;
  EXPECT_TRUE(cut.out_of_budget);
  EXPECT_EQ(cut.visible, culler->cull(camera, demand, fresh).visible);
  EXPECT_TRUE(std::includes(cut.visible.begin(), cut.visible.end(), whole.visible.begin(),
                            whole.visible.end()));
}

}  // namespace
}  // namespace culld::testing
