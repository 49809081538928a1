#include "tests/scenes/known_scenes.h"

#include <cmath>
#include <numbers>
#include <utility>

#include "tests/scenes/shapes.h"

namespace culld::scenes {
namespace {

constexpr std::uint32_t kWidth = 1280, kHeight = 720;
constexpr double kYfov = std::numbers::pi / 3;

/// Metres per pixel at a distance from the usual camera.
float pixelAt(double distance_m) {
  return static_cast<float>(2.0 * distance_m * std::tan(kYfov / 2) / kHeight);
}

/// A scene seen from (0, 0, 5) along -z, put together object by object.
class Stage {
 public:
  explicit Stage(std::string name) {
    scene_.name = std::move(name);
    camera(LookAt{});
    for (const Alpha alpha : {Alpha::kOpaque, Alpha::kMask, Alpha::kBlend}) {
      for (const bool double_sided : {false, true}) {
        scene_.model.addMaterial({"", {0.7F, 0.7F, 0.7F, 0.5F}, alpha, double_sided});
      }
    }
  }

  Stage& camera(LookAt look) {
    if (look.eye == glm::dvec3(0.0)) look.eye = {0, 0, 5};
    look.yfov_rad = kYfov;
    scene_.camera = {look, {kWidth, kHeight}, "hand-made"};
    return *this;
  }
  Stage& camera(const ViewProjection& matrices) {
    scene_.camera = {matrices, {kWidth, kHeight}, "hand-made"};
    return *this;
  }

  Stage& sees(Triangles t, Rows rows = kIdentity) { return add(scene_.must_be_visible, t, rows); }
  Stage& hides(Triangles t, Rows rows = kIdentity) { return add(scene_.can_be_hidden, t, rows); }
  Stage& leavesOutside(Triangles t) { return add(scene_.outside, t, kIdentity); }
  /// There, but the scene says nothing about its own visibility.
  Stage& has(Triangles t, Rows rows = kIdentity) {
    std::vector<ObjectId> nowhere;
    return add(nowhere, t, rows);
  }

  /// Of the objects that follow.
  Stage& made(Alpha alpha, bool double_sided) {
    material_ = static_cast<std::uint32_t>(alpha) * 2 + (double_sided ? 1 : 0);
    return *this;
  }

  KnownScene done() {
    scene_.snapshot = toSnapshot(scene_.model);
    return std::move(scene_);
  }

 private:
  Stage& add(std::vector<ObjectId>& list, Triangles& triangles, const Rows& rows) {
    const std::uint32_t mesh = scene_.model.addMesh({"", {{std::move(triangles), material_}}});
    list.push_back(scene_.model.addNode({kNone, mesh, rows, ""}));
    return *this;
  }

