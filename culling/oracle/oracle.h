// Ground truth: which objects of a scene can this camera see? By ray casts, so that it shares no
// idea and no code with the methods it judges (docs/oracle.md). What it finds is visible; it may
// miss. Embree only walks the hierarchies: every hit is decided in double precision, relative to
// the eye.
#pragma once
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <vector>

#include "culling/core/camera.h"
#include "culling/core/ids.h"
#include "culling/core/result.h"
#include "culling/scene/scene_snapshot.h"

namespace culld {

struct OracleOptions {
  std::uint32_t lattice = 2;             ///< lattice * lattice jittered samples in each pixel
  std::uint64_t max_samples = 1U << 24;  ///< huge images: an even, thinner lattice
  /// Aimed at each object in the frustum that no sample met; whole rounds of kAimedRaysPerRound.
  std::uint32_t rays_per_object = 16;
  std::uint32_t poses = 12;  ///< further ones, if the camera has a motion bound
  std::uint64_t seed = 1;
  std::size_t threads = 0;  ///< 0: as many as cores. The answer does not depend on it
};

/// What equal tries found tells about what they left unfound. Both figures are estimates, no
/// bounds; docs/oracle.md says what they assume. They may be added up over cameras.
struct UnfoundEstimate {
  std::uint64_t tries = 0;
  std::uint64_t found_once = 0;  ///< objects that exactly one of the tries found
  std::uint64_t not_found = 0;   ///< objects in the frustum that nothing found: none exceeds it
  /// How many more objects one more try would find (I. J. Good, 1953).
  double byOneMoreTry() const noexcept;
  /// How many more objects would be found if the tries went on forever.
  double byAnyNumber() const noexcept;
};

struct OracleAnswer {
  std::vector<ObjectId> visible;       ///< ascending, unique: certainly in E, from some pose
  std::vector<float> pixels;           ///< per visible object: samples that saw it, in pixels; the
                                       ///< most of any pose
  std::vector<std::uint8_t> subpixel;  ///< per visible object: 1 if only aimed rays saw it
  /// Not visible for certain: met only behind a blocking surface by less than the tie tolerance.
  std::vector<ObjectId> ties;
  std::vector<ObjectId> in_frustum;  ///< ascending: objects whose box reaches into the frustum
  std::uint32_t poses = 1;           ///< looked from; more than 1 only with a motion bound
  std::uint64_t rays = 0;            ///< cast, aimed ones included
  UnfoundEstimate unfound_by_rays;   ///< a try is one more round of aimed rays from each pose
  UnfoundEstimate unfound_by_poses;  ///< a try is one more pose; none with a camera that is still
};

inline constexpr std::uint32_t kAimedRaysPerRound = 4;
inline constexpr ObjectId kNoObject = 0xFFFFFFFFU;

/// What a pixel's centre shows.
struct OraclePixel {
  ObjectId object = kNoObject;
  float distance_m = 0.0F;       ///< from the eye (orthographic: from the near plane)
  glm::vec3 normal_world{0.0F};  ///< unit length, towards the viewer
};

/// THREADS: any number of callers of the const functions.
class Oracle {
 public:
  /// COST: one Embree hierarchy per mesh, shared by its instances; about 60 bytes per triangle.
  /// ERROR: kUnavailable if Embree cannot start or is out of memory.
  static Result<std::unique_ptr<Oracle>> build(SnapshotPtr scene);
  ~Oracle();

  /// From the camera's own pose and, if it has a motion bound, from `options.poses` others within
  /// it: the answer holds what any of them sees.
  /// GUARANTEES: for every object in `visible` there is a pose within the motion bound and a point
  /// inside its open frustum that no blocking surface hides by more than the rounding of doubles,
  /// every blocking triangle grown by the rounding of its own float coordinates. Equal inputs give
  /// equal answers for any thread count. COST: one look per pose.
  Result<OracleAnswer> look(const Camera& camera, const OracleOptions& options = {}) const;

  /// Row by row, top row first: the nearest surface at each pixel's centre, from the camera's own
  /// pose.
  Result<std::vector<OraclePixel>> paint(const Camera& camera, std::size_t threads = 0) const;

 private:
  struct Parts;
  explicit Oracle(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace culld
