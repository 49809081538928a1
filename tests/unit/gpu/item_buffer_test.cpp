// Method `item-buffer`: what it finds at samples is what rays find there, its parts bring what they
// promise, and it says so when it cannot.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include "culling/culler.h"
#include "culling/gpu/item_pass.h"
#include "culling/oracle/oracle.h"
#include "culling/scene/edit.h"
#include "culling/scene/scene_builder.h"
#include "tests/scenes/random_scene.h"
#include "tests/scenes/shapes.h"
#include "tests/unit/gpu/opened_backend.h"

namespace culld {
namespace {

using scenes::Rows;
using scenes::Triangles;

constexpr Demand kSampled{.guarantee = Guarantee::kSampled};

Mesh meshOf(const Triangles& t, bool blocks = true, bool double_sided = false) {
  return makeMesh({{t.positions, t.indices, blocks, double_sided}});
}

/// The square of that half side around the z axis, facing +z.
Triangles square(float half) {
  return scenes::quad({-half, -half, 0}, {2 * half, 0, 0}, {0, 2 * half, 0});
}

Camera cameraAt(const glm::dvec3& eye, ImageSize image = {64, 64}) {
  LookAt look;
  look.eye = eye;
  look.target = eye - glm::dvec3(0, 0, 1);
  look.aspect = static_cast<double>(image.width_px) / image.height_px;
  return cameraFromLookAt(look, image).value();
}

class ItemBuffer : public gpu::WithBackend {
 protected:
  std::unique_ptr<Culler> culler(const SnapshotPtr& scene, const std::string& settings = "") {
    const auto method = configured_.find("item-buffer" + settings);
    EXPECT_TRUE(method.ok());
    return method.value()->prepare(scene).value();
  }
  Answer look(const SnapshotPtr& scene, const Camera& camera, const std::string& settings = "",
              const Demand& demand = kSampled) {
    ViewState view;
    return culler(scene, settings)->cull(camera, demand, view);
  }
  static std::vector<ObjectId> inFrustum(const SnapshotPtr& scene, const Camera& camera) {
    ViewState view;
    return findMethod("frustum")->prepare(scene).value()->cull(camera, {}, view).visible;
  }

  ConfiguredMethods configured_{allMethods()};
};

/// What rays through the samples show. `sure`: samples whose neighbours all show the same object,
/// which no rounding of an edge can change; `most`: those with a neighbour that shows it.
struct Painted {
  std::map<ObjectId, std::uint32_t> sure, most;
};

Painted paintedBy(const Oracle& oracle, Camera camera, std::uint32_t lattice) {
  camera.width_px *= lattice;
  camera.height_px *= lattice;
  const auto image = oracle.paint(camera).value();
  const auto width = static_cast<int>(camera.width_px), height = static_cast<int>(camera.height_px);
  Painted out;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      std::vector<ObjectId> near;
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          const int ax = std::clamp(x + dx, 0, width - 1), ay = std::clamp(y + dy, 0, height - 1);
          near.push_back(image[static_cast<std::size_t>(ay * width + ax)].object);
        }
      }
      std::sort(near.begin(), near.end());
      near.erase(std::unique(near.begin(), near.end()), near.end());
      if (near.size() == 1) ++out.sure[near[0]];
      for (const ObjectId id : near) ++out.most[id];
    }
  }
  out.sure.erase(kNoObject);
  out.most.erase(kNoObject);
  return out;
}

SnapshotPtr ballsAndBoxes(std::uint64_t seed) {
  scenes::Random random(seed);
  SceneBuilder builder;
  const MeshId meshes[] = {builder.addMesh(meshOf(scenes::ball(6, 0.0, random))),
                           builder.addMesh(meshOf(scenes::box({-1, -1, -1}, {1, 0.5F, 2}))),
                           builder.addMesh(meshOf(scenes::torus(12, 6, 1.5F, 0.3F)))};
  for (std::uint32_t i = 0; i < 40; ++i) {
    const glm::dvec3 at(8.0 * random.unit() - 4.0, 8.0 * random.unit() - 4.0,
                        -4.0 - 20.0 * random.unit());
    Rows rows = scenes::turnedAndMoved(6.0 * random.unit(), at);
    if (i % 4 == 0) rows = scenes::composed(rows, scenes::scaledAndMoved({-1, 0.5, 1}, {}));
    builder.addInstance(meshes[i % 3], rows, i);
  }
  return builder.finish();
}

