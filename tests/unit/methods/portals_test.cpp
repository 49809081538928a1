#include "culling/methods/portals.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "culling/methods/frustum.h"
#include "culling/scene/edit.h"
#include "culling/scene/scene_builder.h"
#include "tests/scenes/model.h"
#include "tests/scenes/shapes.h"

namespace culld {
namespace {

using scenes::Triangles;

/// A wall across the view at z = 0, made of two panels side by side, and small things behind it.
class BehindPanels : public ::testing::Test {
 protected:
  BehindPanels() {
    panel_ = addMesh(scenes::box({-10, -10, -0.05F}, {10, 10, 0.05F}));
    thing_ = addMesh(scenes::box(glm::vec3(-0.2F), glm::vec3(0.2F)));
    left_ = add(panel_, scenes::movedBy({-10, 0, 0}));
    right_ = add(panel_, scenes::movedBy({10, 0, 0}));
    for (int i = 0; i < 100; ++i) {
      things_.push_back(add(thing_, scenes::movedBy({i % 10 - 4.5, i / 10 * 0.5 - 2.0, -5.0})));
    }
  }
  MeshId addMesh(const Triangles& t) {
    return builder_.addMesh(makeMesh({{t.positions, t.indices, true, false}}));
  }
  ObjectId add(MeshId mesh, const scenes::Rows& rows) {
    return builder_.addInstance(mesh, rows, nodes_++);
  }
  static Camera camera(const glm::dvec3& eye = {0, 0, 10}, MotionBound motion = {},
                       double near_m = 0.1) {
    LookAt look;
    look.eye = eye;
    look.target = eye + glm::dvec3(0, 0, -1);
    look.znear_m = near_m;
    return cameraFromLookAt(look, {}, motion).value();
  }
  std::unique_ptr<Culler> prepared(const std::string& settings = "") {
    if (scene_ == nullptr) scene_ = builder_.finish();
    return methods_.find("portals" + settings).value()->prepare(scene_).value();
  }
  Answer cull(const Camera& seen_by = camera(), const std::string& settings = "") {
    ViewState view;
    return prepared(settings)->cull(seen_by, {}, view);
  }
  std::size_t inFrustum(const Camera& seen_by) {
    ViewState view;
    return frustumMethod().prepare(scene_).value()->cull(seen_by, {}, view).visible.size();
  }

