// The settings of `frustum`: each against the standard, and held exactly to what it may leave out.
#include <gtest/gtest.h>

#include <algorithm>

#include "culling/methods/frustum.h"
#include "culling/spatial/prepared_boxes.h"
#include "tests/unit/methods/random_cameras.h"
#include "tests/unit/spatial/box_scene.h"
#include "tests/unit/spatial/exact.h"

namespace culld::testing {
namespace {

std::unique_ptr<Culler> withSettings(const std::string& settings, const SnapshotPtr& scene) {
  const Method* const table[] = {&frustumMethod()};
  ConfiguredMethods methods(table);
  return methods.find("frustum" + settings).value()->prepare(scene, steadyClock()).value();
}

struct Work {
  std::size_t answered = 0;
  std::uint64_t plane_tests = 0;
};

/// A camera that turns a little from frame to frame.
Work turningView(const Culler& culler, bool remembers = true) {
  Work work;
  ViewState view;
  for (int n = 0; n < 60; ++n) {
    LookAt look;
    look.target = {std::sin(0.02 * n), 0.1, -std::cos(0.02 * n)};
    look.zfar_m = 120.0;
    if (!remembers) view = ViewState();
    const Answer answer = culler.cull(cameraFromLookAt(look, {}).value(), {}, view);
    work.answered += answer.visible.size();
    work.plane_tests += answer.stats.plane_tests;
  }
  return work;
}

SnapshotPtr manyBoxes() { return boxScene(randomBoxes(20'000, {0, 0, 0}, 100.0, 21)); }

TEST(FrustumSettings, MaskingAsksFewerPlanesForTheSameAnswer) {
  const SnapshotPtr scene = manyBoxes();
  const Work masked = turningView(*withSettings("", scene));
  const Work all = turningView(*withSettings(":masking=off", scene));
  EXPECT_EQ(masked.answered, all.answered);
  EXPECT_LT(masked.plane_tests, all.plane_tests);
}

TEST(FrustumSettings, OctantsAskFewerPlanesForTheSameAnswer) {
  const SnapshotPtr scene = manyBoxes();
  const Work plain = turningView(*withSettings(":masking=off", scene));
  const Work octants = turningView(*withSettings(":masking=off:octants=on", scene));
  EXPECT_EQ(octants.answered, plain.answered);
  EXPECT_LT(octants.plane_tests, plain.plane_tests);
}

TEST(FrustumSettings, CoherenceAsksFewerPlanesWithAMemoryThanWithout) {
  const SnapshotPtr scene = manyBoxes();
  const auto culler = withSettings(":coherence=on", scene);
  const Work kept = turningView(*culler), dropped = turningView(*culler, false);
  EXPECT_EQ(kept.answered, dropped.answered);
  EXPECT_EQ(kept.answered, turningView(*withSettings("", scene)).answered);
  EXPECT_LT(kept.plane_tests, dropped.plane_tests);
}

/// Long boxes, turned in all ways.
SnapshotPtr turnedBoxes(int count, const glm::dvec3& centre = {0, 0, 0}, double extent = 60.0,
                        std::uint64_t seed = 31) {
  std::mt19937_64 random(seed);
  std::vector<std::array<double, 12>> boxes;
  for (int i = 0; i < count; ++i) {
    const double a = uniform(random, 0, 6.28), b = uniform(random, 0, 6.28);
    const double ca = std::cos(a), sa = std::sin(a), cb = std::cos(b), sb = std::sin(b);
    const glm::dvec3 size = extent / 60.0 * glm::dvec3(uniform(random, 5, 20), 0.5, 0.5);
    const auto at = [&](double middle) { return middle + extent * uniform(random, -1, 1); };
    boxes.push_back({ca * size.x, -sa * cb * size.y, sa * sb * size.z, at(centre.x), sa * size.x,
                     ca * cb * size.y, -ca * sb * size.z, at(centre.y), 0, sb * size.y, cb * size.z,
                     at(centre.z)});
  }
  return boxScene(boxes);
}

TEST(FrustumSettings, OrientedBoxesLeaveOutMoreAndSpheresComeFirst) {
  const SnapshotPtr scene = turnedBoxes(4'000);
  const Work plain = turningView(*withSettings("", scene));
  const Work oriented = turningView(*withSettings(":oriented=on", scene));
  EXPECT_LT(20 * oriented.answered, 19 * plain.answered);
  const Work no_sphere = turningView(*withSettings(":oriented=on:sphere=off", scene));
  EXPECT_EQ(no_sphere.answered, oriented.answered);
  EXPECT_NE(no_sphere.plane_tests, oriented.plane_tests);
}

/// The largest value of a plane over a mesh where it stands.
Quad largestOf(const QuadPlane& plane, const Camera& camera, const SceneSnapshot& scene,
               const Instance& instance) {
  Quad largest = 0;
  bool first = true;
  for (const glm::vec3& corner : scene.mesh(instance.mesh).positions) {
    const glm::dvec3 p(corner);
    Quad value = plane.d;
    for (std::size_t i = 0; i < 3; ++i) {
      const double* row = &instance.world_from_mesh[4 * i];
      value += plane.n[i] * (static_cast<Quad>(row[0]) * p.x + static_cast<Quad>(row[1]) * p.y +
                             static_cast<Quad>(row[2]) * p.z + static_cast<Quad>(row[3]) -
                             static_cast<Quad>(camera.origin_world[static_cast<int>(i)]));
    }
    largest = first || value > largest ? value : largest;
    first = false;
  }
  return largest;
}

/// Is each object that is not answered wholly outside a plane of the camera?
::testing::AssertionResult leavesOutOnlyWhatIsOutside(const Answer& answer, const Camera& camera,
                                                      const SceneSnapshot& scene) {
  const std::array<QuadPlane, 6> planes = exactPlanes(camera);
  for (ObjectId id = 0; id < scene.objectCount(); ++id) {
    if (std::binary_search(answer.visible.begin(), answer.visible.end(), id)) continue;
    const bool out = std::any_of(planes.begin(), planes.end(), [&](const QuadPlane& plane) {
      return largestOf(plane, camera, scene, scene.instance(id)) < 0;
    });
    if (!out) return ::testing::AssertionFailure() << "object " << id;
  }
  return ::testing::AssertionSuccess();
}

constexpr const char* kAllOriented = ":oriented=on:octants=on:coherence=on";

TEST(FrustumSettings, OrientedBoxesKeepAllThatReachesIntoTheFrustum) {
  const SnapshotPtr scene = turnedBoxes(1'000);
  for (const char* const settings : {kAllOriented, ":oriented=on:sphere=off"}) {
    const auto culler = withSettings(settings, scene);
    std::mt19937_64 random(41);
    ViewState view;
    for (int n = 0; n < 30; ++n) {
      const Camera camera = n % 2 == 0 ? perspectiveCamera(random, {0, 0, 0}, 60.0)
                                       : matrixCamera(random, {0, 0, 0}, 60.0);
      const Answer answer = culler->cull(camera, {}, view);
      ASSERT_TRUE(leavesOutOnlyWhatIsOutside(answer, camera, *scene)) << "camera " << n;
    }
  }
}

/// Boxes that touch a plane of the camera, as nearly as doubles can place them.
SnapshotPtr touchingBoxes(const Camera& camera, const glm::dvec3& centre, double extent,
                          std::mt19937_64& random) {
  const SnapshotPtr loose = turnedBoxes(60, centre, extent, random());
  const std::array<QuadPlane, 6> planes = exactPlanes(camera);
  std::vector<std::array<double, 12>> boxes;
  for (ObjectId id = 0; id < loose->objectCount(); ++id) {
    Instance instance = loose->instance(id);
    const QuadPlane& plane = planes[random() % 4];
    const Quad length = plane.n[0] * plane.n[0] + plane.n[1] * plane.n[1] + plane.n[2] * plane.n[2];
    for (int again = 0; again < 3; ++again) {
      const Quad off = largestOf(plane, camera, *loose, instance) / length;
      for (std::size_t i = 0; i < 3; ++i) {
        instance.world_from_mesh[4 * i + 3] -= static_cast<double>(off * plane.n[i]);
      }
    }
    boxes.push_back(instance.world_from_mesh);
  }
  return boxScene(boxes);
}

TEST(FrustumSettings, OrientedBoxesThatTouchAPlaneAreKept) {
  struct World {
    glm::dvec3 centre;
    double extent;
  };
  std::mt19937_64 random(43);
  for (const World& world : {World{{0, 0, 0}, 1.0}, World{{1e7, 1e7, -1e7}, 100.0},
                             World{{-6.4e6, 0, 0}, 0.5}, World{{0, 0, 0}, 1e12}}) {
    for (int n = 0; n < 20; ++n) {
      const Camera camera = n % 2 == 0 ? perspectiveCamera(random, world.centre, world.extent)
                                       : matrixCamera(random, world.centre, world.extent);
      const SnapshotPtr scene = touchingBoxes(camera, world.centre, world.extent, random);
      ViewState view;
      const Answer answer = withSettings(kAllOriented, scene)->cull(camera, {}, view);
      ASSERT_TRUE(leavesOutOnlyWhatIsOutside(answer, camera, *scene))
          << "extent " << world.extent << " camera " << n;
    }
  }
}

glm::dvec3 anyDirection(std::mt19937_64& random) {
  for (;;) {
    const glm::dvec3 v(uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1));
    const double length = glm::length(v);
    if (length > 0.01 && length <= 1.0) return v / length;
  }
}

/// The camera from another pose: turned about its eye, then moved.
Camera fromPose(const Camera& camera, const glm::dvec3& axis, double angle, const glm::dvec3& by) {
  Camera pose = camera;
  pose.origin_world += by;
  for (glm::dvec4* row : {&pose.x_row, &pose.y_row, &pose.z_row, &pose.w_row, &pose.near_cut_row,
                          &pose.far_cut_row}) {
    const glm::dvec3 v(*row);
    *row = glm::dvec4(v * std::cos(angle) + glm::cross(axis, v) * std::sin(angle) +
                          axis * (glm::dot(axis, v) * (1.0 - std::cos(angle))),
                      row->w);
  }
  return pose;
}

TEST(FrustumSettings, OrientedBoxesKeepWhatAnyPoseWithinTheMotionBoundSees) {
  std::mt19937_64 random(47);
  const SnapshotPtr scene = turnedBoxes(500);
  const auto culler = withSettings(kAllOriented, scene);
  for (int n = 0; n < 30; ++n) {
    const Camera still = perspectiveCamera(random, {0, 0, 0}, 60.0);
    Camera bound = still;
    if (n % 3 != 0) bound.motion.radius_m = uniform(random, 0, 10);
    if (n % 3 != 1) bound.motion.angle_rad = uniform(random, 0, 0.5);
    ViewState view;
    const Answer all = culler->cull(bound, {}, view);
    for (int k = 0; k < 8; ++k) {
      const Camera pose = fromPose(still, anyDirection(random), 0.999 * bound.motion.angle_rad,
                                   0.999 * bound.motion.radius_m * anyDirection(random));
      ASSERT_TRUE(leavesOutOnlyWhatIsOutside(all, pose, *scene)) << "camera " << n;
    }
  }
}

/// Boxes, and some objects without a bound.
SnapshotPtr boxesAndSkins(std::size_t count) {
  SceneBuilder builder;
  const MeshId cube = builder.addMesh(unitCube());
  Mesh skinned = unitCube();
  skinned.unbounded = true;
  const MeshId loose = builder.addMesh(std::move(skinned));
  std::uint32_t node = 0;
  for (const auto& box : randomBoxes(count, {0, 0, 0}, 50.0, 52)) {
    builder.addInstance(node % 10 == 7 ? loose : cube, box, node);
    ++node;
  }
  return builder.finish();
}

/// An edit of one object that is still there.
std::vector<Edit> oneEdit(const SceneSnapshot& scene, std::mt19937_64& random, bool adds) {
  ObjectId id = 0;
  do id = static_cast<ObjectId>(random() % scene.objectCount());
  while (scene.instance(id).removed);
  auto t = scene.instance(id).world_from_mesh;
  t[3] += uniform(random, -20, 20);
  if (adds) return {AddInstance{id, t}};
  const Edit choices[] = {MoveObject{id, t}, MoveObject{id, t}, HideObject{id}, ShowObject{id},
                          RemoveObject{id}};
  return {choices[random() % std::size(choices)]};
}

TEST(FrustumSettings, WhatWaitsBesideTheTreeIsAnsweredWhereItIs) {
  std::mt19937_64 random(51);
  SnapshotPtr scene = boxesAndSkins(100);
  std::unique_ptr<Culler> late = withSettings(":late=64", scene), now = withSettings("", scene);
  ViewState a, b;
  std::size_t waited = 0;
  for (int n = 0; n < 150; ++n) {
    const auto edited = applyEdits(scene, oneEdit(*scene, random, n % 20 == 0));
    ASSERT_TRUE(edited.ok());
    scene = edited.value().snapshot;
    late = std::move(late->edited(scene, edited.value().changed)).value();
    now = std::move(now->edited(scene, edited.value().changed)).value();
    const Camera camera = perspectiveCamera(random, {0, 0, 0}, 50.0);
    const Answer x = late->cull(camera, {}, a), y = now->cull(camera, {}, b);
    ASSERT_EQ(x.visible, y.visible) << n;
    ASSERT_EQ(x.stats.outside, y.stats.outside);
    waited += dynamic_cast<const HoldsBoxes&>(*late).boxes() == nullptr ? 1U : 0U;
  }
  EXPECT_GT(waited, 100U);
}

}  // namespace
}  // namespace culld::testing
