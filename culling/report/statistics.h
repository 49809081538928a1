// Figures that sum up measurements: how they spread, and which of them nothing else beats.
#pragma once
#include <cstddef>
#include <span>
#include <vector>

namespace culld::report {

struct Spread {
  double min = 0.0, median = 0.0, p95 = 0.0, max = 0.0;
};

/// The value below which a share of the sorted values lies, linear between neighbours. 0 of
/// nothing. REQUIRES: `sorted` ascending, `share` within 0 and 1.
double percentile(std::span<const double> sorted, double share);

/// Values that are not finite are left out; of nothing all is 0.
Spread spreadOf(std::vector<double> values);

/// 0 of nothing.
double meanOf(std::span<const double> values);

/// Two costs of one choice.
struct Cost {
  double x = 0.0, y = 0.0;
};

/// Indices of the points that no other point beats: none is as small in both and smaller in one.
/// By ascending x; of equal points the first. Points that are not finite are on no front.
std::vector<std::size_t> paretoFront(std::span<const Cost> points);

}  // namespace culld::report
