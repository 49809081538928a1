// Families whose places and transforms are pushed: distance, scale, shear, depth and number of
// nodes.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "culling/scene/edit.h"
#include "culling/scene/gltf_loader.h"
#include "tests/cases/families.h"

namespace culld::cases {
namespace {

using scenes::composed;
using scenes::Rows;

/// A camera for the usual sight at any distance; `target_m` ahead is what it is turned to.
Sight sightAt(CaseBuilder& builder, double distance_m, double target_m) {
  Sight sight;
  sight.distance_m = distance_m;
  LookAt look;
  look.yfov_rad = 2.0 * std::atan(sight.tan_half);
  look.znear_m = distance_m / 1000.0;
  look.target = {0.0, 0.0, -target_m};
  builder.look(look);
  return sight;
}

}  // namespace

Sight planet(CaseBuilder& builder, double offset_m) {
  builder.moveTo(glm::dvec3(0.71, -0.43, 0.55) * offset_m);
  // Things of millimetres to centimetres, and a target far enough for its direction to be right.
  return sightAt(builder, 0.05, 0.05 + 1e-6 * offset_m);
}

Sight distance(CaseBuilder& builder, double distance_m) {
  return sightAt(builder, distance_m, distance_m);
}

Sight thingScale(CaseBuilder& builder, double ratio) {
  Sight sight = sightAt(builder, 10.0, 10.0);
  sight.thing_scale = 1.0 / ratio;
  return sight;
}

Sight coordinateScale(CaseBuilder& builder, double scale) {
  Sight sight = sightAt(builder, 10.0, 10.0);
  sight.mesh_scale = static_cast<float>(scale);
  return sight;
}

Sight uniformScale(CaseBuilder& builder, double scale) {
  Sight sight = sightAt(builder, 10.0, 10.0);
  sight.oddity = scenes::scaledAndMoved(glm::dvec3(scale), glm::dvec3(0.0));
  return sight;
}

Sight flattened(CaseBuilder& builder, double scale) {
  Sight sight = sightAt(builder, 10.0, 10.0);
  sight.oddity = scenes::scaledAndMoved({1.0, scale, 1.0}, glm::dvec3(0.0));
  return sight;
}

Sight sheared(CaseBuilder& builder, double factor) {
  Sight sight = sightAt(builder, 10.0, 10.0);
  sight.oddity = {1, factor, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  return sight;
}

/// A chain of nodes, each turned a little against its parent, through the loader: things on its
/// last nodes, seen through the transform of the very last.
void deepHierarchy(CaseBuilder& builder, double depth) {
  scenes::Random& random = builder.random();
  const auto count = static_cast<std::uint32_t>(depth);
  const double turn = 20.0 / depth, step = 30.0 / depth;
  const double shrink = builder.seed() % 2 == 0 ? 1.0 : 0.9995;
  scenes::Model& model = builder.model();
  const std::uint32_t box =
      model.addMesh({"", {{scenes::box(glm::vec3(-0.5F), glm::vec3(0.5F)), 0}}});
  const std::uint32_t wall =
      model.addMesh({"", {{scenes::quad({-4, -4, 0}, {8, 0, 0}, {0, 8, 0}), 1}}});
  Rows last = scenes::kIdentity;
  std::uint32_t parent = scenes::kNone;
  for (std::uint32_t level = 0; level < count; ++level) {
    const Rows rows = composed(scenes::turnedAndMoved(turn, {step, step / 7, 0}),
                               scenes::scaledAndMoved(glm::dvec3(shrink), glm::dvec3(0.0)));
    const bool thing = level + 1 == count || random.chance(std::min(1.0, 60.0 / depth));
    parent = model.addNode({parent, thing ? box : scenes::kNone, rows, ""});
    last = composed(last, rows);
  }
  model.addNode({parent, wall, scenes::movedBy({0, 0, -1}), ""});
  for (int i = 0; i < 12; ++i) {
    const glm::dvec3 at{random.uniform(-6, 6), random.uniform(-6, 6), random.uniform(-8, -2)};
    model.addNode({parent, box, scenes::movedBy(at), ""});
  }
  auto loaded = loadGltfBytes(scenes::toGlb(model), "deep");
  if (!loaded.ok()) {  // a generator's mistake, not a case
    std::fprintf(stderr, "%s\n", loaded.error().message.c_str());
    std::abort();
  }
  builder.use(loaded.value());
  // By the last node's own frame: its axes are the rows' columns, its size the scale.
  const auto at = [&](const glm::dvec3& p) {
    return glm::dvec3(last[0] * p.x + last[1] * p.y + last[2] * p.z + last[3],
                      last[4] * p.x + last[5] * p.y + last[6] * p.z + last[7],
                      last[8] * p.x + last[9] * p.y + last[10] * p.z + last[11]);
  };
  LookAt look;
  look.eye = at({0.2, 0.1, 10.0});
  look.target = at({0.0, 0.0, 0.0});
  look.znear_m = glm::length(look.target - look.eye) / 1000.0;
  builder.absolute(look, "before the last node");
  look.eye = at({40.0, 30.0, 40.0});
  builder.absolute(look, "aside of the chain");
}

/// Boxes on a square, walls among them, all of two meshes.
void manyInstances(CaseBuilder& builder, double count) {
  scenes::Random& random = builder.random();
  const double side = 3.0 * std::sqrt(count);
  const auto somewhere = [&] {
    const double x = random.uniform(-side, side);
    return glm::dvec3(x, 0.0, random.uniform(-2.0 * side, -2.0));
  };
  const auto total = static_cast<std::uint32_t>(count);
  builder.made(scenes::Alpha::kOpaque, false);
  builder.add(scenes::box({-0.5F, 0, -0.5F}, {0.5F, 1, 0.5F}), scenes::movedBy({0, 0, -10}));
  for (std::uint32_t i = 0; i < total; ++i) {
    const bool tower = i % 50 == 0;
    const glm::dvec3 size = tower ? glm::dvec3(6, 12, 6) : glm::dvec3(random.uniform(0.3, 1.5));
    builder.again(scenes::scaledAndMoved(size, somewhere()));
  }
  LookAt look;
  look.eye = {0.3, 1.7, 0.1};
  look.target = {0.1, 1.6, -10.0};
  builder.look(look, kCaseImage, "street");
  look.eye = {0.0, side, side};
  look.target = {0.0, 0.0, -side};
  builder.look(look, kCaseImage, "above");
}

void emptyScene(CaseBuilder& builder, double kind) {
  builder.look({});
  scenes::Triangles dots;  // triangles without any area: dropped
  dots.positions = {{0, 0, -5}, {1, 0, -5}};
  dots.indices = {0, 1, 1, 0, 0, 0};
  switch (static_cast<int>(kind)) {
    case 0:
      return;  // nothing at all
    case 1:
      builder.model().addNode({});  // a group
      return;
    case 2:
      builder.add(dots);
      return;
    case 3:
      builder.add(dots);
      builder.add(scenes::box({-1, -1, -9}, {1, 1, -7}));
      return;
    default:
      break;
  }
  addClutter(builder, 20, 10.0);  // everything hidden by edits
  const SnapshotPtr full = scenes::toSnapshot(builder.model());
  std::vector<Edit> edits;
  for (ObjectId id = 0; id < full->objectCount(); ++id) {
    edits.push_back(id % 2 == 0 ? Edit(HideObject{id}) : Edit(RemoveObject{id}));
  }
  auto edited = applyEdits(full, edits);
  if (!edited.ok()) std::abort();
  builder.use(edited.value().snapshot);
}

}  // namespace culld::cases
