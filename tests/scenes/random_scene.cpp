#include "tests/scenes/random_scene.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "tests/scenes/random.h"
#include "tests/scenes/shapes.h"

namespace culld::scenes {
namespace {

/// A shape in about [-1,1]^3 and how it is scaled; most are placed within a cube of side 20.
class SceneMaker {
 public:
  SceneMaker(std::uint64_t seed, const RandomSceneOptions& options)
      : random_(seed), options_(options) {
    if (options.any_scale) scale_ = std::pow(10.0, random_.uniform(-3, 4));
    if (random_.chance(0.5)) {
      const double reach = options.max_offset_m * std::pow(10.0, random_.uniform(-6, 0));
      for (int i = 0; i < 3; ++i) offset_[i] = random_.uniform(-reach, reach);
    }
    for (const Alpha alpha : {Alpha::kOpaque, Alpha::kMask, Alpha::kBlend}) {
      for (const bool both : {false, true}) {
        model_.addMaterial({"", {0.6F, 0.6F, 0.7F, 0.5F}, alpha, both});
      }
    }
  }

  Model make() {
    if (random_.chance(0.4)) addGround();
    while (model_.nodes.size() < options_.objects) addSomething();
    return std::move(model_);
  }

 private:
  void addSomething() {
    switch (random_.below(12)) {
      case 0:
      case 1:
        return addAnywhere(box(glm::vec3(-1), glm::vec3(1)));
      case 2:
        return addWall();
      case 3:
        return addAnywhere(convexBody());
      case 4:
        return addAnywhere(concaveBody());
      case 5:
        return addSheet();
      case 6:
        return addTJunction();
      case 7:
        return addAbuttingWalls();
      case 8:
        return addSlivers();
      case 9:
        return addCoplanarCopies();
      case 10:
        return addNestedBoxes();
      default:
        return addNeedleWall();
    }
  }

  void addSheet() {
    const std::uint32_t side = 1 + random_.below(6);
    const double roughness = random_.unit();
    addAnywhere(bumpySheet(side, roughness, random_));
  }

  double size() { return std::pow(10.0, random_.uniform(-1.5, 0.7)); }
  glm::dvec3 place() {
    return {random_.uniform(-10, 10), random_.uniform(-3, 6), random_.uniform(-10, 10)};
  }

  std::uint32_t material() {
    const bool both = random_.chance(0.3);
    std::uint32_t alpha = 0;
    if (options_.see_through && random_.chance(0.15)) alpha = 1 + random_.below(2);
    return 2 * alpha + (both ? 1 : 0);
  }

  /// One object; the whole scene's scale and offset come last, in the node's own numbers.
  void add(Triangles shape, const Rows& rows) { addParts({{std::move(shape), material()}}, rows); }

  void addParts(std::vector<Part> parts, const Rows& rows) {
    const std::uint32_t mesh = model_.addMesh({"", std::move(parts)});
    place(mesh, rows);
  }

  void place(std::uint32_t mesh, const Rows& rows) {
    const Rows world = composed(scaledAndMoved(glm::dvec3(scale_), offset_), rows);
    model_.addNode({kNone, mesh, world, ""});
  }

  Rows turnedSomewhere() {
    const glm::dvec3 at = place();
    return turnedAndMoved(random_.uniform(0, 2 * std::numbers::pi), at);
  }

  /// Upright, with the given half sides at most.
  Rows standing(double half_x, double half_y, double half_z) {
    const glm::dvec3 halves{random_.uniform(1, half_x), random_.uniform(1, half_y), half_z};
    return composed(turnedSomewhere(), scaledAndMoved(halves, glm::dvec3(0.0)));
  }

  Rows anyTransform() {
    Rows rows = turnedSomewhere();
    glm::dvec3 stretch(size());
    if (random_.chance(0.5)) stretch = {size(), size(), size()};
    rows = composed(rows, scaledAndMoved(stretch, glm::dvec3(0.0)));
    if (random_.chance(0.3)) rows = composed(rows, tilt());
    if (options_.odd_transforms && random_.chance(0.25)) rows = composed(rows, oddity());
    return rows;
  }

  Rows tilt() {
    const double a = random_.uniform(-1, 1), c = std::cos(a), s = std::sin(a);
    return {1, 0, 0, 0, 0, c, -s, 0, 0, s, c, 0};
  }

  Rows oddity() {
    switch (random_.below(4)) {
      case 0:
        return scaledAndMoved({-1, 1, 1}, glm::dvec3(0.0));
      case 1:
        return scaledAndMoved({-1, -1, -1}, glm::dvec3(0.0));
      case 2:
        return {1, random_.uniform(-2, 2), 0, 0, 0, 1, random_.uniform(-2, 2), 0, 0, 0, 1, 0};
      default:
        return scaledAndMoved({1, random_.chance(0.3) ? 0.0 : 1e-7, 1}, glm::dvec3(0.0));
    }
  }

  /// Often several instances of the mesh.
  void addAnywhere(Triangles shape) {
    add(std::move(shape), anyTransform());
    const auto mesh = static_cast<std::uint32_t>(model_.meshes.size() - 1);
    while (random_.chance(0.4)) place(mesh, anyTransform());
  }

  Triangles convexBody() {
    if (random_.chance(0.5)) return ball(3 + random_.below(6), 0.0, random_);
    return prism(regularFootprint(3 + random_.below(9), 1.0F), -1.0F, 1.0F);
  }

  Triangles anyTorus() {
    const std::uint32_t around = 5 + random_.below(8), across = 3 + random_.below(5);
    return torus(around, across, 0.8F, 0.25F);
  }