TEST_F(ItemBuffer, CountsTheSamplesThatRaysCount) {
  std::size_t found = 0, samples = 0;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const SnapshotPtr scene = ballsAndBoxes(seed);
    const auto oracle = Oracle::build(scene).value();
    const Camera camera = cameraAt({0, 0, 0}, {97, 61});
    for (const std::uint32_t lattice : {1U, 2U, 4U}) {
      SCOPED_TRACE("seed " + std::to_string(seed) + " lattice " + std::to_string(lattice));
      const Painted painted = paintedBy(*oracle, camera, lattice);
      const Answer answer = look(scene, camera, ":ties=off:lattice=" + std::to_string(lattice));
      ASSERT_EQ(answer.pixels.size(), answer.visible.size());
      EXPECT_EQ(answer.note,
                "item-buffer: sampled(97, 61, " + std::to_string(lattice * lattice) + ")");
      EXPECT_EQ(answer.guarantee, Guarantee::kSampled);
      std::map<ObjectId, std::uint32_t> counted;
      for (std::size_t i = 0; i < answer.visible.size(); ++i) {
        const float count = answer.pixels[i] * static_cast<float>(lattice * lattice);
        counted[answer.visible[i]] = static_cast<std::uint32_t>(count);
        samples += static_cast<std::size_t>(count);
      }
      for (const auto& [id, sure] : painted.sure) EXPECT_GE(counted[id], sure) << id;
      for (const auto& [id, count] : counted) {
        const auto most = painted.most.find(id);
        EXPECT_LE(count, most == painted.most.end() ? 0U : most->second) << id;
      }
      found += answer.visible.size();
    }
  }
  EXPECT_GT(found, 60U);
  EXPECT_GT(samples, 20'000U);
}

/// Anything at any place and scale, by every sort of camera: what a ray sees with a pixel's margin
/// is answered, and what no ray sees mostly is not.
TEST_F(ItemBuffer, LacksNothingThatFillsAPixelAndItsNeighbours) {
  std::size_t sure = 0, answered = 0, frustum = 0;
  for (std::uint64_t seed = 1; seed <= 24; ++seed) {
    const SnapshotPtr scene = scenes::randomScene(seed);
    const auto oracle = Oracle::build(scene).value();
    const auto method = culler(scene);
    for (scenes::CameraSpec spec : scenes::randomCameras(seed, *scene, 3)) {
      SCOPED_TRACE("seed " + std::to_string(seed) + " camera " + spec.what);
      spec.image = {std::clamp(spec.image.width_px, 1U, 120U),
                    std::clamp(spec.image.height_px, 1U, 68U)};
      const Camera camera = scenes::toCamera(spec).value();
      ViewState view;
      const Answer answer = method->cull(camera, kSampled, view);
      EXPECT_EQ(answer.guarantee, Guarantee::kSampled) << answer.note;
      const auto all = inFrustum(scene, camera);
      EXPECT_TRUE(
          std::includes(all.begin(), all.end(), answer.visible.begin(), answer.visible.end()));
      for (const auto& [id, count] : paintedBy(*oracle, camera, 1).sure) {
        EXPECT_TRUE(std::binary_search(answer.visible.begin(), answer.visible.end(), id))
            << "object " << id << " shows at " << count << " samples and all around them";
        ++sure;
      }
      answered += answer.visible.size();
      frustum += all.size();
    }
  }
  std::printf("%zu surely visible, %zu answered, %zu in the frustum\n", sure, answered, frustum);
  EXPECT_GT(sure, 100U);
  EXPECT_LT(answered, frustum - frustum / 3);
}

/// Near ones first: pane 0 before pane 1 before the wall 2 before pane 3 and the square 4.
SnapshotPtr panes(const glm::dvec3& offset = {}, double scale = 1.0) {
  SceneBuilder builder;
  const MeshId pane = builder.addMesh(meshOf(square(1.0F), false, true));
  const MeshId wall = builder.addMesh(meshOf(square(4.0F)));
  const MeshId small = builder.addMesh(meshOf(square(1.0F)));
  const MeshId in_order[] = {pane, pane, wall, pane, small};
  for (std::uint32_t i = 0; i < 5; ++i) {
    const glm::dvec3 at = offset + scale * glm::dvec3(0, 0, -4.0 - i);
    builder.addInstance(in_order[i], scenes::scaledAndMoved(glm::dvec3(scale), at), i);
  }
  return builder.finish();
}

TEST_F(ItemBuffer, SeesThroughWhatDoesNotBlock) {
  const Answer answer = look(panes(), cameraAt({0, 0, 0}));
  EXPECT_EQ(answer.visible, (std::vector<ObjectId>{0, 1, 2}));
  EXPECT_GT(answer.pixels[0], answer.pixels[1]);  // seen wholly, and larger as it is nearer
  EXPECT_EQ(answer.stats.occluded, 2U);
}

