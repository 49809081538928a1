// Puts every method, `auto` included, through one case on every SIMD target, and judges the
// answers by the oracle.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "culling/culler.h"
#include "tests/cases/case.h"

namespace culld::cases {

struct RunOptions {
  std::uint64_t samples = 20'000;       ///< of the oracle, per camera
  std::uint32_t rays_per_object = 16;   ///< of the oracle
  std::uint32_t repeats = 1;            ///< the time told is the least of so many
  std::chrono::seconds time_limit{30};  ///< of one answer: generous, it is for what never ends
};

/// Sums over the cameras of a case.
struct MethodRun {
  std::string method;
  std::size_t answered = 0;
  std::size_t missed = 0;  ///< seen by the oracle and not answered
  std::size_t excess = 0;  ///< answered, not seen, not tied
  double time_us = 0.0;    ///< of the best target
  CullStats work;
};

struct CaseRun {
  std::size_t looks = 0;
  std::size_t objects = 0;  ///< in the scene
  std::size_t visible = 0;  ///< by the oracle, over all cameras
  std::size_t ties = 0;
  std::vector<MethodRun> methods;
  /// One line for each promise that was broken: something missed, unequal bytes, unbounded work, a
  /// bad camera taken. Empty if all is well.
  std::vector<std::string> faults;

  /// Sums up the runs of the same methods.
  void add(const CaseRun& more);
};

CaseRun runCase(const Case& of, const RunOptions& options = {});

/// How far behind the wall of makeProbe a thing must be before the method leaves it out, in float
/// ulps of the wall's distance; by bisection. Infinite if it is never left out though it is in the
/// frustum, NaN if the distance is no float. Seed 0 shows what the arithmetic costs; with other
/// seeds the thing is turned against the world's axes, and its box reaches nearer than itself.
double depthSlackUlps(const Family& family, double value, std::uint64_t seed,
                      std::string_view method);

/// The methods' names, in the table's order.
std::vector<std::string> methodNames();

}  // namespace culld::cases