  Triangles concaveBody() {
    switch (random_.below(3)) {
      case 0:
        return ball(4 + random_.below(6), 0.4, random_);
      case 1:
        return anyTorus();
      default: {
        const std::vector<glm::vec2> corner{{-1, -1}, {-1, 1}, {0, 1}, {0, 0}, {1, 0}, {1, -1}};
        return prism(corner, -1.0F, 1.0F, 3);
      }
    }
  }

  void addGround() {
    const float half = random_.chance(0.5) ? 15.0F : 1e5F;
    add(quad({-half, 0, -half}, {0, 0, 2 * half}, {2 * half, 0, 0}),
        movedBy({0, random_.uniform(-4, -3), 0}));
  }

  /// Large, thin or without any thickness: what mostly hides things.
  void addWall() {
    const bool thick = random_.chance(0.5);
    const Rows rows = standing(8, 6, 0.1);
    add(thick ? box(glm::vec3(-1), glm::vec3(1)) : quad({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}), rows);
  }

  /// A long edge that meets two short ones: rounding opens a crack at the middle vertex.
  void addTJunction() {
    const auto at = static_cast<float>(random_.uniform(-0.9, 0.9));
    Triangles sheet = quad({-1, -1, 0}, {1, 0, 0.5F}, {0, 2, 0});
    append(sheet, quad({0, -1, 0.5F}, {1, 0, -0.3F}, {0, 1 + at, 0}));
    append(sheet, quad({0, at, 0.5F}, {1, 0, -0.3F}, {0, 1 - at, 0}));
    add(std::move(sheet), anyTransform());
  }

  /// Several objects edge to edge, some with a tiny gap or overlap.
  void addAbuttingWalls() {
    const Rows rows = standing(3, 5, 1);
    const std::uint32_t m = material();
    const std::uint32_t count = 2 + random_.below(4);
    const double slack = random_.chance(0.5) ? 0.0 : random_.uniform(-1e-6, 1e-6);
    const std::uint32_t mesh = model_.addMesh({"", {{quad({0, -1, 0}, {1, 0, 0}, {0, 2, 0}), m}}});
    for (std::uint32_t i = 0; i < count; ++i) {
      place(mesh, composed(rows, movedBy({i * (1.0 + slack), 0, 0})));
    }
  }

  void addSlivers() {
    Triangles slivers;
    for (int i = 0; i < 8; ++i) {
      const auto y = static_cast<float>(random_.uniform(-1, 1));
      const auto thin = static_cast<float>(std::pow(10.0, random_.uniform(-6, -1)));
      slivers.positions.emplace_back(-1.0F, y, 0.0F);
      slivers.positions.emplace_back(1.0F, y, 0.0F);
      slivers.positions.emplace_back(static_cast<float>(random_.uniform(-1, 1)), y + thin, 0.0F);
      for (std::uint32_t k = 3; k > 0; --k) {
        slivers.indices.push_back(static_cast<std::uint32_t>(slivers.positions.size()) - k);
      }
    }
    add(std::move(slivers), anyTransform());
  }

  /// The same square again: exactly, a hair before or behind, turned over.
  void addCoplanarCopies() {
    const Rows rows = anyTransform();
    const Triangles square = quad({-1, -1, 0}, {2, 0, 0}, {0, 2, 0});
    add(square, rows);
    add(square, rows);
    add(square, composed(rows, movedBy({0, 0, random_.uniform(-1e-7, 1e-7)})));
    add(quad({-1, -1, 0}, {0, 2, 0}, {2, 0, 0}), rows);
    Triangles folded = square;  // both windings in one mesh
    append(folded, quad({-1, -1, 0}, {0, 2, 0}, {2, 0, 0}));
    add(std::move(folded), anyTransform());
  }

  void addNestedBoxes() {
    Rows rows = anyTransform();
    const std::uint32_t mesh = model_.addMesh({"", {{box(glm::vec3(-1), glm::vec3(1)), 0}}});
    const double shrink = random_.chance(0.5) ? 1e-6 : 0.2;
    for (int i = 0; i < 3; ++i) {
      place(mesh, rows);
      rows = composed(rows, scaledAndMoved(glm::dvec3(1.0 - shrink), glm::dvec3(0.0)));
    }
  }

  /// A wall with a hole too small for any pixel, something behind it; sometimes glazed.
  void addNeedleWall() {
    const Rows rows = standing(5, 5, 1);
    const auto hole = static_cast<float>(std::pow(10.0, random_.uniform(-6, -0.5)));
    const glm::vec2 centre(glm::dvec2{random_.uniform(-0.5, 0.5), random_.uniform(-0.5, 0.5)});
    std::vector<Part> parts{{wallWithHole(centre, {hole, hole}), random_.chance(0.5) ? 1U : 0U}};
    if (options_.see_through && random_.chance(0.3)) {
      parts.push_back(
          {quad({centre.x - hole, centre.y - hole, 0}, {2 * hole, 0, 0}, {0, 2 * hole, 0}), 5});
    }
    addParts(std::move(parts), rows);
    add(box(glm::vec3(-0.5F), glm::vec3(0.5F)),
        composed(rows, movedBy({0, 0, random_.chance(0.5) ? -0.5 : -2.0})));
  }

  Random random_;
  const RandomSceneOptions options_;
  Model model_;
  double scale_ = 1.0;
  glm::dvec3 offset_{0.0};
};

}  // namespace

Model randomModel(std::uint64_t seed, const RandomSceneOptions& options) {
  return SceneMaker(seed, options).make();
}

SnapshotPtr randomScene(std::uint64_t seed, const RandomSceneOptions& options) {
  return toSnapshot(randomModel(seed, options));
}

}  // namespace culld::scenes