TEST_F(ItemBuffer, SeesSingleSidedSurfacesFromTheirFrontOnly) {
  const Answer answer = look(panes(), [] {
    LookAt look;
    look.eye = {0, 0, -20};
    look.target = {0, 0, 0};
    look.aspect = 1.0;
    return cameraFromLookAt(look, {64, 64}).value();
  }());
  EXPECT_EQ(answer.visible, (std::vector<ObjectId>{0, 1, 3}));  // wall and square are not there
}

TEST_F(ItemBuffer, IsExactFarFromTheWorldsOrigin) {
  const Answer here = look(panes({}, 0.01), cameraAt({0, 0, 0.2}));
  const glm::dvec3 far{6.4e6, -3.2e6, 1.1e6};
  const Answer there = look(panes(far, 0.01), cameraAt(far + glm::dvec3(0, 0, 0.2)));
  EXPECT_EQ(there.visible, (std::vector<ObjectId>{0, 1, 2}));
  EXPECT_EQ(there.visible, here.visible);
  EXPECT_EQ(there.pixels, here.pixels);
}

/// A wall that reaches a million images beside the image, and a square whose vertices lie a
/// thousand kilometres from their mesh's origin: floats of their sums say nothing about
/// centimetres.
TEST_F(ItemBuffer, IsExactNearTheEyeInLargeMeshes) {
  SceneBuilder builder;
  const float large = 1e6F;
  builder.addInstance(builder.addMesh(meshOf(square(2e6F))), scenes::movedBy({0, 0, -2}), 0);
  const MeshId away = builder.addMesh(meshOf(scenes::quad({large, 0, 0}, {1, 0, 0}, {0, 1, 0})));
  builder.addInstance(away, scenes::movedBy({-large - 0.03, -0.03, -1}), 1);
  const Answer answer = look(builder.finish(), cameraAt({0, 0, 0}, {400, 400}));
  ASSERT_EQ(answer.visible, (std::vector<ObjectId>{0, 1}));
  // From 0.03 left of the middle of an image that is 2 tan(1/2) wide.
  const double side = 400.0 * (0.5 + 0.03 / (2.0 * std::tan(0.5)));
  EXPECT_NEAR(answer.pixels[1], side * side, 2.0 * side);
  EXPECT_EQ(answer.pixels[0] + answer.pixels[1], 400.0F * 400.0F);
}

TEST_F(ItemBuffer, TiesHideNothingUnlessTurnedOff) {
  SceneBuilder builder;
  const MeshId mesh = builder.addMesh(meshOf(square(1.0F)));
  for (std::uint32_t i = 0; i < 3; ++i) builder.addInstance(mesh, scenes::movedBy({0, 0, -4}), i);
  builder.addInstance(mesh, scenes::movedBy({0, 0, -4.1}), 3);
  const SnapshotPtr scene = builder.finish();
  const Camera camera = cameraAt({0, 0, 0});
  EXPECT_EQ(look(scene, camera).visible, (std::vector<ObjectId>{0, 1, 2}));
  EXPECT_EQ(look(scene, camera, ":ties=off").visible, (std::vector<ObjectId>{0}));
}

TEST_F(ItemBuffer, MoreSamplesFindSmallerObjects) {
  SceneBuilder builder;
  const MeshId mesh = builder.addMesh(meshOf(square(0.01F)));
  for (std::uint32_t i = 0; i < 400; ++i) {
    builder.addInstance(mesh, scenes::movedBy({0.1093 * (i % 20) - 1, 0.1071 * (i / 20) - 1, -4}),
                        i);
  }
  const SnapshotPtr scene = builder.finish();
  std::size_t found = 0;
  for (const char* lattice : {":lattice=1", ":lattice=2", ":lattice=4"}) {
    const std::size_t finer = look(scene, cameraAt({0, 0, 0}), lattice).visible.size();
    EXPECT_GT(finer, found + 20) << lattice;
    found = finer;
  }
  EXPECT_LE(found, 400U);
}

