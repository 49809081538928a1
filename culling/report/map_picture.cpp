// The frame from above, turned so that the camera looks up the page: footprints of all objects in
// the colour of their verdict, the frustum, and as a glow the places where the camera's rays end.
// What lies in the frustum and has no glow is what the scene itself hides.
#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <string>

#include "culling/oracle/view_rays.h"
#include "culling/report/canvas.h"

namespace culld::report {
namespace {

constexpr double kHeightOfWidth = 0.72;
constexpr std::uint32_t kRaysAcross = 960;
// Of the least side of a footprint: lower objects are ground, and are only tinted.
constexpr double kFlat = 0.08;
// Of the page: the larger an object beyond that (skies, hills), the fainter it is.
constexpr double kLarge = 0.004;
constexpr Color kGlow{1.0, 0.93, 0.66};

using Point = glm::dvec2;

/// World to page, seen against y.
class Map {
 public:
  Map(const FrameToDraw& frame, double width, double height) : page_(width, height) {
    const Camera& camera = frame.camera;
    eye_ = flat(camera.origin_world);
    const oracle::ViewRays rays(camera);
    if (const auto ahead = rays.through(0.0, 0.0)) {
      const Point direction = flat(ahead->direction);
      const double length = glm::length(direction);
      if (length > 1e-3 * glm::length(ahead->direction)) up_ = direction / length;
    }
    fit(frame);
  }

  Point at(const glm::dvec3& world) const { return place(turned(flat(world))); }
  double pixelsPerMetre() const { return scale_; }
  const Point& page() const { return page_; }

 private:
  static Point flat(const glm::dvec3& p) { return {p.x, p.z}; }
  Point turned(const Point& p) const {  // relative to the eye; +y is where the camera looks
    const Point d = p - eye_;
    return {d.y * up_.x - d.x * up_.y, glm::dot(d, up_)};
  }
  Point place(const Point& p) const {
    return {page_.x * 0.5 + (p.x - middle_.x) * scale_, page_.y * 0.5 - (p.y - middle_.y) * scale_};
  }
  /// Shows the eye, all that is seen, and nearly all that is in the frustum.
  void fit(const FrameToDraw& frame) {
    std::array<std::vector<double>, 2> spread;
    Point low(0.0), high(0.0);
    for (ObjectId id = 0; id < frame.verdicts.size(); ++id) {
      const Box& box = frame.scene->instance(id).bounds_world;
      if (frame.verdicts[id] == Verdict::kOutside || !box.finite()) continue;
      const Point p = turned(flat(0.5 * box.min + 0.5 * box.max));
      spread[0].push_back(p.x);
      spread[1].push_back(p.y);
    }
    for (int axis = 0; axis < 2; ++axis) {
      std::vector<double>& values = spread[static_cast<std::size_t>(axis)];
      if (values.empty()) continue;
      std::sort(values.begin(), values.end());
      const std::size_t cut = values.size() / 100;
      low[axis] = std::min(low[axis], values[cut]);
      high[axis] = std::max(high[axis], values[values.size() - 1 - cut]);
    }
    const Point size = glm::max(high - low, Point(1e-3));
    middle_ = 0.5 * (low + high);
    scale_ = 0.86 * std::min(page_.x / size.x, page_.y / size.y);
  }

