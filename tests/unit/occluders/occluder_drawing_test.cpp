#include "culling/occluders/occluder_drawing.h"

#include <gtest/gtest.h>

#include "culling/core/camera.h"
#include "culling/scene/scene_builder.h"
#include "tests/scenes/shapes.h"

namespace culld {
namespace {

/// One object before the eye, ten metres off, as an occluder.
class OneOccluder {
 public:
  explicit OneOccluder(const Mesh& mesh, std::chrono::nanoseconds time = {}) {
    SceneBuilder builder;
    builder.addInstance(builder.addMesh(mesh), {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, -10}, 0);
    scene_ = builder.finish();
    set_ = OccluderSet::of(*scene_);
    const Camera camera = cameraFromLookAt({}, {}).value();
    view_ = cellView(camera, gridFor(camera));
    cells_.reset(view_.grid);
    const Deadline deadline(steadyClock(), steadyClock().now() - std::chrono::seconds(1), time);
    const OccluderDrawing drawing(*scene_, set_, view_, camera.origin_world, deadline, scratch_);
    drawn_ = drawing.draw(scene_->instance(0), 1.0F, OccluderDrawing::kNoLimit, cells_);
  }

  const DrawnOccluder& drawn() const { return drawn_; }
  bool hidesMiddle(float nearest) {
    const std::uint32_t x = view_.grid.width / 2, y = view_.grid.height / 2;
    return cells_.certainlyHidden({x, x, y, y}, nearest);
  }

 private:
  SnapshotPtr scene_;
  OccluderSet set_;
  CellView view_;
  OccluderScratch scratch_;
  DepthCells cells_;
  DrawnOccluder drawn_;
};

Mesh meshOf(const scenes::Triangles& t, bool blocks = true) {
  return makeMesh({{t.positions, t.indices, blocks, false}});
}

TEST(OccluderDrawing, DrawsABoxByItsOutline) {
  OneOccluder box(meshOf(scenes::box(glm::vec3(-2), glm::vec3(2))));
  EXPECT_TRUE(box.hidesMiddle(0.1F));   // ten metres off; its front is eight
  EXPECT_FALSE(box.hidesMiddle(0.2F));  // five
  EXPECT_FALSE(box.drawn().cut_short);
  EXPECT_EQ(box.drawn().triangles, 1U);  // a face, not its triangles: it came as a piece
  EXPECT_GT(box.drawn().work_ns, 0U);
}

TEST(OccluderDrawing, DrawsWhatIsNotConvexAsASheet) {
  scenes::Random random(1);
  OneOccluder ball(meshOf(scenes::ball(8, 0.3, random)));
  EXPECT_TRUE(ball.hidesMiddle(0.05F));
  EXPECT_GT(ball.drawn().triangles, 20U);
}

TEST(OccluderDrawing, DrawsNothingThatDoesNotBlock) {
  OneOccluder glass(meshOf(scenes::box(glm::vec3(-2), glm::vec3(2)), false));
  EXPECT_FALSE(glass.hidesMiddle(0.01F));
  EXPECT_EQ(glass.drawn().triangles, 0U);
}

TEST(OccluderDrawing, SaysThatTimeCutItShort) {
  scenes::Random random(1);
  OneOccluder ball(meshOf(scenes::ball(8, 0.3, random)), std::chrono::nanoseconds(1));
  EXPECT_TRUE(ball.drawn().cut_short);
  EXPECT_FALSE(ball.hidesMiddle(0.05F));
}

}  // namespace
}  // namespace culld
