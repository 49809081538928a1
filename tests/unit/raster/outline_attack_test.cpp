// Attacks outlines: see cell_attack.h. Pieces here need not be convex, as the proof does not ask
// for it: any single-sided mesh small enough is one, with all its triangles as faces.
#include "culling/occluders/convex_pieces.h"
#include "culling/raster/convex_outline.h"
#include "tests/unit/raster/cell_attack.h"

namespace culld {
namespace {

/// A mesh's triangles as the faces of one piece; what is found has faces of several triangles.
struct Piece {
  std::vector<PieceFace> faces;
  std::vector<PieceEdge> edges;

  explicit Piece(const Mesh& mesh) {
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      const auto& v = mesh.triangles[t];
      faces.push_back({{byte(v[0]), byte(v[1]), byte(v[2])}});
      for (std::uint32_t e = 0; e < 3; ++e) {
        const std::uint32_t partner = mesh.partners[3 * t + e];
        if (partner != kOpenEdge && partner / 3 < t) continue;
        const std::uint8_t right = partner == kOpenEdge ? kNoFace : byte(partner / 3);
        edges.push_back({byte(v[e]), byte(v[(e + 1) % 3]), byte(t), right});
      }
    }
  }
  static std::uint8_t byte(std::uint32_t x) { return static_cast<std::uint8_t>(x); }
};

class OutlineAttack : public CellAttack {
 protected:
  Mesh mesh() override {
    scenes::Random shapes(random_());
    scenes::Triangles t;
    switch (random_() % 6) {
      case 0:
        t = scenes::ball(3, chance(2) ? 0.0 : 0.4, shapes);
        break;
      case 1:
        t = scenes::torus(7, 4, 0.8F, 0.25F);
        break;
      case 2:
        t = scenes::bumpySheet(4, chance(2) ? 0.0 : 0.5, shapes);
        break;
      case 3:
        t = scenes::prism(scenes::regularFootprint(3 + random_() % 8, 0.9F), -1.0F, 1.0F);
        break;
      default:
        t = scenes::box(glm::vec3(-1), glm::vec3(1));
    }
    return makeMesh({{t.positions, t.indices, true, false}});
  }

  void draw(const Mesh& mesh, const std::array<double, 12>& world_from_mesh, const CellView& view,
            const glm::dvec3& eye, DepthCells& cells) override {
    const auto [wanted, rows] = placedIn(view, mesh, world_from_mesh, eye);
    if (wanted == 0) return;
    const ConvexPieces found = ConvexPieces::of(mesh);
    const Piece own(mesh);
    const bool as_found = found.size() == 1 && chance(2);
    const ConvexPiece piece =
        as_found ? found[0] : ConvexPiece{mesh.positions, own.faces, own.edges};
    ConvexOutline outline;
    if (outlineOf(piece, rows, view.grid, view.perspective, wanted, outline) ==
        OutlineVerdict::kDraw) {
      drawOutline(outline, 1e30F, cells);
      ++drawn_;
    }
  }

  std::size_t drawn_ = 0;
};

TEST_F(OutlineAttack, EveryRayThroughACoveredCellMeetsTheObjectAtLeastAsNear) {
  for (std::uint64_t seed = 1; seed <= 4000 && !HasFatalFailure(); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    begin(seed);
    attackOnce();
  }
  std::printf("%zu pieces, %zu cells judged\n", drawn_, cells_);
  EXPECT_GT(drawn_, 500U);
  EXPECT_GT(cells_, 1500U);
}

TEST_F(OutlineAttack, AlsoWhereCancellationLeavesVerticesFewDigits) {
  for (std::uint64_t seed = 1; seed <= 1200 && !HasFatalFailure(); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    begin(seed);
    attackCancellation();
  }
  std::printf("%zu pieces, %zu cells judged\n", drawn_, cells_);
  EXPECT_GT(drawn_, 300U);
}

}  // namespace
}  // namespace culld