  Point page_, eye_{0.0}, up_{0.0, -1.0}, middle_{0.0};
  double scale_ = 1.0;
};

std::vector<Point> hullOf(std::vector<Point> points) {  // A. Andrew, 1979
  std::sort(points.begin(), points.end(),
            [](const Point& a, const Point& b) { return a.x != b.x ? a.x < b.x : a.y < b.y; });
  std::vector<Point> hull;
  const auto half = [&hull](auto from, auto to) {
    const std::size_t start = hull.size();
    for (; from != to; ++from) {
      while (hull.size() >= start + 2) {
        const Point a = hull.back() - hull[hull.size() - 2], b = *from - hull.back();
        if (a.x * b.y - a.y * b.x > 0.0) break;
        hull.pop_back();
      }
      hull.push_back(*from);
    }
    hull.pop_back();
  };
  half(points.begin(), points.end());
  half(points.rbegin(), points.rend());
  return hull;
}

void tracePolygon(const Canvas& canvas, std::span<const Point> corners) {
  cairo_new_path(canvas.pen());
  for (const Point& corner : corners) cairo_line_to(canvas.pen(), corner.x, corner.y);
  cairo_close_path(canvas.pen());
}

void drawFrustum(const Canvas& canvas, const FrameToDraw& frame, const Map& map, bool filled) {
  const oracle::ViewRays rays(frame.camera);
  const double far_m = 2.0 * (map.page().x + map.page().y) / map.pixelsPerMetre();
  std::vector<Point> corners;
  for (const double x : {-1.0, 1.0}) {
    for (const double y : {-1.0, 1.0}) {
      const auto ray = rays.through(x, y);
      if (!ray) return;
      const double most = far_m / glm::length(ray->direction);
      for (const double t : {ray->t_min, std::min(ray->t_max, std::max(most, ray->t_min))}) {
        corners.push_back(map.at(frame.camera.origin_world + ray->origin + t * ray->direction));
      }
    }
  }
  const std::vector<Point> hull = hullOf(std::move(corners));
  tracePolygon(canvas, hull);
  if (filled) {
    canvas.color(kDusk);
    cairo_fill(canvas.pen());
  } else {
    canvas.color(kPaper.faded(0.65));
    cairo_set_line_width(canvas.pen(), 1.6);
    cairo_stroke(canvas.pen());
  }
}

struct Footprint {
  std::array<Point, 4> corners;
  double area = 0.0;
  bool flat = false;  ///< ground, roads: hides nothing and would cover the map
};

Footprint footprintOf(const Box& box, const Map& map) {
  const double y = box.max.y;
  const std::array<glm::dvec3, 4> world{{{box.min.x, y, box.min.z},
                                         {box.max.x, y, box.min.z},
                                         {box.max.x, y, box.max.z},
                                         {box.min.x, y, box.max.z}}};
  Footprint print;
  for (std::size_t i = 0; i < 4; ++i) print.corners[i] = map.at(world[i]);
  const Point a = print.corners[1] - print.corners[0], b = print.corners[3] - print.corners[0];
  print.area = std::abs(a.x * b.y - a.y * b.x);
  const double least_side = std::min(box.max.x - box.min.x, box.max.z - box.min.z);
  print.flat = box.max.y - box.min.y < kFlat * least_side;
  return print;
}

bool onPage(const Footprint& print, const Map& map) {
  Point low = print.corners[0], high = print.corners[0];
  for (const Point& corner : print.corners) {
    low = glm::min(low, corner);
    high = glm::max(high, corner);
  }
  return low.x < map.page().x && low.y < map.page().y && high.x > 0.0 && high.y > 0.0;
}

void drawFootprint(const Canvas& canvas, const Footprint& print, const Map& map, Color color) {
  constexpr double kLeastPx = 2.2;
  if (print.area < kLeastPx * kLeastPx) {
    const Point middle = 0.5 * (print.corners[0] + print.corners[2]);
    canvas.fillRect(middle.x - 0.5 * kLeastPx, middle.y - 0.5 * kLeastPx, kLeastPx, kLeastPx,
                    color.faded(0.9));
    return;
  }
  const double share = print.area / (map.page().x * map.page().y);
  const double strength =
      (print.flat ? 0.16 : 0.72) * std::clamp(kLarge / std::max(share, kLarge), 0.05, 1.0);
  tracePolygon(canvas, print.corners);
  canvas.color(color.faded(strength));
  cairo_fill_preserve(canvas.pen());
  canvas.color(mixed(color, kNight, 0.25).faded(strength < 0.3 ? 0.35 : 0.9));
  cairo_set_line_width(canvas.pen(), 0.8);
  cairo_stroke(canvas.pen());
}

void drawObjects(const Canvas& canvas, const FrameToDraw& frame, const Map& map, Verdict verdict) {
  std::vector<Footprint> prints;
  for (ObjectId id = 0; id < frame.verdicts.size(); ++id) {
    const Instance& instance = frame.scene->instance(id);
    if (frame.verdicts[id] != verdict || !instance.active()) continue;
    if (!instance.bounds_world.finite()) continue;
    const Footprint print = footprintOf(instance.bounds_world, map);
    if (onPage(print, map)) prints.push_back(print);
  }
  std::stable_sort(prints.begin(), prints.end(),
                   [](const Footprint& a, const Footprint& b) { return a.area > b.area; });
  for (const Footprint& print : prints) drawFootprint(canvas, print, map, colorOf(verdict));
  if (verdict != Verdict::kMissed) return;
  cairo_set_line_width(canvas.pen(), 3.0);
  for (const Footprint& print : prints) {
    const Point middle = 0.5 * (print.corners[0] + print.corners[2]);
    canvas.color(colorOf(verdict));
    cairo_arc(canvas.pen(), middle.x, middle.y, 14.0, 0.0, 6.3);
    cairo_stroke(canvas.pen());
  }
}

/// Where the camera's rays end, brighter where more of them do.
Result<void> drawGlow(const Canvas& canvas, const FrameToDraw& frame, const Map& map) {
  Camera camera = frame.camera;
  camera.height_px = std::max(1U, camera.height_px * kRaysAcross / camera.width_px);
  camera.width_px = kRaysAcross;
  const auto pixels = frame.oracle->paint(camera);
  if (!pixels) return pixels.error();
  const oracle::ViewRays rays(camera);
  const auto width = static_cast<std::uint32_t>(map.page().x);
  const auto height = static_cast<std::uint32_t>(map.page().y);
  std::vector<float> light(std::size_t{width} * height);
  for (std::uint32_t i = 0; i < pixels.value().size(); ++i) {
    const OraclePixel& pixel = pixels.value()[i];
    if (pixel.object == kNoObject) continue;
    const std::uint32_t column = i % camera.width_px, row = i / camera.width_px;
    const double x = (column + 0.5) / camera.width_px * 2.0 - 1.0;
    const double y = 1.0 - (row + 0.5) / camera.height_px * 2.0;
    const auto ray = rays.through(x, y);
    if (!ray) continue;
    const glm::dvec3 end = camera.origin_world + ray->origin +
                           ray->direction * (pixel.distance_m / glm::length(ray->direction));
    const Point place = map.at(end);
    if (!(place.x >= 0.0 && place.y >= 0.0 && place.x < width && place.y < height)) continue;
    light[static_cast<std::size_t>(place.y) * width + static_cast<std::size_t>(place.x)] += 1.0F;
  }
  std::vector<std::uint32_t> glow(light.size());
  std::transform(light.begin(), light.end(), glow.begin(), [](float hits) {
    return packed(kGlow.faded(hits > 0.0F ? 0.25 + 0.6 * (1.0 - std::exp(-0.12 * hits)) : 0.0));
  });
  canvas.image(glow, width, height, 1.0);
  return Done{};
}

void drawEyeAndScale(const Canvas& canvas, const FrameToDraw& frame, const Map& map) {
  const double unit = canvas.width() / 1280.0;
  const Point eye = map.at(frame.camera.origin_world);
  canvas.color(kNight);
  cairo_arc(canvas.pen(), eye.x, eye.y, 8.0 * unit, 0.0, 6.3);
  cairo_fill(canvas.pen());
  canvas.color(kPaper);
  cairo_arc(canvas.pen(), eye.x, eye.y, 5.5 * unit, 0.0, 6.3);
  cairo_fill(canvas.pen());
  // The longest of 1, 2, 5 * 10^n metres that fits into a sixth of the page.
  const double room_m = canvas.width() / 6.0 / map.pixelsPerMetre();
  double length_m = std::pow(10.0, std::floor(std::log10(room_m)));
  for (const double step : {5.0, 2.0}) {
    if (step * length_m <= room_m) {
      length_m *= step;
      break;
    }
  }
  std::array<char, 32> label{};
  std::snprintf(label.data(), label.size(), length_m < 1000.0 ? "%g m" : "%g km",
                length_m < 1000.0 ? length_m : length_m / 1000.0);
  const double bar = length_m * map.pixelsPerMetre();
  const double strip = map.page().y - 30.0 * unit, line = map.page().y - 9.0 * unit;
  canvas.fillRect(0, strip, canvas.width(), 30.0 * unit, kNight.faded(0.82));
  canvas.text(22.0 * unit, line, 13.0 * unit, kPaper,
              "From above. White dot: the camera, looking up the page. Glow: where its rays end. "
              "In the frustum without glow: hidden.");
  const double right = canvas.width() - 22.0 * unit;
  canvas.fillRect(right - bar, line + 1.0 * unit, bar, 2.5 * unit, kPaper);
  canvas.text(right - bar, line - 4.0 * unit, 13.0 * unit, kPaper, label.data());
}

}  // namespace
}  // namespace culld::report

namespace culld {

Result<void> drawFromAbove(const FrameToDraw& frame, const std::string& path_png,
                           std::uint32_t width_px) {
  const auto height_px = static_cast<std::uint32_t>(width_px * report::kHeightOfWidth);
  const auto footer_px = static_cast<std::uint32_t>(report::kFooterPx * (width_px / 1280.0));
  const report::Canvas canvas(width_px, height_px + footer_px);
  const report::Map map(frame, width_px, height_px);
  report::drawFrustum(canvas, frame, map, true);
  for (const Verdict verdict :
       {Verdict::kOutside, Verdict::kLeftOut, Verdict::kKept, Verdict::kSeen}) {
    report::drawObjects(canvas, frame, map, verdict);
  }
  report::drawFrustum(canvas, frame, map, false);
  if (auto drawn = report::drawGlow(canvas, frame, map); !drawn) return std::move(drawn).error();
  report::drawObjects(canvas, frame, map, Verdict::kMissed);
  report::drawEyeAndScale(canvas, frame, map);
  canvas.footer(frame);
  return canvas.save(path_png);
}

}  // namespace culld
