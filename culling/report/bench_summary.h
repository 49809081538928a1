// The figures of one run over all its cameras: what a row of the tables holds.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "culling/report/bench.h"

namespace culld::report {

/// Means are per camera. What has no value (nothing visible: no excess) is none, never NaN.
struct RunSummary {
  std::uint64_t missed = 0, missed_subpixel = 0;  ///< over all cameras
  double missed_px = 0.0;                         ///< over all cameras
  /// Is what approximate answers say about their loss true? Their number, the pixels that they say
  /// they may have lost, those that they did lose, and how many lost more than they say.
  std::uint64_t lossy = 0, exceeded = 0;
  double said_px = 0.0, lossy_missed_px = 0.0;
  double in_frustum = 0.0, visible = 0.0, answered = 0.0;
  std::optional<double> excess;        ///< answered / visible
  std::optional<double> culled_share;  ///< of what is in the frustum and not visible
  Spread cameras_us;                   ///< of the cameras' medians, over the cameras
  double mean_us = 0.0;                ///< of the cameras' medians
  double low_us = 0.0, high_us = 0.0;  ///< means of the cameras' minima and 95 % points: the noise
  std::optional<double> relative, relative_min;  ///< time, to the baseline's; of medians, of minima
  double answer_bytes = 0.0, change_bytes = 0.0;
  double out_of_budget = 0.0;           ///< share of the answers
  double work_us = 0.0;                 ///< counted and priced, without a clock: free of noise
  std::optional<double> relative_work;  ///< to the baseline's
  std::string made_by;                  ///< "raster 75 %, frustum 25 %", if the method chooses
  double nodes_visited = 0.0, tested = 0.0, occluders_drawn = 0.0, triangles_drawn = 0.0;
  double plane_tests = 0.0, depth_comparisons = 0.0;
  /// What the stages brought, in objects: left out by the frustum alone, and further by the method,
  /// which took it so many microseconds more.
  double outside = 0.0, occluded = 0.0, extra_us = 0.0;
};

RunSummary summaryOf(const SceneFigures& scene, const BenchRun& run);

}  // namespace culld::report
