#include "culling/occluders/convex_pieces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <glm/geometric.hpp>

#include "culling/scene/scene_builder.h"
#include "tests/scenes/shapes.h"

namespace culld {
namespace {

using scenes::Triangles;

RawSurface opaque(const Triangles& t) { return {t.positions, t.indices, true, false}; }

ConvexPieces piecesOf(const Triangles& t) { return ConvexPieces::of(makeMesh({opaque(t)})); }

Triangles unitBox() { return scenes::box(glm::vec3(0), glm::vec3(1)); }

TEST(ConvexPieces, ABoxHasEightVerticesSixFacesTwelveEdges) {
  const ConvexPieces pieces = piecesOf(unitBox());
  ASSERT_EQ(pieces.size(), 1U);
  EXPECT_EQ(pieces.triangles(), 12U);
  EXPECT_EQ(pieces[0].vertices.size(), 8U);
  EXPECT_EQ(pieces[0].faces.size(), 6U);
  EXPECT_EQ(pieces[0].edges.size(), 12U);
  for (const PieceEdge& edge : pieces[0].edges) {
    EXPECT_NE(edge.left, edge.right);
    EXPECT_NE(edge.right, kNoFace);
  }
}

TEST(ConvexPieces, ATurnedBoxKeepsItsTriangles) {  // rounding bends its faces
  Triangles turned;
  scenes::append(turned, unitBox(), scenes::turnedAndMoved(0.3, {}));
  const ConvexPieces pieces = piecesOf(turned);
  ASSERT_EQ(pieces.size(), 1U);
  EXPECT_EQ(pieces[0].faces.size(), 2U + 4U * 2U);  // caps stay at one height exactly
}

TEST(ConvexPieces, EachPartOfAMeshIsAPiece) {
  Triangles three = unitBox();
  scenes::append(three, unitBox(), scenes::movedBy({2, 0, 0}));
  scenes::append(three, scenes::quad({0, 5, 0}, {1, 0, 0}, {0, 0, 1}));
  const ConvexPieces pieces = piecesOf(three);
  ASSERT_EQ(pieces.size(), 3U);
  EXPECT_EQ(pieces.triangles(), 26U);
  std::size_t panels = 0;
  for (std::size_t i = 0; i < pieces.size(); ++i) panels += pieces[i].faces.size() == 1 ? 1U : 0U;
  EXPECT_EQ(panels, 1U);
}

TEST(ConvexPieces, ABoxWithoutALidIsAPieceWithARim) {
  const Triangles box = unitBox();
  Triangles open{box.positions, {}};
  for (std::size_t i = 0; i < box.indices.size(); i += 3) {
    const std::uint32_t* t = &box.indices[i];
    const bool lid = std::all_of(t, t + 3, [&](auto v) { return box.positions[v].y == 1.0F; });
    if (!lid) open.indices.insert(open.indices.end(), t, t + 3);
  }
  const ConvexPieces pieces = piecesOf(open);
  ASSERT_EQ(pieces.size(), 1U);
  std::size_t rim = 0;
  for (const PieceEdge& edge : pieces[0].edges) rim += edge.right == kNoFace ? 1U : 0U;
  EXPECT_EQ(rim, 4U);
}

TEST(ConvexPieces, AMeshWithAnythingElseHasNone) {
  const std::vector<glm::vec2> corner{{0, 0}, {0, 2}, {1, 2}, {1, 1}, {2, 1}, {2, 0}};
  Triangles angle = scenes::prism(corner, 0.0F, 1.0F);
  EXPECT_EQ(piecesOf(angle).size(), 0U);
  scenes::append(angle, unitBox(), scenes::movedBy({9, 0, 0}));
  EXPECT_EQ(piecesOf(angle).size(), 0U);
  EXPECT_EQ(piecesOf(scenes::torus(7, 4, 0.8F, 0.25F)).size(), 0U);
  EXPECT_EQ(piecesOf(scenes::wallWithHole({0, 0}, {0.3F, 0.3F})).size(), 0U);
  EXPECT_EQ(ConvexPieces::of(makeMesh({})).size(), 0U);
}

TEST(ConvexPieces, WhatDoesNotBlockIsLeftOutAndTwoSidesAreNotOne) {
  const Triangles box = unitBox();
  EXPECT_EQ(ConvexPieces::of(makeMesh({{box.positions, box.indices, false, false}})).size(), 0U);
  EXPECT_EQ(ConvexPieces::of(makeMesh({{box.positions, box.indices, true, true}})).size(), 0U);
  Triangles glass;
  scenes::append(glass, box, scenes::movedBy({3, 0, 0}));
  const Mesh both = makeMesh({opaque(box), {glass.positions, glass.indices, false, false}});
  EXPECT_EQ(ConvexPieces::of(both).size(), 1U);
}

TEST(ConvexPieces, ABoxTurnedInsideOutIsNoPiece) {
  Triangles box = unitBox();
  for (std::size_t i = 0; i < box.indices.size(); i += 3)
    std::swap(box.indices[i], box.indices[i + 1]);
  EXPECT_EQ(piecesOf(box).size(), 0U);
}

TEST(ConvexPieces, FacesOfAnyMeshAreItsFlatParts) {
  const Triangles shape = unitBox();
  const Mesh mesh = makeMesh({{shape.positions, shape.indices, true, false}});
  const ConvexPieces faces = ConvexPieces::facesOf(mesh, 100);
  ASSERT_EQ(faces.size(), 6U);
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(faces[i].vertices.size(), 4U);
    EXPECT_EQ(faces[i].faces.size(), 1U);
    ASSERT_EQ(faces[i].edges.size(), 4U);
    for (const PieceEdge& edge : faces[i].edges) {
      EXPECT_EQ(edge.left, 0U);
      EXPECT_EQ(edge.right, kNoFace);
    }
  }
}

TEST(ConvexPieces, TheLargestFacesStay) {
  const Triangles shape = scenes::box(glm::vec3(0), glm::vec3(1, 2, 3));
  const Mesh mesh = makeMesh({{shape.positions, shape.indices, true, false}});
  const ConvexPieces faces = ConvexPieces::facesOf(mesh, 2);
  ASSERT_EQ(faces.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    for (const glm::vec3& v : faces[i].vertices) EXPECT_EQ(v.x, faces[i].vertices[0].x);
  }
}

TEST(ConvexPieces, FacesWithTwoSidesComeTwice) {
  const Triangles one = scenes::quad({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  const ConvexPieces faces =
      ConvexPieces::facesOf(makeMesh({{one.positions, one.indices, true, true}}), 100);
  ASSERT_EQ(faces.size(), 2U);
  const auto winding = [&](std::size_t i) {
    const auto& c = faces[i].faces[0].corner;
    const auto& v = faces[i].vertices;
    return glm::cross(v[c[1]] - v[c[0]], v[c[2]] - v[c[0]]).z;
  };
  EXPECT_GT(winding(0), 0.0F);
  EXPECT_LT(winding(1), 0.0F);
  EXPECT_EQ(faces[0].edges[0].from, faces[1].edges[0].to);
}

}  // namespace
}  // namespace culld
