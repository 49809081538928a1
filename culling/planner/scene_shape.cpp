#include "culling/planner/scene_shape.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <utility>
#include <vector>

#include "culling/planner/sample_views.h"
#include "culling/planner/sampled_objects.h"
#include "culling/planner/scene_profile.h"

namespace culld {
namespace {

constexpr std::size_t kBoxes = 2048, kViews = 16, kVerticals = 256;

struct SampledBox {
  Box box;
  bool blocks;
};

bool blocks(const Mesh& mesh) {
  return !mesh.unbounded && std::any_of(mesh.surfaces.begin(), mesh.surfaces.end(),
                                        [](const Surface& surface) { return surface.blocks; });
}

std::vector<SampledBox> sampledBoxes(const SceneSnapshot& scene) {
  std::vector<SampledBox> boxes;
  for (const ObjectId id : sampledObjects(scene, kBoxes)) {
    const Instance& instance = scene.instance(id);
    boxes.push_back({instance.bounds_world, blocks(scene.mesh(instance.mesh))});
  }
  return boxes;
}

/// Where the ray enters the box; negative if it does not, or begins inside.
double entry(const Box& box, const glm::dvec3& from, const glm::dvec3& towards) {
  double enters = -1.0, leaves = HUGE_VAL;
  for (int axis = 0; axis < 3; ++axis) {
    const double a = (box.min[axis] - from[axis]) / towards[axis];
    const double b = (box.max[axis] - from[axis]) / towards[axis];
    enters = std::max(enters, std::min(a, b));
    leaves = std::min(leaves, std::max(a, b));
  }
  return enters <= leaves ? enters : -1.0;
}

/// Spread all around; none lies in a plane of two axes, so nothing divides by zero.
std::vector<glm::dvec3> directions() {
  std::vector<glm::dvec3> all;
  for (const double x : {-1.0, 0.01, 1.0}) {
    for (const double y : {-0.5, 0.02, 0.5}) {
      for (const double z : {-1.0, 0.03, 1.0}) all.emplace_back(x, y, z);
    }
  }
  return all;
}

struct RaySums {
  double rays = 0.0, met = 0.0, hidden_behind = 0.0, ended = 0.0;
};

void castFrom(const glm::dvec3& eye, const std::vector<SampledBox>& boxes, RaySums& sums) {
  static const std::vector<glm::dvec3> kDirections = directions();
  for (const glm::dvec3& direction : kDirections) {
    double first_blocker = HUGE_VAL, last = -1.0;
    for (const SampledBox& sampled : boxes) {
      const double at = entry(sampled.box, eye, direction);
      if (at < 0.0) continue;
      sums.met += 1.0;
      last = std::max(last, at);
      if (sampled.blocks) first_blocker = std::min(first_blocker, at);
    }
    sums.rays += 1.0;
    if (first_blocker < last) sums.hidden_behind += 1.0;
    if (first_blocker < HUGE_VAL) sums.ended += 1.0;
  }
}

/// Do all boxes over the middle of `at` overlap or touch, up to a tenth of a typical box?
bool standsInOneHeap(const Box& at, const std::vector<SampledBox>& boxes, double typical) {
  const glm::dvec3 middle = 0.5 * at.min + 0.5 * at.max;
  std::vector<std::pair<double, double>> heights;
  for (const SampledBox& sampled : boxes) {
    const Box& box = sampled.box;
    if (box.min.x <= middle.x && middle.x <= box.max.x && box.min.z <= middle.z &&
        middle.z <= box.max.z) {
      heights.emplace_back(box.min.y, box.max.y);
    }
  }
  std::sort(heights.begin(), heights.end());
  double top = heights.front().second;
  for (const auto& [low, high] : heights) {
    if (low > top + 0.1 * typical) return false;
    top = std::max(top, high);
  }
  return true;
}

void measureSizes(const std::vector<SampledBox>& boxes, SceneShape& shape) {
  std::vector<double> sizes;
  sizes.reserve(boxes.size());
  for (const SampledBox& sampled : boxes) {
    sizes.push_back(glm::length(sampled.box.max - sampled.box.min));
  }
  std::sort(sizes.begin(), sizes.end());
  shape.small_m = sizes[sizes.size() / 10];
  shape.median_m = sizes[sizes.size() / 2];
  shape.large_m = sizes[sizes.size() * 9 / 10];
}

}  // namespace

SceneShape shapeOf(const SceneSnapshot& scene) {
  SceneShape shape;
  const SceneProfile profile = profileScene(scene);
  const std::vector<SampledBox> boxes = sampledBoxes(scene);
  if (boxes.empty()) return shape;
  const auto objects = static_cast<double>(profile.objects);
  shape.triangles_per_object = static_cast<double>(profile.triangles) / objects;
  measureSizes(boxes, shape);
  RaySums all, inside;
  for (const SampledView& view : sampleViews(scene, kViews)) {
    castFrom(view.camera.origin_world, boxes, all);
    if (!view.outside) castFrom(view.camera.origin_world, boxes, inside);
  }
  if (all.rays > 0.0) {
    const double per_sampled = objects / static_cast<double>(boxes.size());
    shape.depth_complexity = all.met / all.rays * per_sampled;
    shape.occluder_potential = all.hidden_behind / all.rays;
    if (inside.rays > 0.0) shape.closedness = inside.ended / inside.rays;
  }
  const std::size_t step = boxes.size() / kVerticals + 1;
  double upright = 0.0, asked = 0.0;
  for (std::size_t i = 0; i < boxes.size(); i += step, asked += 1.0) {
    if (standsInOneHeap(boxes[i].box, boxes, shape.median_m)) upright += 1.0;
  }
  shape.upright = upright / asked;
  return shape;
}

}  // namespace culld
