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
  std::uint32_t rays_per_object = 16;    ///< aimed at each object in the frustum not seen so far
  std::uint64_t seed = 1;
  std::size_t threads = 0;  ///< 0: as many as cores. The answer does not depend on it
};

struct OracleAnswer {
  std::vector<ObjectId> visible;       ///< ascending, unique: certainly in E
  std::vector<float> pixels;           ///< per visible object: samples that saw it, in pixels
  std::vector<std::uint8_t> subpixel;  ///< per visible object: 1 if only an aimed ray saw it
  /// Not visible for certain: met only behind a blocking surface by less than the tie tolerance.
  std::vector<ObjectId> ties;
  std::vector<ObjectId> in_frustum;  ///< ascending: objects whose box reaches into the frustum
  std::uint64_t rays = 0;            ///< cast, aimed ones included
  /// How much may still be missing: objects that the last round of aimed rays found, and how many
  /// objects it tried with kAimedRaysPerRound rays each.
  std::size_t last_round_found = 0;
  std::size_t last_round_tried = 0;
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

  /// The motion bound of `camera` is ignored: the look is from its eye.
  /// GUARANTEES: every object in `visible` has a point inside the open frustum that no blocking
  /// surface hides by more than the rounding of doubles, every blocking triangle grown by the
  /// rounding of its own float coordinates. Equal inputs give equal answers for any thread count.
  Result<OracleAnswer> look(const Camera& camera, const OracleOptions& options = {}) const;

  /// Row by row, top row first: the nearest surface at each pixel's centre.
  Result<std::vector<OraclePixel>> paint(const Camera& camera, std::size_t threads = 0) const;

 private:
  struct Parts;
  explicit Oracle(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace culld
