// The triangles of one mesh (or of one instance whose transform cannot be inverted), ready for
// rays. Coordinates inside are relative to the mesh's centre, so that Embree's floats lose nothing.
#pragma once
#include <embree3/rtcore.h>

#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <span>
#include <vector>

#include "culling/oracle/embree_handles.h"
#include "culling/oracle/triangle_hit.h"
#include "culling/scene/mesh.h"

namespace culld::oracle {

struct MeshHit {
  double distance = 0.0;
  std::uint32_t triangle = 0;
};

/// One ray on its way through one mesh. Distances are along `direction`, from `origin`.
struct MeshTrace {
  glm::dvec3 origin{0.0};     ///< relative to the mesh's centre
  glm::dvec3 direction{0.0};  ///< unit length
  double from = 0.0;
  double blocked_at = std::numeric_limits<double>::infinity();  ///< nearest blocking surface
  double tie = 0.0;  ///< surfaces up to blocked_at * (1 + tie_relative) + tie matter
  bool may_block = true;
  double limit() const;
};

/// Relative to the distance: surfaces nearer together than this are never told apart with
/// certainty.
inline constexpr double kTieRelative = 1e-5;

/// Which side of a triangle is its front. Unknown: the transform is so nearly flat that rounding
/// decides whether it mirrors; then single-sided triangles block for certain and are not seen for
/// certain, so that nothing is called visible because of them.
enum class Front : std::uint8_t { kCounterClockwise, kClockwise, kUnknown };

class RayMesh {
 public:
  explicit RayMesh(const Mesh& mesh);
  /// For transforms without a usable inverse: the same triangles, already turned and scaled.
  RayMesh(const Mesh& mesh, std::vector<glm::dvec3> positions, Front front);
  RayMesh(const RayMesh&) = delete;
  RayMesh& operator=(const RayMesh&) = delete;

  /// False if Embree is out of memory. REQUIRES: called once, and the mesh does not move
  /// afterwards.
  bool buildHierarchy(RTCDevice device);
  /// Adds every surface met that may be seen, and moves trace.blocked_at.
  void trace(MeshTrace& trace, std::vector<MeshHit>& hits) const;

  Triangle triangle(std::uint32_t index) const;  ///< relative to centre()
  const Surface& surfaceOf(std::uint32_t triangle) const;
  std::uint32_t triangleCount() const;
  /// The triangle at `share` (0 to 1) of the whole area.
  std::uint32_t triangleAtArea(double share) const;
  const glm::dvec3& centre() const { return centre_; }
  const glm::dvec3& halfExtent() const { return half_extent_; }
  double radius() const { return radius_; }  ///< 0: nothing to meet
  Front front() const { return front_; }

 private:
  struct Query;
  static void boundsOf(const RTCBoundsFunctionArguments* args);
  static void intersect(const RTCIntersectFunctionNArguments* args);
  void measure();
  glm::dvec3 corner(std::uint32_t vertex) const;
  void meet(std::uint32_t triangle, Query& query) const;

  const Mesh* mesh_;
  std::vector<glm::dvec3> positions_;  // empty: the mesh's own
  Front front_ = Front::kCounterClockwise;
  glm::dvec3 centre_{0.0};
  glm::dvec3 half_extent_{0.0};
  double radius_ = 0.0;
  double grow_ = 0.0;
  std::vector<double> area_up_to_;  // running sum, one per triangle
  SceneHandle hierarchy_;
};

}  // namespace culld::oracle
