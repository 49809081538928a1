// What stands between a viewer and a target: a convex piece of an object's mesh, in world space.
// Of a closed piece the solid inside it, bounded by planes moved inwards past all rounding; of an
// open one each face, bounded by its rim. After the shadow of one convex occluder (Hudson et al.
// 1997; Coorg, Teller 1997): it is convex, so corners decide for all of a box.
// Proofs: docs/error-model/pairs.md.
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "culling/core/box.h"
#include "culling/core/convex_piece.h"
#include "culling/pairs/places.h"
#include "culling/scene/scene_snapshot.h"

namespace culld {

/// dot(normal, x) <= inner: behind it as far as the solid goes; > outer: in front of the piece.
struct SolidPlane {
  glm::dvec3 normal;
  double inner, outer;
};

/// The part of space behind all its planes lies inside a closed surface that blocks.
class SolidBlocker {
 public:
  /// None if the piece is open, or so flat or far away that rounding leaves nothing of it.
  static std::optional<SolidBlocker> of(const ConvexPiece& piece, const Instance& instance);

  /// GUARANTEES: if true, every segment from the viewer's box to the target's is blocked.
  bool hides(const PlaceCorners& viewer, const PlaceCorners& target) const noexcept;
  const Box& bounds() const noexcept { return bounds_; }
  std::size_t bytes() const noexcept {
    return sizeof *this + planes_.capacity() * sizeof(SolidPlane);
  }

 private:
  bool outside(const PlaceCorners& viewer) const noexcept;
  bool meets(const glm::dvec3& from, const glm::dvec3& to, double largest) const noexcept;

  std::vector<SolidPlane> planes_;
  Box bounds_;  ///< of the piece
};

/// A flat face, which blocks from its front.
class FaceBlocker {
 public:
  /// Appends one for each face that rounding leaves something of.
  static void append(const ConvexPiece& piece, const Instance& instance,
                     std::vector<FaceBlocker>& out);

  /// As SolidBlocker::hides.
  bool hides(const PlaceCorners& viewer, const PlaceCorners& target) const noexcept;
  const Box& bounds() const noexcept { return bounds_; }
  std::size_t bytes() const noexcept { return sizeof *this + rim_.capacity() * sizeof(RimEdge); }

 private:
  struct RimEdge {
    glm::dvec3 from, to;  ///< counter-clockwise from the front
  };
  bool inFront(const glm::dvec3& point, double sign) const noexcept;
  bool passes(const glm::dvec3& from, const glm::dvec3& to) const noexcept;

  std::array<glm::dvec3, 3> corner_;  ///< three of its vertices, counter-clockwise from the front
  std::vector<RimEdge> rim_;
  double rounding_m_ = 0.0;  ///< of its vertices
  Box bounds_;
};

}  // namespace culld
