#include "culling/occluders/occluder_set.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <glm/common.hpp>
#include <glm/vector_relational.hpp>

#include "culling/occluders/convex_pieces.h"
#include "culling/scene/scene_builder.h"
#include "tests/scenes/shapes.h"

namespace culld {
namespace {

Mesh meshOf(const scenes::Triangles& t) {
  return makeMesh({{t.positions, t.indices, true, false}});
}

TEST(OccluderSet, HoldsThePiecesOfEachMeshAndSharesTheirShapes) {
  scenes::Triangles two = scenes::box(glm::vec3(0), glm::vec3(1));
  scenes::append(two, scenes::box(glm::vec3(2), glm::vec3(5)));
  const std::vector<Mesh> meshes{meshOf(scenes::box(glm::vec3(-7), glm::vec3(1))),
                                 meshOf(scenes::torus(7, 4, 0.8F, 0.25F)), meshOf(two)};
  SceneBuilder builder;
  for (const Mesh& mesh : meshes) builder.addMesh(mesh);
  const SnapshotPtr scene = builder.finish();
  const OccluderSet set = OccluderSet::of(*scene);
  EXPECT_EQ(set.pieceCount(), 3U);
  EXPECT_EQ(set.shapeCount(), 1U);
  EXPECT_GT(set.bytes(), 0U);
  for (MeshId id = 0; id < meshes.size(); ++id) {
    const OccluderMesh& packed = set.mesh(id);
    const ConvexPieces found = ConvexPieces::of(meshes[id]);
    EXPECT_EQ(packed.blocking_triangles, meshes[id].blocking_triangles);
    EXPECT_EQ(packed.vertices, meshes[id].positions.size());
    ASSERT_EQ(packed.piece_count, found.size());
    for (std::uint32_t p = 0; p < packed.piece_count; ++p) {
      const ConvexPiece piece = set.piece(packed.first_piece + p);
      EXPECT_TRUE(std::equal(piece.vertices.begin(), piece.vertices.end(),
                             found[p].vertices.begin(), found[p].vertices.end()));
      EXPECT_EQ(piece.faces.size(), found[p].faces.size());
      EXPECT_EQ(piece.edges.size(), found[p].edges.size());
      for (const glm::vec3& v : piece.vertices) {
        EXPECT_TRUE(glm::all(glm::lessThanEqual(glm::abs(v), packed.largest)));
      }
    }
  }
  EXPECT_EQ(set.mesh(0).largest, glm::vec3(7));
}

TEST(OccluderSet, OfAnEmptySceneIsEmpty) {
  const OccluderSet set = OccluderSet::of(*SceneBuilder().finish());
  EXPECT_EQ(set.pieceCount(), 0U);
}

}  // namespace
}  // namespace culld
