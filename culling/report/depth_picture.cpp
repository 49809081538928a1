#include "culling/report/depth_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "culling/report/canvas.h"

namespace culld {
namespace {

using report::Canvas;
using report::Color;

constexpr std::array<Color, 5> kScale{{{0.160, 0.250, 0.480},
                                       {0.120, 0.480, 0.620},
                                       {0.230, 0.740, 0.480},
                                       {0.800, 0.820, 0.240},
                                       {1.000, 0.960, 0.780}}};

/// `most` has the last colour, 1 the first, and each doubling is a step of the same size.
Color colorFor(std::uint32_t surfaces, std::uint32_t most) {
  if (surfaces == 0) return report::kNight;
  const double steps = std::log2(std::max(static_cast<double>(most), 2.0));
  const double along = std::log2(static_cast<double>(surfaces)) / steps * (kScale.size() - 1);
  const auto from = std::min(static_cast<std::size_t>(along), kScale.size() - 2);
  return report::mixed(kScale[from], kScale[from + 1], along - static_cast<double>(from));
}

void drawLegend(const Canvas& canvas, const DepthToDraw& depth, std::uint32_t most) {
  const double unit = canvas.width() / 1280.0, top = canvas.height() - report::kFooterPx * unit;
  const double left = 22 * unit, line = top + 63 * unit;
  canvas.text(left, top + 32 * unit, 17 * unit, report::kPaper, depth.title, true);
  double x =
      left + canvas.text(left, line, 14 * unit, report::kQuiet, "surfaces in a pixel:") + 16 * unit;
  const auto entry = [&](std::uint32_t surfaces) {
    canvas.fillRect(x, line - 12 * unit, 14 * unit, 14 * unit, colorFor(surfaces, most));
    x += 20 * unit;
    x += canvas.text(x, line, 15 * unit, report::kPaper, report::grouped(surfaces)) + 18 * unit;
  };
  for (std::uint64_t surfaces = 1; surfaces < most; surfaces *= 2) {
    entry(static_cast<std::uint32_t>(surfaces));
  }
  if (most != 0) entry(most);
}

}  // namespace

Result<void> drawDepth(const DepthToDraw& depth, const std::string& path_png) {
  const std::uint32_t most =
      depth.surfaces.empty() ? 0 : *std::max_element(depth.surfaces.begin(), depth.surfaces.end());
  std::vector<std::uint32_t> colors;
  colors.reserve(depth.surfaces.size());
  for (const std::uint32_t surfaces : depth.surfaces) {
    colors.push_back(report::packed(colorFor(surfaces, most)));
  }
  const double unit = depth.width_px / 1280.0;
  const auto footer = static_cast<std::uint32_t>(std::ceil(report::kFooterPx * unit));
  const Canvas canvas(depth.width_px, depth.height_px + footer);
  canvas.image(colors, depth.width_px, depth.height_px, 1.0);
  drawLegend(canvas, depth, most);
  return canvas.save(path_png);
}

}  // namespace culld