TEST_F(ItemBuffer, KeepsWhatItCannotDraw) {
  SceneBuilder builder;
  Mesh lines = meshOf(square(0.001F));  // no sample meets it
  lines.points_and_lines = 1;
  const MeshId thin = builder.addMesh(std::move(lines));
  const MeshId wall = builder.addMesh(meshOf(square(4.0F)));
  Mesh skinned = meshOf(square(1.0F));
  skinned.unbounded = true;
  const MeshId unbounded = builder.addMesh(std::move(skinned));
  builder.addInstance(wall, scenes::movedBy({0, 0, -4}), 0);
  builder.addInstance(thin, scenes::movedBy({0.4, 0.3, -5}), 1);
  builder.addInstance(unbounded, scenes::movedBy({0, 0, -5}), 2);
  builder.addInstance(wall, scenes::scaledAndMoved(glm::dvec3(1e16), {0, 0, -5}), 3);
  builder.addInstance(wall, scenes::movedBy({0, 0, -5}), 4);
  builder.addInstance(builder.addMesh(meshOf(square(1e9F))), scenes::movedBy({0, 0, -2}), 5);
  const Answer answer = look(builder.finish(), cameraAt({0, 0, 0}));
  EXPECT_EQ(answer.visible, (std::vector<ObjectId>{0, 1, 2, 3, 5}));
  EXPECT_EQ(answer.guarantee, Guarantee::kSampled);
  EXPECT_EQ(answer.pixels[1] + answer.pixels[2] + answer.pixels[3], 0.0F);
}

TEST_F(ItemBuffer, AnswersTheFrustumWhereSamplesProveNothing) {
  const SnapshotPtr scene = panes();
  const Camera camera = cameraAt({0, 0, 0});
  Camera moving = camera;
  moving.motion.radius_m = 0.1;
  const struct {
    Camera camera;
    Demand demand;
    std::string why;
  } cases[] = {
      {camera, {}, "conservative answers are demanded"},
      {camera, {.guarantee = Guarantee::kHole, .hole_px = 4.0F}, "hole answers are demanded"},
      {moving, kSampled, "the camera may move"},
      {cameraAt({0, 0, 0}, {16385, 1}), kSampled, "the image is too large"},
      {cameraAt({0, 0, 0}, {8192, 8192}), kSampled, "the image is too large"}};
  for (const auto& c : cases) {
    const Answer answer = look(scene, c.camera, "", c.demand);
    EXPECT_EQ(answer.visible, inFrustum(scene, c.camera)) << c.why;
    EXPECT_EQ(answer.guarantee, Guarantee::kConservative) << c.why;
    EXPECT_TRUE(answer.note.find(c.why) != std::string::npos) << answer.note;
    EXPECT_TRUE(answer.pixels.empty());
  }
  Demand approximate;
  approximate.guarantee = Guarantee::kApproximate;
  EXPECT_EQ(look(scene, camera, "", approximate).guarantee, Guarantee::kSampled);
}

TEST_F(ItemBuffer, StopsAtTheWorkDemanded) {
  Demand little = kSampled;
  little.work = std::chrono::nanoseconds(1);
  const SnapshotPtr scene = panes();
  const Answer answer = look(scene, cameraAt({0, 0, 0}), "", little);
  EXPECT_TRUE(answer.out_of_budget);
  EXPECT_EQ(answer.visible, inFrustum(scene, cameraAt({0, 0, 0})));
  EXPECT_EQ(answer.guarantee, Guarantee::kConservative);
  little.work = std::chrono::seconds(1);
  const Answer whole = look(scene, cameraAt({0, 0, 0}), "", little);
  EXPECT_FALSE(whole.out_of_budget);
  EXPECT_EQ(whole.visible.size(), 3U);
}

TEST_F(ItemBuffer, UploadsMeshesOnceAndNotAgainAfterAnEdit) {
  const auto uploads = [] {
    auto lease = gpu::backend()->acquire();
    const std::uint64_t made = lease.value().data<gpu::ItemPass>().uploads();
    EXPECT_TRUE(lease.value().check().ok());
    return made;
  };
  const SnapshotPtr scene = panes();
  auto asked = culler(scene);
  ViewState view;
  const Camera camera = cameraAt({0, 0, 0});
  asked->cull(camera, kSampled, view);
  const std::uint64_t before = uploads();
  const Edit edits[] = {MoveObject{2, scenes::movedBy({50, 0, -6})}};
  const auto edited = applyEdits(scene, edits).value();
  asked = asked->edited(edited.snapshot, edited.changed).value();
  EXPECT_EQ(asked->cull(camera, kSampled, view).visible, (std::vector<ObjectId>{0, 1, 3, 4}));
  EXPECT_EQ(uploads(), before);
}

TEST_F(ItemBuffer, LeavesTheContextAsOthersExpectIt) {
  const SnapshotPtr scene = scenes::randomScene(5);
  const auto other = findMethod("gpu-depth-pyramid")->prepare(scene).value();
  for (scenes::CameraSpec spec : scenes::randomCameras(5, *scene, 4)) {
    spec.image = {160, 90};
    const Camera camera = scenes::toCamera(spec).value();
    ViewState before, between, after;
    const Answer first = other->cull(camera, {}, before);
    look(scene, camera);
    EXPECT_EQ(other->cull(camera, {}, after).visible, first.visible);
  }
}

}  // namespace
}  // namespace culld
