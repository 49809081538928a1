// The frame of a run that is most worth a look, kept while the run goes on.
#pragma once
#include <cstddef>
#include <span>
#include <string>
#include <tuple>
#include <vector>

#include "culling/oracle/oracle.h"
#include "culling/report/bench_check.h"

namespace culld::report {

/// Most missed; where nothing is missed, most answered although hidden.
class WorstFrame {
 public:
  void consider(std::size_t camera, std::span<const ObjectId> answered, const Checked& checked,
                std::size_t visible);
  using Missed = std::pair<double, std::size_t>;  ///< pixels, objects
  const Missed& missed() const { return missed_; }
  std::size_t camera() const { return camera_; }
  /// A PNG as bytes. The truth is found once more: it is the same.
  Result<std::string> draw(const SceneSnapshot& scene, const Oracle& oracle, const Camera& camera,
                           const OracleOptions& options, const std::string& title) const;

 private:
  bool any_ = false;
  std::size_t camera_ = 0;
  Missed missed_;
  std::size_t in_vain_ = 0;
  std::vector<ObjectId> answered_;
};

}  // namespace culld::report
