#include "tests/cases/families.h"

#include <array>
#include <limits>

#include "tests/cases/case.h"

namespace culld::cases {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr double kAll = kInfinite;  // every step is quick

Family viewed(std::string_view name, std::string_view quantity, std::string_view unit,
              std::vector<double> steps, Sight (*sight)(CaseBuilder&, double)) {
  return {name, quantity, unit, std::move(steps), kAll, nullptr, sight};
}

Family made(std::string_view name, std::string_view quantity, std::string_view unit,
            std::vector<double> steps, void (*make)(CaseBuilder&, double), double quick = kAll) {
  return {name, quantity, unit, std::move(steps), quick, make, nullptr};
}

std::vector<double> upTo(int last) {
  std::vector<double> steps;
  for (int i = 0; i <= last; ++i) steps.push_back(i);
  return steps;
}

const std::vector<double>& closer() {
  static const std::vector<double> steps{1e-1, 1e-3, 1e-5, 1e-7, 1e-9, 1e-12, 1e-16, 0};
  return steps;
}

std::vector<Family> cameraFamilies() {
  return {
      viewed("narrow_field_of_view", "field of view", "degrees",
             {60, 10, 1, 0.1, 0.01, 1e-3, 1e-4, 1e-6}, fieldOfView),
      viewed("wide_field_of_view", "field of view", "degrees",
             {60, 120, 170, 179, 179.9, 179.99, 179.9999}, fieldOfView),
      viewed("image_side", "side of a square image", "pixels",
             {512, 128, 16, 4, 2, 1, 4096, 16384, 65536}, imageSide),
      viewed("image_strip", "width of an image 2 pixels high", "pixels",
             {1, 16, 256, 4096, 16384, 65536}, imageWidth),
      viewed("far_over_near", "far / near", "", {1e1, 1e3, 1e6, 1e9, 1e12, 1e15, 1e18, kInfinite},
             farOverNear),
      viewed("far_over_near_by_matrix", "far / near", "",
             {1e1, 1e3, 1e6, 1e9, 1e12, 1e15, 1e18, kInfinite}, farOverNearMatrices),
      viewed("off_centre", "shift of the image", "half images", {0, 0.5, 1, 3, 10, 100, 1e4, 1e6},
             offCentre),
      viewed("oblique_near_plane", "tilt of the near plane", "", {0, 0.3, 1, 3, 10, 100, 1e4},
             obliqueNear),
      viewed("orthographic", "depth range / distance", "", {5, 50, 1e3, 1e5, 1e7, 1e9, 1e12, 1e15},
             orthographicDepth),
      viewed("mirrored_view", "sideways scale of the view", "", {1, 1e-3, 1e-6, -1e-6, -1e-3, -1},
             mirroredView),
      made("camera_not_a_number", "which number of the camera", "", upTo(31), badCameras),
  };
}

std::vector<Family> transformFamilies() {
  return {
      viewed("planet", "distance of everything from the world's origin", "m",
             {0, 1e3, 6.4e6, 1e9, 1e11, 1e12, 1e13, 1e14, 1e15, 1e18}, planet),
      viewed("distance", "distance of the wall from the eye", "m",
             {1, 1e3, 1e6, 1e9, 1e12, 1e15, 1e-3, 1e-6, 1e-9}, distance),
      viewed("scale_ratio", "wall / things", "", {1, 1e1, 1e2, 1e3, 1e5, 1e7, 1e9, 1e12},
             thingScale),
      viewed("coordinates_large", "size of the numbers in a mesh", "",
             {1, 1e5, 1e10, 1e20, 1e30, 1e38}, coordinateScale),
      viewed("coordinates_small", "size of the numbers in a mesh", "",
             {1, 1e-5, 1e-10, 1e-20, 1e-30, 1e-37, 1e-41}, coordinateScale),
      viewed("uniform_scale", "scale of every node", "",
             {1, 1e-2, 1e-6, 1e-12, 0, -1e-12, -1e-6, -1e-2, -1}, uniformScale),
      viewed("flat_scale", "scale of every node along y", "",
             {1, 1e-2, 1e-6, 1e-12, 0, -1e-12, -1e-6, -1e-2, -1}, flattened),
      viewed("shear", "shear of every node", "", {0, 0.5, 2, 10, 1e2, 1e4, 1e6, 1e9}, sheared),
      made("deep_hierarchy", "depth of the hierarchy", "nodes", {1, 10, 100, 1000, 10000},
           deepHierarchy),
      made("instances", "objects", "", {10, 100, 1000, 1e4, 1e5, 1e6}, manyInstances, 1e4),
      made("empty", "kind of emptiness", "", upTo(4), emptyScene),
  };
}

std::vector<Family> shapeFamilies() {
  return {
      viewed("slivers", "aspect of the triangles", "", {1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e9},
             slivers),
      viewed("t_junction", "offset of the odd vertex / edge", "",
             {0, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2}, tJunction),
      viewed("large_triangle", "triangle / image", "", {1, 1e1, 1e3, 1e6, 1e10, 1e20, 1e30, 3e38},
             largeTriangle),
      viewed("degenerate_triangles", "useless triangles in the wall", "",
             {0, 1, 4, 16, 100, 1000, 10000}, degenerate),
      made("pinhole", "side of the hole", "pixels", {10, 3, 1, 0.3, 0.1, 0.01, 1e-3, 1e-4, 1e-5},
           pinhole),
      made("needle_hole", "width of the hole", "pixels",
           {10, 3, 1, 0.3, 0.1, 0.01, 1e-3, 1e-4, 1e-5}, needleHole),
      made("not_a_number", "share of objects with a NaN", "", {0, 0.01, 0.1, 0.3, 1}, notANumber),
      made("infinite_numbers", "share of objects with an infinity", "", {0, 0.01, 0.1, 0.3, 1},
           infinite),
      made("nested_boxes", "gap / size", "", {1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 0},
           nestedBoxes),
      made("coplanar", "gap / distance", "",
           {1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-12, 0}, coplanar),
      made("triangles_in_a_pixel", "triangles", "", {1e2, 1e3, 1e4, 1e5, 1e6}, trianglesInAPixel,
           1e5),
  };
}

std::vector<Family> eyeFamilies() {
  return {
      made("eye_at_surface", "distance / size", "", closer(), eyeAtSurface),
      made("eye_at_edge", "distance / size", "", closer(), eyeAtEdge),
      made("eye_at_vertex", "distance / size", "", closer(), eyeAtVertex),
      made("eye_inside", "distance from the wall / size", "", closer(), eyeInside),
      made("box_through_near_plane", "share before the plane", "",
           {0, 1e-7, 1e-3, 0.3, 0.7, 0.999, 1 - 1e-7, 1}, boxThroughNear),
      made("wall_through_near_plane", "angle to the plane", "degrees",
           {0, 1e-6, 1e-3, 1, 10, 45, 80, 89, 89.999, 90}, wallThroughNear),
  };
}

}  // namespace

