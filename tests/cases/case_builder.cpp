#include "tests/cases/case_builder.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <numbers>
#include <utility>

namespace culld::cases {
namespace {

using scenes::composed;
using scenes::Rows;

constexpr double kWallSize = 0.6;

glm::dvec3 turned(const Rows& m, const glm::dvec3& v) {
  return {m[0] * v.x + m[1] * v.y + m[2] * v.z, m[4] * v.x + m[5] * v.y + m[6] * v.z,
          m[8] * v.x + m[9] * v.y + m[10] * v.z};
}

glm::dvec3 shiftOf(const Rows& m) { return {m[3], m[7], m[11]}; }

Rows tilted(double angle_rad) {
  const double c = std::cos(angle_rad), s = std::sin(angle_rad);
  return {1, 0, 0, 0, 0, c, -s, 0, 0, s, c, 0};
}

scenes::Triangles scaled(scenes::Triangles shape, float by) {
  for (glm::vec3& p : shape.positions) p *= by;
  return shape;
}

}  // namespace

CaseBuilder::CaseBuilder(std::uint64_t seed) : seed_(seed), random_(seed + 1) {
  for (const scenes::Alpha alpha :
       {scenes::Alpha::kOpaque, scenes::Alpha::kMask, scenes::Alpha::kBlend}) {
    for (const bool both : {false, true}) {
      model_.addMaterial({"", {0.7F, 0.7F, 0.7F, 0.5F}, alpha, both});
    }
  }
  if (seed == 0) return;
  const double turn = random_.uniform(-std::numbers::pi, std::numbers::pi);
  const double tilt = random_.uniform(-1, 1);
  const glm::dvec3 shift{random_.uniform(-9, 9), random_.uniform(-9, 9), random_.uniform(-9, 9)};
  frame_ = composed(scenes::turnedAndMoved(turn, shift), tilted(tilt));
}

void CaseBuilder::moveTo(const glm::dvec3& offset) {
  frame_ = composed(scenes::movedBy(offset), frame_);
}

void CaseBuilder::made(scenes::Alpha alpha, bool double_sided) {
  material_ = static_cast<std::uint32_t>(alpha) * 2 + (double_sided ? 1 : 0);
}

ObjectId CaseBuilder::add(scenes::Triangles shape, const Rows& rows) {
  model_.addMesh({"", {{std::move(shape), material_}}});
  return again(rows);
}

ObjectId CaseBuilder::again(const Rows& rows) {
  const auto mesh = static_cast<std::uint32_t>(model_.meshes.size() - 1);
  return model_.addNode({scenes::kNone, mesh, composed(frame_, rows), ""});
}

LookAt CaseBuilder::placed(LookAt look) const {
  look.eye = turned(frame_, look.eye) + shiftOf(frame_);
  look.target = turned(frame_, look.target) + shiftOf(frame_);
  look.up = turned(frame_, look.up);
  return look;
}

void CaseBuilder::look(LookAt look, ImageSize image, std::string what) {
  case_.cameras.push_back({placed(look), image, std::move(what)});
}

void CaseBuilder::matrices(const glm::dmat4& view, const glm::dmat4& projection, ImageSize image,
                           std::string what) {
  // The inverse of a rigid map: its transpose, and the shift turned back.
  const Rows& f = frame_;
  glm::dmat4 back(1.0);
  for (int column = 0; column < 3; ++column) {
    for (int row = 0; row < 3; ++row) {
      back[column][row] = f[static_cast<std::size_t>(4 * column + row)];
    }
  }
  const glm::dvec3 shift = glm::dmat3(back) * shiftOf(f);
  back[3] = glm::dvec4(-shift, 1.0);
  case_.cameras.push_back(
      {scenes::ViewProjection{view * back, projection}, image, std::move(what)});
}

Case CaseBuilder::done() {
  case_.scene = scene_ ? scene_ : scenes::toSnapshot(model_);
  return std::move(case_);
}

Rows placed(const Sight& sight, double depth_m, const glm::dvec2& at, double size) {
  const double half = sight.half(depth_m);
  const double thick = std::min(size * half, 0.05 * depth_m);
  const glm::dvec2 middle = sight.slope * depth_m + at * half;
  const Rows rows =
      scenes::scaledAndMoved({size * half, size * half, thick}, {middle.x, middle.y, -depth_m});
  const glm::dvec3 back(1.0 / static_cast<double>(sight.mesh_scale));
  return composed(rows, composed(sight.oddity, scenes::scaledAndMoved(back, glm::dvec3(0.0))));
}

void addWall(CaseBuilder& builder, const Sight& sight) {
  builder.add(scaled(sight.wall, sight.mesh_scale),
              placed(sight, sight.distance_m, glm::dvec2(0.0), kWallSize));
}

ObjectId addThing(CaseBuilder& builder, const Sight& sight, double depth_m) {
  return builder.add(scaled(sight.wall, sight.mesh_scale),
                     placed(sight, depth_m, glm::dvec2(0.0), 0.2));
}

void addThings(CaseBuilder& builder, const Sight& sight) {
  scenes::Random& random = builder.random();
  const double d = sight.distance_m;
  builder.add(scaled(scenes::box(glm::vec3(-1), glm::vec3(1)), sight.mesh_scale),
              placed(sight, 40.0 * d, glm::dvec2(0.0), 0.3 * sight.thing_scale));
  const auto thing = [&](double depth_m, const glm::dvec2& at) {
    const double size = random.uniform(0.05, 0.15) * sight.thing_scale;
    builder.again(placed(sight, depth_m, at, size));
  };
  for (int i = 0; i < 8; ++i) {  // hidden, if the wall is whole
    const double depth = d * random.uniform(1.1, 4.0);
    const double x = random.uniform(-0.4, 0.4);
    thing(depth, {x, random.uniform(-0.4, 0.4)});
  }
  for (const double side : {-1.0, 1.0}) {
    const double behind = d * random.uniform(1.1, 2.0), before = d * random.uniform(0.3, 0.8);
    thing(behind, {side * kWallSize, random.uniform(-0.3, 0.3)});
    thing(before, {side * 0.3, random.uniform(-0.3, 0.3)});
    thing(behind, {side * 0.85, random.uniform(-0.3, 0.3)});
  }
}

void addClutter(CaseBuilder& builder, std::uint32_t count, double radius_m) {
  scenes::Random& random = builder.random();
  for (std::uint32_t i = 0; i < count; ++i) {
    const bool flat = random.chance(0.3);
    builder.made(scenes::Alpha::kOpaque, flat || random.chance(0.3));
    const double size = radius_m * random.uniform(0.02, 0.15);
    const double turn = random.uniform(-3, 3);
    const glm::dvec3 at{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
    const Rows rows = composed(scenes::turnedAndMoved(turn, at * radius_m),
                               scenes::scaledAndMoved(glm::dvec3(size), glm::dvec3(0.0)));
    builder.add(flat ? scenes::quad({-2, -2, 0}, {4, 0, 0}, {0, 4, 0})
                     : scenes::box(glm::vec3(-1), glm::vec3(1)),
                rows);
  }
  builder.made(scenes::Alpha::kOpaque, false);
}

}  // namespace culld::cases
