// A snapshot's meshes ready for rays, and one look's view of it: the objects whose boxes reach into
// the frustum, placed relative to the eye in double precision, under one Embree hierarchy.
#pragma once
#include <array>
#include <cstdint>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <vector>

#include "culling/core/ids.h"
#include "culling/core/result.h"
#include "culling/oracle/embree_handles.h"
#include "culling/oracle/ray_mesh.h"
#include "culling/oracle/view_rays.h"
#include "culling/scene/scene_snapshot.h"

namespace culld::oracle {

/// Where an object's mesh is: world = linear * (mesh point - mesh centre) + centre_world.
struct Placing {
  const RayMesh* mesh = nullptr;  ///< null: nothing that a ray can meet
  glm::dmat3 linear{1.0};
  glm::dvec3 shift_world{0.0};
};

class RayScene {
 public:
  /// ERROR: kUnavailable: Embree does not start or is out of memory.
  static Result<std::unique_ptr<RayScene>> build(SnapshotPtr scene);

  const SceneSnapshot& snapshot() const { return *scene_; }
  RTCDevice device() const { return device_.get(); }
  Placing place(ObjectId id) const;

 private:
  explicit RayScene(SnapshotPtr scene) : scene_(std::move(scene)) {}
  void flatten(ObjectId id);

  SnapshotPtr scene_;
  DeviceHandle device_;
  std::vector<std::unique_ptr<RayMesh>> meshes_;  // by MeshId, then the flattened ones
  std::vector<std::uint32_t> flattened_;          // by object: index into meshes_, or 0xFFFFFFFF
};

/// A surface of an object on a ray, not behind a blocking one by more than the tie tolerance.
struct Hit {
  double t = 0.0;
  std::uint32_t placed = 0;  ///< index into RayView's objects
  std::uint32_t triangle = 0;
  bool tie = false;  ///< behind the blocking surface, by more than the rounding of doubles
};

/// Filled by a trace. Kept by the caller from ray to ray, so that it stops allocating.
struct Hits {
  std::vector<Hit> found;
  std::vector<MeshHit> in_mesh;  // scratch
};

class RayView {
 public:
  struct Placed {
    ObjectId object = 0;
    bool may_block = true;
    const RayMesh* mesh = nullptr;
    glm::dmat3 world_from_mesh{1.0};
    glm::dmat3 mesh_from_world{1.0};
    glm::dvec3 centre{0.0};            ///< relative to the camera's origin
    double rounding_m = 0.0;           ///< of positions relative to the eye
    double size = 0.0;                 ///< largest coordinate of its box, relative to the eye
    std::array<glm::dvec3, 3> axes{};  ///< its box is centre + sum of s_i * axes[i]
  };

  /// ERROR: kUnavailable: Embree is out of memory. REQUIRES: `scene` outlives the view.
  static Result<std::unique_ptr<RayView>> build(const RayScene& scene, const Camera& camera);
  RayView(const RayView&) = delete;
  RayView& operator=(const RayView&) = delete;

  const ViewRays& rays() const { return rays_; }
  const std::vector<Placed>& objects() const { return placed_; }
  /// Replaces hits.found; in no order. THREADS: any, each with its own hits.
  void trace(const Ray& ray, Hits& hits) const;

 private:
  struct Query;
  explicit RayView(const Camera& camera) : rays_(camera) {}
  void placeObjects(const RayScene& scene, const Camera& camera);
  static void boundsOf(const RTCBoundsFunctionArguments* args);
  static void intersect(const RTCIntersectFunctionNArguments* args);
  void enter(std::uint32_t placed, Query& query) const;
  double limit(double blocked_at) const;

  ViewRays rays_;
  std::vector<Placed> placed_;
  double unit_m_ = 1.0;  // Embree's floats count in this unit
  SceneHandle hierarchy_;
};

}  // namespace culld::oracle
