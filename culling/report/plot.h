// Plots as inline SVG. They scale with the page; what they are about stands above them in HTML,
// legends too, so that nothing covers the data.
#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "culling/report/svg.h"

namespace culld::report {

struct PlotPoint {
  double x = 0.0, x_low = 0.0, x_high = 0.0, y = 0.0;
  std::string label;      ///< beside the marker where there is room; may be empty
  std::string tip;        ///< shown when pointed at
  bool on_front = false;  ///< nothing beats it
};

/// One method: a point per setting, in order.
struct PlotSeries {
  std::size_t style = 0;
  std::vector<PlotPoint> points;
};

struct PlotSpec {
  std::string x_name, y_name;  ///< with units
  Axis::Kind x_kind = Axis::Kind::kLog, y_kind = Axis::Kind::kLog;
  std::optional<double> y_line;  ///< a value to compare with
  std::string y_line_name;
  std::string words;   ///< in the middle of the plot
  bool front = false;  ///< draw the line through the points on the front
};

/// Points with horizontal bars for their spread, a line through each series.
std::string pointPlot(const PlotSpec& spec, const std::vector<PlotSeries>& series);

/// A line with a band around it.
struct BandSeries {
  std::size_t style = 0;
  std::vector<double> x, low, middle, high;
};
std::string bandPlot(const PlotSpec& spec, const std::vector<BandSeries>& series);

/// One line per row, its markers on a common axis: many things compared in a few methods.
struct DotRow {
  std::string name;
  struct Dot {
    std::size_t style = 0;
    double x = 0.0, x_low = 0.0, x_high = 0.0;
    std::string tip;
  };
  std::vector<Dot> dots;
};
struct DotSpec {
  std::string x_name;
  std::optional<double> x_line;  ///< a value to compare with
};
std::string dotPlot(const DotSpec& spec, const std::vector<DotRow>& rows);

/// Bars of parts, from 0. A row's text stands at its right.
struct BarRow {
  std::string name, text;
  struct Part {
    double value = 0.0;
    std::string color, tip;
  };
  std::vector<Part> parts;
};
std::string barPlot(const std::vector<BarRow>& rows);

}  // namespace culld::report
