#include "culling/report/plot.h"

#include <algorithm>
#include <cmath>

namespace culld::report {
namespace {

constexpr double kWidth = 440, kHeight = 290;
constexpr double kLeft = 52, kRight = 430, kTop = 28, kBottom = 246;
constexpr double kMarkerRadius = 5;

std::string line(double x1, double y1, double x2, double y2, const std::string& look) {
  return "<line x1=\"" + coordinate(x1) + "\" y1=\"" + coordinate(y1) + "\" x2=\"" +
         coordinate(x2) + "\" y2=\"" + coordinate(y2) + "\" " + look + "/>";
}

std::string text(double x, double y, const char* kind, const std::string& words) {
  return "<text x=\"" + coordinate(x) + "\" y=\"" + coordinate(y) + "\" class=\"" + kind + "\">" +
         escaped(words) + "</text>";
}

std::string opening(double width, double height, const std::string& about) {
  return "<svg viewBox=\"0 0 " + coordinate(width) + " " + coordinate(height) +
         "\" role=\"img\" aria-label=\"" + escaped(about) + "\">";
}

std::string stroke(const Style& style, double width) {
  std::string look = std::string("fill=\"none\" stroke=\"") + style.color + "\" stroke-width=\"" +
                     coordinate(width) + "\"";
  if (*style.dash != '\0') look += std::string(" stroke-dasharray=\"") + style.dash + "\"";
  return look;
}

/// Frame, ticks, grid and names of a plot with two axes.
std::string axes(const PlotSpec& spec, const Axis& x, const Axis& y) {
  std::string svg;
  double last_px = -1e9;
  for (const Tick& tick : x.ticks()) {
    const double px = x.at(tick.value);
    if (px < kLeft - 0.1 || px > kRight + 0.1) continue;
    svg += line(px, kTop, px, kBottom, "class=\"grid\"");
    const double half = 3.4 * static_cast<double>(tick.label.size()) + 3.0;
    if (px - half < last_px) continue;  // its number would run into the one before
    svg += text(px, kBottom + 16, "tick mid", tick.label);
    last_px = px + half;
  }
  for (const Tick& tick : y.ticks()) {
    const double py = y.at(tick.value);
    if (py < kTop - 0.1 || py > kBottom + 0.1) continue;
    const bool zero = y.hasZeroPlace() && tick.value == 0.0;
    svg += line(kLeft, py, kRight, py, zero ? "class=\"zero\"" : "class=\"grid\"");
    svg += text(kLeft - 6, py + 4, zero ? "tick end strong" : "tick end", tick.label);
  }
  if (y.hasZeroPlace()) {
    const double py = y.breakAt();
    for (const double shift : {-2.5, 2.5}) {
      svg += line(kLeft - 5, py + shift + 3, kLeft + 5, py + shift - 3, "class=\"axis\"");
    }
  }
  svg += line(kLeft, kTop, kLeft, kBottom, "class=\"axis\"");
  svg += line(kLeft, kBottom, kRight, kBottom, "class=\"axis\"");
  svg += text(0.5 * (kLeft + kRight), kHeight - 8, "name mid", spec.x_name);
  svg += text(4, 14, "name", spec.y_name);
  return svg;
}

/// Finds room for words beside markers.
class Labels {
 public:
  void block(double left, double right, double y, double half) {
    taken_.push_back({left - half, y - half, right + half, y + half});
  }
  std::string place(double x, double y, const std::string& words) {
    const double width = 5.6 * static_cast<double>(words.size());
    const Rect spots[] = {{x - width / 2, y - 21, x + width / 2, y - 9},
                          {x - width / 2, y + 9, x + width / 2, y + 21},
                          {x + 9, y - 6, x + 9 + width, y + 6},
                          {x - 9 - width, y - 6, x - 9, y + 6},
                          {x, y - 21, x + width, y - 9},
                          {x - width, y - 21, x, y - 9},
                          {x, y + 9, x + width, y + 21},
                          {x - width, y + 9, x, y + 21}};
    for (const Rect& spot : spots) {
      const bool inside = spot.left > kLeft && spot.right < kRight + 6 && spot.top > kTop - 4 &&
                          spot.bottom < kBottom;
      if (!inside || std::any_of(taken_.begin(), taken_.end(),
                                 [&](const Rect& other) { return other.meets(spot); })) {
        continue;
      }
      taken_.push_back(spot);
      return text(spot.left, spot.bottom - 2, "point", words);
    }
    return "";
  }