  ConfiguredMethods methods_{allMethods()};
  SceneBuilder builder_;
  SnapshotPtr scene_;
  std::uint32_t nodes_ = 0;
  MeshId panel_ = 0, thing_ = 0;
  ObjectId left_ = 0, right_ = 0;
  std::vector<ObjectId> things_;
};

TEST_F(BehindPanels, PanelsThatMeetHideAsOneBox) {
  const Answer answer = cull();
  EXPECT_EQ(answer.visible, (std::vector{left_, right_}));
  EXPECT_EQ(answer.stats.occluders_drawn, 1U);
  EXPECT_EQ(answer.stats.in_frustum, 102U);
  EXPECT_TRUE(answer.note.empty());
  EXPECT_EQ(answer.guarantee, Guarantee::kConservative);
}

TEST_F(BehindPanels, VoxelsNotCutAlongTheWallsDoNotFitIntoThem) {
  EXPECT_EQ(cull(camera(), ":walls=off").visible.size(), 102U);
}

TEST_F(BehindPanels, WithoutBoxesTheAnswerIsThatOfTheFrustum) {
  const Answer answer = cull(camera(), ":boxes=0");
  EXPECT_EQ(answer.visible.size(), 102U);
  EXPECT_EQ(answer.stats.occluders_drawn, 0U);
}

TEST_F(BehindPanels, ThingsInFrontAndInTheWallAreKept) {
  const ObjectId front = add(thing_, scenes::movedBy({0, 0, 1}));
  const ObjectId within = add(thing_, scenes::movedBy({3, 0, 0.1}));
  const Answer answer = cull();
  EXPECT_EQ(answer.visible, (std::vector{left_, right_, front, within}));
}

TEST_F(BehindPanels, AnEyeWithinASolidOrTooNearToOneGetsTheFrustumAndANote) {
  for (const Camera& near : {camera({0, 0, 0}), camera({0, 0, 0.051}), camera({0, 0, 1}, {}, 1.0),
                             camera({0, 0, 1}, {.radius_m = 0.96, .angle_rad = 0.0})}) {
    const Answer answer = cull(near);
    EXPECT_EQ(answer.visible.size(), inFrustum(near));
    EXPECT_NE(answer.note.find("portals: the eye is within"), std::string::npos) << answer.note;
  }
}

TEST_F(BehindPanels, MotionBoundsAreHeldAsLongAsTheirBallIsClear) {
  const Answer still = cull(camera({0, 0, 10}));
  const Answer moving = cull(camera({0, 0, 10}, {.radius_m = 2.0, .angle_rad = 0.05}));
  EXPECT_TRUE(moving.note.empty());
  EXPECT_EQ(moving.visible, still.visible);
  EXPECT_FALSE(cull(camera({0, 0, 10}, {.radius_m = 0.0, .angle_rad = 1.5})).note.empty());
}

TEST_F(BehindPanels, OrthographicCamerasGetTheFrustumAndANote) {
  const glm::dmat4 view(1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, -10, 1);
  const glm::dmat4 projection(0.2, 0, 0, 0, 0, 0.2, 0, 0, 0, 0, -0.02, 0, 0, 0, -1, 1);
  const Answer answer = cull(cameraFromMatrices(view, projection, {640, 480}).value());
  EXPECT_EQ(answer.visible.size(), 102U);
  EXPECT_EQ(answer.note, "portals: an orthographic camera, occlusion is left out");
}

TEST_F(BehindPanels, AnEditOfAPanelTakesItsSolidAwayAndOfAThingDoesNot) {
  const auto culler = prepared();
  ViewState view;
  const EditedScene fewer = applyEdits(scene_, std::vector<Edit>{HideObject{things_[3]}}).value();
  const auto without_thing = culler->edited(fewer.snapshot, fewer.changed).value();
  EXPECT_EQ(without_thing->cull(camera(), {}, view).visible, (std::vector{left_, right_}));
  const EditedScene open = applyEdits(fewer.snapshot, std::vector<Edit>{HideObject{left_}}).value();
  const auto without_panel = without_thing->edited(open.snapshot, open.changed).value();
  view.sceneEdited();
  EXPECT_EQ(without_panel->cull(camera(), {}, view).visible.size(), 100U);  // one thing is hidden
}

TEST_F(BehindPanels, MemoryOfAViewNeverChangesAnAnswer) {
  const auto culler = prepared();
  ViewState kept;
  for (const glm::dvec3& eye : {glm::dvec3(0, 0, 10), {15, 3, 4}, {0, 0, -20}, {-30, 0, 1}}) {
    ViewState fresh;
    EXPECT_EQ(culler->cull(camera(eye), {}, kept).visible,
              culler->cull(camera(eye), {}, fresh).visible);
  }
}

TEST_F(BehindPanels, ScenesWithoutSolidsGetTheFrustumAndANote) {
  SceneBuilder sheets;
  const Triangles sheet = scenes::quad({-1, -1, 0}, {2, 0, 0}, {0, 2, 0});
  const MeshId mesh = sheets.addMesh(makeMesh({{sheet.positions, sheet.indices, true, false}}));
  sheets.addInstance(mesh, scenes::kIdentity, 0);
  scene_ = sheets.finish();
  const Answer answer = cull();
  EXPECT_EQ(answer.visible.size(), 1U);
  EXPECT_EQ(answer.note, "portals: nothing in this scene is solid, occlusion is left out");
}

TEST(PortalsMethod, RefusesScenesInWhichNothingBlocks) {
  SceneProfile profile;
  const auto refused = portalsMethod().accepts(profile);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().message, "portals: nothing in this scene blocks");
  profile.blocking_triangles = 1;
  EXPECT_TRUE(portalsMethod().accepts(profile).ok());
}

}  // namespace
}  // namespace culld