  KnownScene scene_;
  std::uint32_t material_ = 0;
};

/// A square that faces +z.
Triangles wall(float z, float half = 2.0F, float x = 0.0F) {
  return quad({x - half, -half, z}, {2 * half, 0, 0}, {0, 2 * half, 0});
}
/// A square that faces -z.
Triangles wallTurned(float z) { return quad({-2, -2, z}, {0, 4, 0}, {4, 0, 0}); }

Triangles cube(float x, float y, float z, float half = 0.5F) {
  return box(glm::vec3(x, y, z) - half, glm::vec3(x, y, z) + half);
}

void addWalls(std::vector<KnownScene>& all) {
  all.push_back(Stage("wall_hides_box").sees(wall(0)).hides(cube(0, 0, -2)).done());
  all.push_back(
      Stage("wall_hides_box_one_centimetre_behind").sees(wall(0)).hides(cube(0, 0, -0.51F)).done());
  all.push_back(Stage("box_peeks_out_behind_wall").sees(wall(0)).sees(cube(2.8F, 0, -2)).done());
  // The right rim of the wall, seen at 5 m, falls on 2 * 6.5 / 5 = 2.6 m at the box's front, and
  // one hundredth of a pixel there is 1e-4 m.
  all.push_back(Stage("box_peeks_out_by_a_hundredth_of_a_pixel")
                    .sees(wall(0))
                    .sees(box({1.6F, -0.5F, -2.5F}, {2.6F + pixelAt(6.5) / 100, 0.5F, -1.5F}))
                    .done());
  all.push_back(Stage("box_that_touches_the_back_of_the_wall_is_a_tie")
                    .sees(wall(0))
                    .sees(cube(0, 0, -0.5F))
                    .done());
  all.push_back(Stage("box_through_the_wall").sees(wall(0)).sees(cube(0, 0, 0)).done());
  all.push_back(Stage("box_before_the_wall").sees(wall(0)).sees(cube(0, 0, 2)).done());
  all.push_back(
      Stage("wall_of_a_thousand_triangles_hides_box")
          .sees([] {
            Random random(1);  // lies in xz with its front up; turned to face +z
            Triangles sheet;
            append(sheet, bumpySheet(23, 0.0, random), {4, 0, 0, -2, 0, 0, -4, 2, 0, 1, 0, 0});
            return sheet;
          }())
          .hides(cube(0.3F, 0.2F, -2))
          .done());
  Stage row("row_of_overlapping_pillars_hides_long_box");
  for (int i = -4; i <= 4; ++i) {
    row.sees(box({static_cast<float>(i) * 0.5F - 0.3F, -2, -0.1F * static_cast<float>(i & 1)},
                 {static_cast<float>(i) * 0.5F + 0.3F, 2, 0.3F}));
  }
  all.push_back(row.hides(box({-2, -0.4F, -3}, {2, 0.4F, -2})).done());
  all.push_back(Stage("two_walls_with_a_common_edge_hide_box")
                    .sees(quad({-2, -2, 0}, {2, 0, 0}, {0, 4, 0}))
                    .sees(quad({0, -2, 0}, {2, 0, 0}, {0, 4, 0}))
                    .hides(cube(0, 0, -2))
                    .done());
  all.push_back(Stage("two_walls_with_a_gap_of_a_hundredth_of_a_pixel")
                    .sees(quad({-2, -2, 0}, {2, 0, 0}, {0, 4, 0}))
                    .sees(quad({pixelAt(5) / 100, -2, 0}, {2, 0, 0}, {0, 4, 0}))
                    .sees(cube(0, 0, -2))
                    .done());
}

void addHoles(std::vector<KnownScene>& all) {
  const Rows twice = scaledAndMoved({2, 2, 1}, {0, 0, 0});
  all.push_back(Stage("hole_in_the_wall_shows_box")
                    .sees(wallWithHole({0, 0}, {0.15F, 0.15F}), twice)
                    .sees(cube(0, 0, -2))
                    .done());
  all.push_back(Stage("hole_elsewhere_does_not_show_box")
                    .sees(wallWithHole({0.7F, 0.7F}, {0.1F, 0.1F}), twice)
                    .hides(cube(-0.5F, -0.5F, -2))
                    .done());
  const float needle = pixelAt(5) * 0.05F / 4;  // half the side, before the wall is scaled by two
  all.push_back(Stage("needle_hole_of_a_twentieth_of_a_pixel_keeps_box")
                    .sees(wallWithHole({0.0617F, 0.0283F}, {needle, needle}), twice)
                    .sees(cube(0, 0, -2))
                    .done());
  all.push_back(Stage("pane_in_the_hole_shows_box")
                    .sees(wallWithHole({0, 0}, {0.15F, 0.15F}), twice)
                    .made(Alpha::kBlend, false)
                    .sees(wall(0, 0.3F))
                    .made(Alpha::kOpaque, false)
                    .sees(cube(0, 0, -2))
                    .done());
}

void addSidesAndMaterials(std::vector<KnownScene>& all) {
  all.push_back(Stage("single_sided_wall_from_behind_does_not_hide")
                    .has(wallTurned(0))
                    .sees(cube(0, 0, -2))
                    .done());
  all.push_back(Stage("double_sided_wall_from_behind_hides")
                    .made(Alpha::kOpaque, true)
                    .sees(wallTurned(0))
                    .made(Alpha::kOpaque, false)
                    .hides(cube(0, 0, -2))
                    .done());
  all.push_back(Stage("mask_wall_does_not_hide")
                    .made(Alpha::kMask, false)
                    .sees(wall(0))
                    .made(Alpha::kOpaque, false)
                    .sees(cube(0, 0, -2))
                    .done());
  all.push_back(Stage("blend_wall_does_not_hide")
                    .made(Alpha::kBlend, true)
                    .sees(wall(0))
                    .made(Alpha::kOpaque, false)
                    .sees(cube(0, 0, -2))
                    .done());
  all.push_back(Stage("wall_mirrored_sideways_still_faces_the_eye")
                    .sees(wall(0), scaledAndMoved({-1, 1, 1}, {0, 0, 0}))
                    .hides(cube(0, 0, -2))
                    .done());
  all.push_back(Stage("wall_mirrored_in_depth_turns_its_back")
                    .has(wall(0), scaledAndMoved({1, 1, -1}, {0, 0, 0}))
                    .sees(cube(0, 0, -2))
                    .done());
  all.push_back(Stage("box_flattened_to_nothing_is_a_wall_seen_from_the_front")
                    .sees(cube(0, 0, 0), scaledAndMoved({4, 4, 0}, {0, 0, 0}))
                    .has(cube(0, 0, -2))
                    .done());
}

void addInsides(std::vector<KnownScene>& all) {
  all.push_back(Stage("inner_box_hides_in_outer_box")
                    .sees(cube(0, 0, 0, 1))
                    .hides(cube(0, 0, 0, 0.8F))
                    .done());
  all.push_back(Stage("eye_inside_a_single_sided_box_sees_through_it")
                    .has(cube(0, 0, 5, 1))
                    .sees(cube(0, 0, 0))
                    .done());
  all.push_back(Stage("eye_inside_a_double_sided_box_sees_only_it")
                    .made(Alpha::kOpaque, true)
                    .sees(cube(0, 0, 5, 1))
                    .made(Alpha::kOpaque, false)
                    .hides(cube(0, 0, 0))
                    .done());
  all.push_back(Stage("thing_in_the_same_room_as_the_eye")
                    .made(Alpha::kOpaque, true)
                    .sees(cube(0, 0, 5, 3))
                    .made(Alpha::kOpaque, false)
                    .sees(cube(0, 0, 3.5F))
                    .hides(cube(0, 0, 0))
                    .done());
}

void addFrustum(std::vector<KnownScene>& all) {
  // At z = 0 the frustum is 2 * 5 * tan(30 deg) = 5.77 m high and 10.26 m wide.
  all.push_back(Stage("box_half_out_of_the_frustum")
                    .sees(box({4.5F, -0.5F, -0.5F}, {6, 0.5F, 0.5F}))
                    .leavesOutside(cube(-9, 0, 0))
                    .done());
  all.push_back(Stage("box_behind_the_eye_is_outside")
                    .sees(cube(0, 0, 0))
                    .leavesOutside(cube(0, 0, 8))
                    .done());
  LookAt near_and_far;
  near_and_far.znear_m = 1;
  near_and_far.zfar_m = 10;
  all.push_back(Stage("beyond_the_far_plane_and_before_the_near_plane")
                    .camera(near_and_far)
                    .sees(cube(1, 0, 0))
                    .leavesOutside(cube(-1, 0, -8))
                    .leavesOutside(cube(0.3F, 0, 4.5F, 0.05F))
                    .done());
  all.push_back(
      Stage("thousand_kilometres_away_without_a_far_plane").sees(cube(0, 0, -1e6F, 1e5F)).done());
  glm::dmat4 view(1.0), projection(1.0);
  view[3] = {0, 0, -5, 1};
  projection[0][0] = 1 / 5.0;
  projection[1][1] = 1 / 3.0;
  projection[2][2] = -2 / 10.0;
  projection[3][2] = -1;  // near 0, far 10
  all.push_back(Stage("orthographic_wall_hides_box_of_its_own_size")
                    .camera(ViewProjection{view, projection})
                    .sees(wall(0))
                    .hides(cube(0, 0, -2, 1.9F))
                    .sees(cube(3, 0, -2))
                    .leavesOutside(cube(7, 0, -2))
                    .done());
  all.push_back(Stage("nothing_at_all").done());
}

void addFarFromTheOrigin(std::vector<KnownScene>& all) {
  const glm::dvec3 there{6.4e6, -1.7e6, 3.3e6};
  LookAt look;
  look.eye = there + glm::dvec3(0, 0, 0.05);
  look.target = there;
  look.znear_m = 0.001;
  const Rows small = scaledAndMoved(glm::dvec3(0.01), there);
  all.push_back(Stage("centimetre_wall_hides_box_on_a_planet")
                    .camera(look)
                    .sees(wall(0), small)
                    .hides(cube(0, 0, -2), small)
                    .done());
  all.push_back(Stage("centimetre_box_beside_the_wall_on_a_planet")
                    .camera(look)
                    .sees(wall(0), small)
                    .sees(cube(3.5F, 0, -2), small)
                    .done());
}

}  // namespace

std::vector<KnownScene> knownScenes() {
  std::vector<KnownScene> all;
  addWalls(all);
  addHoles(all);
  addSidesAndMaterials(all);
  addInsides(all);
  addFrustum(all);
  addFarFromTheOrigin(all);
  return all;
}

}  // namespace culld::scenes