 private:
  struct Rect {
    double left, top, right, bottom;
    bool meets(const Rect& o) const {
      return left < o.right && o.left < right && top < o.bottom && o.top < bottom;
    }
  };
  std::vector<Rect> taken_;
};

std::string frontLine(const std::vector<PlotSeries>& series, const Axis& x, const Axis& y) {
  std::vector<const PlotPoint*> front;
  for (const PlotSeries& one : series) {
    for (const PlotPoint& point : one.points) {
      if (point.on_front) front.push_back(&point);
    }
  }
  if (front.empty()) return "";
  std::sort(front.begin(), front.end(),
            [](const PlotPoint* a, const PlotPoint* b) { return a->x < b->x; });
  std::string path = "M" + coordinate(x.at(front[0]->x)) + " " + coordinate(kTop);
  for (const PlotPoint* point : front) {
    path += "H" + coordinate(x.at(point->x)) + "V" + coordinate(y.at(point->y));
  }
  path += "H" + coordinate(kRight);
  return "<path class=\"front\" d=\"" + path + "\"/>";
}

std::string pointOf(const PlotPoint& point, std::size_t style, const Axis& x, const Axis& y) {
  const double px = x.at(point.x), py = y.at(point.y);
  std::string svg = "<g><title>" + escaped(point.tip) + "</title>";
  if (point.on_front) {
    svg += "<circle class=\"halo\" cx=\"" + coordinate(px) + "\" cy=\"" + coordinate(py) +
           "\" r=\"12\"/>";
  }
  if (point.x_high > point.x_low) {
    const double low = x.at(point.x_low), high = x.at(point.x_high);
    const std::string look =
        std::string("stroke=\"") + styleOf(style).color + "\" stroke-width=\"1.5\"";
    svg += line(low, py, high, py, look);
    svg += line(low, py - 4, low, py + 4, look) + line(high, py - 4, high, py + 4, look);
  }
  return svg + marker(style, px, py, kMarkerRadius) + "</g>";
}

std::string curveOf(const PlotSeries& series, const Axis& x, const Axis& y) {
  if (series.points.size() < 2) return "";
  std::vector<const PlotPoint*> order;
  for (const PlotPoint& point : series.points) order.push_back(&point);
  std::stable_sort(order.begin(), order.end(),
                   [](const PlotPoint* a, const PlotPoint* b) { return a->x < b->x; });
  std::string corners;
  for (const PlotPoint* point : order) {
    corners += coordinate(x.at(point->x)) + "," + coordinate(y.at(point->y)) + " ";
  }
  return "<polyline points=\"" + corners + "\" " + stroke(styleOf(series.style), 1.5) + "/>";
}

}  // namespace

std::string pointPlot(const PlotSpec& spec, const std::vector<PlotSeries>& series) {
  std::vector<double> xs, ys;
  for (const PlotSeries& one : series) {
    for (const PlotPoint& point : one.points) {
      xs.insert(xs.end(), {point.x, point.x_low, point.x_high});
      ys.push_back(point.y);
    }
  }
  if (spec.y_line) ys.push_back(*spec.y_line);
  const Axis x(spec.x_kind, xs, kLeft, kRight), y(spec.y_kind, ys, kBottom, kTop);
  std::string svg = opening(kWidth, kHeight, spec.y_name + " against " + spec.x_name);
  svg += axes(spec, x, y);
  if (spec.y_line) {
    const double py = y.at(*spec.y_line);
    svg += line(kLeft, py, kRight, py, "class=\"compare\"");
    svg += text(kRight - 4, py - 5, "point end", spec.y_line_name);
  }
  if (!spec.words.empty()) {
    svg += text(0.5 * (kLeft + kRight), 0.5 * (kTop + kBottom), "words mid", spec.words);
  }
  if (spec.front) svg += frontLine(series, x, y);
  for (const PlotSeries& one : series) svg += curveOf(one, x, y);
  Labels labels;
  for (const PlotSeries& one : series) {
    for (const PlotPoint& point : one.points) {
      svg += pointOf(point, one.style, x, y);
      labels.block(x.at(point.x), x.at(point.x), y.at(point.y), 7);
      labels.block(x.at(point.x_low), x.at(point.x_high), y.at(point.y), 2);
    }
  }
  for (const PlotSeries& one : series) {
    for (const PlotPoint& point : one.points) {
      if (!point.label.empty()) svg += labels.place(x.at(point.x), y.at(point.y), point.label);
    }
  }
  return svg + "</svg>";
}

std::string bandPlot(const PlotSpec& spec, const std::vector<BandSeries>& series) {
  std::vector<double> xs, ys;
  for (const BandSeries& one : series) {
    xs.insert(xs.end(), one.x.begin(), one.x.end());
    ys.insert(ys.end(), one.low.begin(), one.low.end());
    ys.insert(ys.end(), one.high.begin(), one.high.end());
  }
  const Axis x(spec.x_kind, xs, kLeft, kRight), y(spec.y_kind, ys, kBottom, kTop);
  std::string svg = opening(kWidth, kHeight, spec.y_name + " against " + spec.x_name);
  svg += axes(spec, x, y);
  for (const BandSeries& one : series) {
    const Style style = styleOf(one.style);
    std::string upper, lower, middle;
    for (std::size_t i = 0; i < one.x.size(); ++i) {
      const std::string px = coordinate(x.at(one.x[i])) + ",";
      upper += px + coordinate(y.at(one.high[i])) + " ";
      lower.insert(0, px + coordinate(y.at(one.low[i])) + " ");
      middle += px + coordinate(y.at(one.middle[i])) + " ";
    }
    if (one.x.size() == 1) {
      svg += line(x.at(one.x[0]), y.at(one.low[0]), x.at(one.x[0]), y.at(one.high[0]),
                  stroke(style, 1.5));
      svg += marker(one.style, x.at(one.x[0]), y.at(one.middle[0]), kMarkerRadius);
      continue;
    }
    svg += "<polygon points=\"" + upper + lower + "\" fill=\"" + style.color +
           "\" fill-opacity=\"0.16\"/>";
    svg += "<polyline points=\"" + middle + "\" " + stroke(style, 1.8) + "/>";
  }
  return svg + "</svg>";
}

std::string dotPlot(const DotSpec& spec, const std::vector<DotRow>& rows) {
  constexpr double kRow = 34, kFrom = 10;
  const double bottom = 8 + kRow * static_cast<double>(rows.size());
  std::vector<double> xs;
  if (spec.x_line) xs.push_back(*spec.x_line);
  for (const DotRow& row : rows) {
    for (const DotRow::Dot& dot : row.dots) xs.insert(xs.end(), {dot.x, dot.x_low, dot.x_high});
  }
  const Axis x(Axis::Kind::kLog, xs, kFrom, kRight);
  std::string svg = opening(kWidth, bottom + 42, spec.x_name);
  double last_px = -1e9;
  for (const Tick& tick : x.ticks()) {
    const double px = x.at(tick.value);
    svg += line(px, 4, px, bottom, "class=\"grid\"");
    const double half = 3.4 * static_cast<double>(tick.label.size()) + 3.0;
    if (px - half < last_px) continue;
    svg += text(std::max(px, kFrom + 6), bottom + 16, "tick mid", tick.label);
    last_px = px + half;
  }
  if (spec.x_line)
    svg += line(x.at(*spec.x_line), 4, x.at(*spec.x_line), bottom, "class=\"compare\"");
  svg += line(kFrom, bottom, kRight, bottom, "class=\"axis\"");
  svg += text(0.5 * (kFrom + kRight), bottom + 36, "name mid", spec.x_name);
  double top = 4;
  for (const DotRow& row : rows) {
    const double py = top + 24;
    svg += text(kFrom, top + 12, "row", row.name);
    svg += line(kFrom, py, kRight, py, "class=\"rail\"");
    for (const DotRow::Dot& dot : row.dots) {
      PlotPoint point{dot.x, dot.x_low, dot.x_high, 0.0, "", dot.tip, false};
      const Axis here(Axis::Kind::kLinear, {-1.0, 1.0}, py + 1, py - 1);
      svg += pointOf(point, dot.style, x, here);
    }
    top += kRow;
  }
  return svg + "</svg>";
}

std::string barPlot(const std::vector<BarRow>& rows) {
  constexpr double kRow = 40, kBar = 15;
  double most = 0.0;
  for (const BarRow& row : rows) {
    double sum = 0.0;
    for (const BarRow::Part& part : row.parts) sum += std::max(0.0, part.value);
    most = std::max(most, sum);
  }
  std::string svg = opening(kWidth, kRow * static_cast<double>(rows.size()) + 4, "bars");
  double top = 2;
  for (const BarRow& row : rows) {
    svg += text(4, top + 13, "row", row.name) + text(kRight, top + 13, "value end", row.text);
    double left = 4;
    for (const BarRow::Part& part : row.parts) {
      const double width = most > 0.0 ? (kRight - 4) * std::max(0.0, part.value) / most : 0.0;
      svg += "<rect x=\"" + coordinate(left) + "\" y=\"" + coordinate(top + 18) + "\" width=\"" +
             coordinate(width) + "\" height=\"" + coordinate(kBar) + "\" fill=\"" + part.color +
             "\" stroke=\"#fff\" stroke-width=\"0.7\"><title>" + escaped(part.tip) +
             "</title></rect>";
      left += width;
    }
    top += kRow;
  }
  return svg + "</svg>";
}

}  // namespace culld::report
