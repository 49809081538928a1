#include "tests/cases/curve_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>

#include "culling/report/svg.h"

namespace culld::cases {
namespace {

using report::Axis;
using report::coordinate;
using report::escaped;

constexpr double kPanelWidth = 300, kPanelHeight = 200, kLeft = 62, kTop = 58, kBottom = 70;
constexpr double kLegendWidth = 150, kLegendLine = 17;
constexpr double kNever = 14;  // pixels above the plot, for what is not left out at all

struct Panel {
  std::string name;
  Axis::Kind kind;
  bool has_never;
  /// By step and method; not finite: never, NaN or negative: no such point.
  std::function<double(const CurveStep&, std::size_t)> value;
};

std::string stepLabel(double value) {
  if (std::isinf(value)) return "\u221e";
  char text[32];
  std::snprintf(text, sizeof text, "%.7g", value);
  return text;
}

std::string text(double x, double y, const std::string& line, const std::string& more = "") {
  return "<text x=\"" + coordinate(x) + "\" y=\"" + coordinate(y) + "\"" + more + ">" +
         escaped(line) + "</text>\n";
}

std::string rule(double x0, double y0, double x1, double y1, const std::string& color) {
  return "<path d=\"M" + coordinate(x0) + " " + coordinate(y0) + "L" + coordinate(x1) + " " +
         coordinate(y1) + "\" stroke=\"" + color + "\" fill=\"none\"/>\n";
}

bool drawable(double value, Axis::Kind kind) {
  return std::isfinite(value) && (kind == Axis::Kind::kLog ? value > 0.0 : value >= 0.0);
}

class PanelDrawing {
 public:
  PanelDrawing(const Curve& curve, const Panel& panel, double left)
      : curve_(curve), panel_(panel), left_(left), axis_(panel.kind, values(), bottom(), kTop + 6) {
    drawAxes();
    for (std::size_t m = 0; m < curve.steps.front().run.methods.size(); ++m) drawMethod(m);
  }
  std::string take() { return std::move(svg_); }

 private:
  static double bottom() { return kTop + kPanelHeight; }
  double right() const { return left_ + kPanelWidth; }
  double xOf(std::size_t step) const {
    const auto steps = static_cast<double>(curve_.steps.size());
    return left_ + (static_cast<double>(step) + 0.5) / steps * kPanelWidth;
  }

  std::vector<double> values() const {
    std::vector<double> all;
    if (panel_.kind == Axis::Kind::kLinear) all.push_back(0.0);
    for (const CurveStep& step : curve_.steps) {
      for (std::size_t m = 0; m < step.run.methods.size(); ++m) {
        const double value = panel_.value(step, m);
        if (drawable(value, panel_.kind)) all.push_back(value);
      }
    }
    return all;
  }

  void drawAxes() {
    svg_ += text(left_, kTop - 24, panel_.name, " font-weight=\"bold\"");
    for (const report::Tick& tick : axis_.ticks()) {
      const double y = axis_.at(tick.value);
      svg_ += rule(left_, y, right(), y, "#e3e6ea");
      svg_ += text(left_ - 6, y + 4, tick.label, " text-anchor=\"end\"");
    }
    svg_ += rule(left_, bottom(), right(), bottom(), "#8a93a0");
    if (panel_.has_never) {
      svg_ += text(left_ - 6, kTop - kNever + 10, "never", " text-anchor=\"end\"");
    }
    for (std::size_t i = 0; i < curve_.steps.size(); ++i) {
      const std::string at = coordinate(xOf(i)) + " " + coordinate(bottom() + 14);
      svg_ += text(xOf(i), bottom() + 14, stepLabel(curve_.steps[i].value),
                   " text-anchor=\"end\" transform=\"rotate(-40 " + at + ")\"");
    }
  }

  void drawMethod(std::size_t method) {
    const report::Style style = report::styleOf(method);
    std::string path, markers;
    bool pen_down = false;
    for (std::size_t i = 0; i < curve_.steps.size(); ++i) {
      const double value = panel_.value(curve_.steps[i], method);
      const bool never = std::isinf(value) && panel_.has_never;
      if (!never && !drawable(value, panel_.kind)) {
        pen_down = false;
        continue;
      }
      const double x = xOf(i), y = never ? kTop - kNever + 6 : axis_.at(value);
      path += (pen_down ? "L" : "M") + coordinate(x) + " " + coordinate(y);
      markers += report::marker(method, x, y, 3.5);
      pen_down = true;
    }
    svg_ += "<path d=\"" + path + "\" fill=\"none\" stroke=\"" + style.color +
            "\" stroke-width=\"1.6\" stroke-dasharray=\"" + style.dash + "\"/>\n" + markers + "\n";
  }

  const Curve& curve_;
  const Panel& panel_;
  double left_;
  Axis axis_;
  std::string svg_;
};

std::vector<Panel> panelsOf(const Curve& curve) {
  std::vector<Panel> panels{
      {"share of the answer that is not seen", Axis::Kind::kLinear, false,
       [](const CurveStep& step, std::size_t m) {
         return static_cast<double>(step.run.methods[m].excess) /
                static_cast<double>(std::max<std::size_t>(1, step.run.methods[m].answered));
       }},
      {"time per answer (\u00b5s)", Axis::Kind::kLog, false,
       [](const CurveStep& step, std::size_t m) {
         return step.run.methods[m].time_us / static_cast<double>(step.run.looks);
       }}};
  if (curve.steps.front().slack_ulps.front() != kNoSlack) {
    panels.push_back({"depth slack (float ulps)", Axis::Kind::kLog, true,
                      [](const CurveStep& step, std::size_t m) { return step.slack_ulps[m]; }});
  }
  return panels;
}

}  // namespace

std::string pictureOf(const Curve& curve) {
  const std::vector<Panel> panels = panelsOf(curve);
  const double width =
      static_cast<double>(panels.size()) * (kPanelWidth + kLeft + 14) + kLegendWidth;
  const double height = kTop + kPanelHeight + kBottom;
  std::string svg = "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" + coordinate(width) +
                    "\" height=\"" + coordinate(height) +
                    "\" font-family=\"sans-serif\" font-size=\"11\" fill=\"#2b323b\">\n"
                    "<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n";
  std::size_t missed = 0;
  for (const CurveStep& step : curve.steps) {
    for (const MethodRun& run : step.run.methods) missed += run.missed;
  }
  const Family& family = *curve.family;
  std::string quantity(family.quantity);
  if (!family.unit.empty()) quantity += " (" + std::string(family.unit) + ")";
  svg += text(kLeft, 18, std::string(family.name) + ": objects missed " + std::to_string(missed),
              " font-size=\"13\"");
  const auto& methods = curve.steps.front().run.methods;
  for (std::size_t m = 0; m < methods.size(); ++m) {
    const double y = kTop + kLegendLine * static_cast<double>(m);
    svg += report::marker(m, width - kLegendWidth + 6, y, 4) + "\n";
    svg += text(width - kLegendWidth + 18, y + 4, methods[m].method);
  }
  for (std::size_t p = 0; p < panels.size(); ++p) {
    const double left = kLeft + static_cast<double>(p) * (kPanelWidth + kLeft + 14);
    svg += PanelDrawing(curve, panels[p], left).take();
    svg += text(left + kPanelWidth / 2, height - 8, quantity, " text-anchor=\"middle\"");
  }
  return svg + "</svg>\n";
}

}  // namespace culld::cases