std::span<const Family> families() {
  static const std::vector<Family> all = [] {
    std::vector<Family> table = eyeFamilies();
    for (const auto& more : {cameraFamilies(), transformFamilies(), shapeFamilies()}) {
      table.insert(table.end(), more.begin(), more.end());
    }
    return table;
  }();
  return all;
}

const Family* findFamily(std::string_view name) {
  for (const Family& family : families()) {
    if (family.name == name) return &family;
  }
  return nullptr;
}

Case makeCase(const Family& family, double value, std::uint64_t seed) {
  CaseBuilder builder(seed);
  if (family.make != nullptr) {
    family.make(builder, value);
  } else {
    const Sight sight = family.sight(builder, value);
    addWall(builder, sight);
    addThings(builder, sight);
  }
  return builder.done();
}

std::optional<Probe> makeProbe(const Family& family, double value, std::uint64_t seed, double gap) {
  if (family.sight == nullptr) return std::nullopt;
  CaseBuilder builder(seed);
  const Sight sight = family.sight(builder, value);
  addWall(builder, sight);
  Sight thing = sight;
  thing.wall = Sight{}.wall;
  const ObjectId occludee = addThing(builder, thing, sight.distance_m * (1.0 + gap));
  const Case made = builder.done();
  return Probe{made.scene, made.cameras.front(), occludee, sight.distance_m};
}

}  // namespace culld::cases
