// Does an answer keep the promise of its class? What each class is held to: docs/bench.md.
#pragma once
#include <cstdint>
#include <string>

#include "culling/culler.h"
#include "culling/oracle/oracle.h"

namespace culld::report {

struct Asked {
  const Oracle& oracle;
  const SceneSnapshot& scene;
  const Camera& camera;
  const OracleAnswer& truth;
  OracleOptions options;  ///< that the truth was found with
  Demand demand;
};

struct Checked {
  std::uint32_t missed = 0;           ///< of what samples saw
  std::uint32_t missed_subpixel = 0;  ///< of what only aimed rays saw
  double missed_px = 0.0;
  bool malformed = false;  ///< what it answers is not a set of the scene's ids
  std::string breach;      ///< empty: the promise is kept
};

/// COST: O(answered + visible); more only for classes hole and sampled that miss much.
Checked checkAnswer(const Asked& asked, const Answer& answer);

/// The side, in pixels, of the largest axis-parallel square in which every sample of a lattice of
/// `per_px` samples a pixel shows `object`; 0 if none shows it, or if the image has too many pixels
/// to be searched (2^24).
Result<double> largestSquarePx(const Oracle& oracle, const Camera& camera, ObjectId object,
                               double per_px);

}  // namespace culld::report
