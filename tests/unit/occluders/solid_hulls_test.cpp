#include "culling/occluders/solid_hulls.h"

#include <gtest/gtest.h>

#include <numeric>
#include <random>

#include "culling/scene/scene_builder.h"
#include "tests/scenes/rounds.h"
#include "tests/scenes/shapes.h"
#include "tests/unit/raster/cell_attack.h"

namespace culld {
namespace {

using scenes::Triangles;

Mesh meshOf(const Triangles& t, bool double_sided = false) {
  return makeMesh({{t.positions, t.indices, true, double_sided}});
}

Triangles turnedInsideOut(Triangles t) {
  for (std::size_t i = 0; i < t.indices.size(); i += 3) std::swap(t.indices[i], t.indices[i + 1]);
  return t;
}

/// An L of walls, and a house with a gable whose eaves do not stick out.
Triangles angle() {
  const std::vector<glm::vec2> corner{{0, 0}, {0, 2}, {1, 2}, {1, 1}, {2, 1}, {2, 0}};
  return scenes::prism(corner, 0.0F, 1.0F);
}

double volumeOf(const ConvexPiece& shape) {
  double sum = 0.0;
  for (const PieceFace& face : shape.faces) {
    const glm::dvec3 a(shape.vertices[face.corner[0]]), b(shape.vertices[face.corner[1]]),
        c(shape.vertices[face.corner[2]]);
    sum += glm::dot(a, glm::cross(b, c)) / 6.0;
  }
  return sum;
}

std::vector<std::uint32_t> allOf(const Mesh& mesh) {
  std::vector<std::uint32_t> part(mesh.triangles.size());
  std::iota(part.begin(), part.end(), 0U);
  return part;
}

TEST(SolidHulls, OfAConvexBodyIsNearlyAllOfIt) {
  const auto hulls = solidHulls(meshOf(scenes::prism(scenes::regularFootprint(24, 1.0F), 0, 2)));
  ASSERT_EQ(hulls.size(), 1U);
  EXPECT_LE(hulls[0].vertices.size(), kMostPieceVertices);
  EXPECT_GT(volumeOf(hulls[0].shape()), 0.8 * 24 / 2 * std::sin(2 * std::numbers::pi / 24) * 2);
  for (const PieceEdge& edge : hulls[0].edges) EXPECT_NE(edge.right, kNoFace);
  EXPECT_EQ(hulls[0].edges.size() + 2, hulls[0].vertices.size() + hulls[0].faces.size());
}

TEST(SolidHulls, OfAConcaveBodyAreCutDownUntilTheyFitAndReachIntoEachArm) {
  const Mesh mesh = meshOf(angle());
  const auto hulls = solidHulls(mesh);
  ASSERT_EQ(hulls.size(), 2U);
  for (const SolidHull& hull : hulls) {
    EXPECT_NEAR(volumeOf(hull.shape()), 2.0, 0.05);  // of the 3 that both arms have
    EXPECT_TRUE(surelyInside(hull.vertices, mesh, allOf(mesh), false));
  }
}

TEST(SolidHulls, WhatIsOpenHollowOrTurnedInwardsHasNone) {
  const Triangles box = scenes::box(glm::vec3(0), glm::vec3(1));
  Triangles open = box;
  open.indices.resize(open.indices.size() - 3);
  EXPECT_TRUE(solidHulls(meshOf(open)).empty());
  EXPECT_TRUE(solidHulls(meshOf(turnedInsideOut(box))).empty());
  EXPECT_EQ(solidHulls(meshOf(turnedInsideOut(box), true)).size(), 1U);
  EXPECT_TRUE(solidHulls(meshOf(scenes::torus(12, 8, 1.0F, 0.2F))).empty());
  EXPECT_TRUE(solidHulls(meshOf(scenes::quad({0, 0, 0}, {1, 0, 0}, {0, 1, 0}))).empty());
  EXPECT_TRUE(solidHulls(makeMesh({{box.positions, box.indices, false, false}})).empty());
  EXPECT_TRUE(solidHulls(makeMesh({})).empty());
}

TEST(SolidHulls, NeedEveryFaceToBlock) {
  const Triangles box = scenes::box(glm::vec3(0), glm::vec3(1));
  Triangles walls = box, window = box;
  walls.indices.resize(box.indices.size() - 6);
  window.indices.erase(window.indices.begin(), window.indices.end() - 6);
  const Mesh glazed = makeMesh({{walls.positions, walls.indices, true, false},
                                {window.positions, window.indices, false, false}});
  EXPECT_TRUE(solidHulls(glazed).empty());
}

TEST(SolidHulls, EachClosedPartHasItsOwn) {
  Triangles two = angle();
  scenes::append(two, scenes::box(glm::vec3(0), glm::vec3(3)), scenes::movedBy({9, 0, 0}));
  const auto hulls = solidHulls(meshOf(two));
  ASSERT_EQ(hulls.size(), 3U);
  EXPECT_GT(volumeOf(hulls[0].shape()), 20.0);  // largest first
  EXPECT_LE(hulls[2].box_mesh.max.x, 2.0);
}

TEST(SurelyInside, KnowsInsideFromOutsideAndTouching) {
  const Mesh mesh = meshOf(scenes::box(glm::vec3(-1), glm::vec3(1)));
  const auto part = allOf(mesh);
  const auto cube = [](float half, const glm::vec3& at) {
    std::vector<glm::vec3> points;
    for (unsigned i = 0; i < 8; ++i)
      points.push_back(at + half * glm::vec3((i & 1) ? 1 : -1, (i & 2) ? 1 : -1, (i & 4) ? 1 : -1));
    return points;
  };
  EXPECT_TRUE(surelyInside(cube(0.999F, {0, 0, 0}), mesh, part, false));
  EXPECT_FALSE(surelyInside(cube(1.0F, {0, 0, 0}), mesh, part, false));
  EXPECT_FALSE(surelyInside(cube(1.001F, {0, 0, 0}), mesh, part, false));
  EXPECT_FALSE(surelyInside(cube(0.2F, {0.9F, 0, 0}), mesh, part, false));
  EXPECT_FALSE(surelyInside(cube(0.2F, {3, 0, 0}), mesh, part, false));
  EXPECT_FALSE(surelyInside(cube(5.0F, {0, 0, 0}), mesh, part, false));  // around all of it
}

/// Segments from outside to points of hulls meet a front of the mesh on the way.
TEST(SolidHullsAttack, ASegmentIntoAHullEntersTheMeshFirst) {
  std::mt19937_64 engine(7);
  const auto unit = [&] { return std::uniform_real_distribution<double>(-1, 1)(engine); };
  std::size_t found = 0;
  for (std::uint32_t seed = 1; seed <= scenes::rounds(300); ++seed) {
    scenes::Random random(seed);
    Triangles shape;
    scenes::Rows stretch = scenes::turnedAndMoved(unit(), {unit(), unit(), unit()});
    for (int i = 0; i < 12; ++i) stretch[static_cast<std::size_t>(i)] += 0.3 * unit();
    scenes::append(shape,
                   seed % 3 == 0 ? angle()
                   : seed % 3 == 1
                       ? scenes::ball(3 + seed % 4, 0.05 * (seed % 5), random)
                       : scenes::prism(scenes::regularFootprint(5 + seed % 30, 1), -1, 1),
                   stretch);
    const Mesh mesh = meshOf(shape);
    for (const SolidHull& hull : solidHulls(mesh)) {
      ++found;
      for (int k = 0; k < 60; ++k) {
        glm::dvec3 inside(0.0);
        double sum = 0.0;
        for (const glm::vec3& v : hull.vertices) {  // near a corner, an edge or a face
          const double weight = std::pow(std::abs(unit()), 8.0);
          inside += weight * glm::dvec3(v);
          sum += weight;
        }
        inside /= sum;
        const glm::dvec3 eye = inside + 20.0 * glm::dvec3(unit(), unit(), unit() + 3.0);
        const auto vec = [](const glm::dvec3& p) { return Vec{p.x, p.y, p.z}; };
        bool entered = false;
        for (const auto& t : mesh.triangles) {
          const Vec a = vec(glm::dvec3(mesh.positions[t[0]]) - eye),
                    b = vec(glm::dvec3(mesh.positions[t[1]]) - eye),
                    c = vec(glm::dvec3(mesh.positions[t[2]]) - eye), x = vec(inside - eye);
          const Vec n = cross(b - a, c - a);
          const Quad plane = dot(n, a);
          entered |= plane < 0 && dot(n, x) <= plane && dot(x, cross(b, a)) >= 0 &&
                     dot(x, cross(c, b)) >= 0 && dot(x, cross(a, c)) >= 0;
        }
        ASSERT_TRUE(entered) << "seed " << seed;
      }
    }
  }
  EXPECT_GT(found, scenes::rounds(100));
}

}  // namespace
}  // namespace culld
