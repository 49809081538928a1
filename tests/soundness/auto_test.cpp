// `auto` leaves stages out and takes them back while a view runs; whatever it uses, nothing visible
// may be missing.
#include <gtest/gtest.h>

#include <set>

#include "culling/planner/auto_method.h"
#include "culling/scene/edit.h"
#include "tests/scenes/landscapes.h"
#include "tests/soundness/judge.h"

namespace culld {
namespace {

/// Closed rooms with an open field of stones before them, and a way from the field into the rooms,
/// through them, and out again.
struct FieldAndRooms {
  SnapshotPtr scene;
  std::vector<Camera> way;
};

FieldAndRooms fieldAndRooms() {
  scenes::Landscape both = scenes::closedRooms({.objects = 3'000, .frames = 24});
  const scenes::Landscape field = scenes::sparseTerrain({.objects = 500, .frames = 24});
  const auto first_mesh = static_cast<std::uint32_t>(both.model.meshes.size());
  for (const scenes::ModelMesh& mesh : field.model.meshes) both.model.addMesh(mesh);
  for (scenes::ModelNode node : field.model.nodes) {
    node.mesh += first_mesh;
    node.parent_from_node =
        scenes::composed(scenes::movedBy({-1200.0, -0.5, -400.0}), node.parent_from_node);
    both.model.addNode(node);
  }
  FieldAndRooms out{scenes::toSnapshot(both.model), {}};
  const auto add = [&](const scenes::CameraSpec& spec) {
    out.way.push_back(scenes::toCamera(spec).value());
  };
  for (scenes::CameraSpec spec : field.cameras) {
    auto& look = std::get<LookAt>(spec.pose);
    look.eye.x -= 1200.0;
    look.target.x -= 1200.0;
    add(spec);
  }
  for (const scenes::CameraSpec& spec : both.cameras) add(spec);
  for (std::size_t i = out.way.size(); i-- > 0;) out.way.push_back(out.way[i]);
  return out;
}

/// Returns the methods that answered.
std::set<std::string_view> missesNothing(const Method& automatic) {
  const FieldAndRooms place = fieldAndRooms();
  const auto oracle = Oracle::build(place.scene);
  const auto culler = automatic.prepare(place.scene);
  EXPECT_TRUE(oracle.ok() && culler.ok());
  OracleOptions options;
  options.lattice = 1;
  options.max_samples = 20'000;
  ViewState view;
  std::set<std::string_view> stages;
  for (std::size_t i = 0; i < place.way.size(); ++i) {
    const Answer answer = culler.value()->cull(place.way[i], {}, view);
    expectWellFormed(answer, *place.scene);
    const auto truth = oracle.value()->look(place.way[i], options);
    EXPECT_TRUE(truth.ok());
    EXPECT_TRUE(missing(truth.value().visible, answer.visible).empty())
        << "camera " << i << " by " << answer.made_by;
    stages.insert(answer.made_by);
  }
  return stages;
}

TEST(Auto, MissesNothingOnAWayFromOpenCountryThroughRoomsAndBack) {
  const auto stages = missesNothing(*findMethod("auto"));
  EXPECT_GT(stages.size(), 1U);
  EXPECT_TRUE(stages.contains("frustum")) << "open country costs what frustum culling costs";
}

TEST(Auto, SwitchesOnTheWayBetweenTwoMethods) {
  const Method* const stages[] = {findMethod("frustum"), findMethod("raster")};
  EXPECT_EQ(missesNothing(AutoMethod(stages)), (std::set<std::string_view>{"frustum", "raster"}));
}

TEST(Auto, GoesOnAsItWasAfterAnEditAndShowsIt) {
  const FieldAndRooms place = fieldAndRooms();
  SnapshotPtr scene = place.scene;
  auto prepared = findMethod("auto")->prepare(scene);
  ASSERT_TRUE(prepared.ok());
  std::unique_ptr<Culler> culler = std::move(prepared).value();
  ViewState view;
  for (const Camera& camera : place.way) {
    const Answer before = culler->cull(camera, {}, view);
    if (before.visible.empty()) continue;
    const ObjectId gone = before.visible.front();
    const auto edited = applyEdits(scene, std::vector<Edit>{HideObject{gone}});
    ASSERT_TRUE(edited.ok());
    scene = edited.value().snapshot;
    auto next = culler->edited(scene, edited.value().changed);
    ASSERT_TRUE(next.ok());
    culler = std::move(next).value();
    view.sceneEdited();
    const Answer after = culler->cull(camera, {}, view);
    EXPECT_FALSE(std::binary_search(after.visible.begin(), after.visible.end(), gone));
  }
}

TEST(Auto, AnswersTheSameSequenceOfCamerasWithTheSameBytes) {
  const FieldAndRooms place = fieldAndRooms();
  const auto first = findMethod("auto")->prepare(place.scene);
  const auto second = findMethod("auto")->prepare(place.scene);
  ASSERT_TRUE(first.ok() && second.ok());
  ViewState one, other;
  for (const Camera& camera : place.way) {
    EXPECT_EQ(first.value()->cull(camera, {}, one).visible,
              second.value()->cull(camera, {}, other).visible);
  }
}

}  // namespace
}  // namespace culld
