// The frame as the camera sees it. Surfaces are shaded by rays in the colour of their verdict; what
// is hidden is drawn through them: outlines of boxes for what was kept, specks for what was left
// out.
#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>

#include "culling/report/canvas.h"

namespace culld::report {
namespace {

constexpr std::uint32_t kOversampling = 2;
// Seen objects vary from their verdict's colour towards this one, so that neighbours differ.
constexpr Color kSeenToo{0.170, 0.560, 0.680};
// More boxes than this become specks: outlines would be a scribble.
constexpr std::size_t kMaxLeftOutBoxes = 250;
constexpr std::size_t kMaxKeptBoxes = 4000;

double varied(ObjectId object) {  // 0 to 1
  return static_cast<double>((object * 2654435761U) >> 20U) / 4095.0;
}

class Painter {
 public:
  Painter(const FrameToDraw& frame, std::span<const OraclePixel> pixels, std::uint32_t width_px,
          std::uint32_t height_px)
      : frame_(frame), pixels_(pixels), width_px_(width_px), height_px_(height_px) {
    std::vector<float> distances;
    for (const OraclePixel& pixel : pixels) {
      if (pixel.object != kNoObject) distances.push_back(pixel.distance_m);
    }
    if (distances.empty()) return;
    const auto far = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() * 3 / 4);
    std::nth_element(distances.begin(), far, distances.end());
    haze_distance_m_ = std::max(*far, 1e-6F);
  }

  std::vector<std::uint32_t> paint() const {
    std::vector<std::uint32_t> colors(pixels_.size());
    for (std::uint32_t row = 0; row < height_px_; ++row) {
      for (std::uint32_t column = 0; column < width_px_; ++column) {
        Color color = shaded(at(row, column), row);
        if (onOutline(row, column)) color = mixed(color, kNight, 0.55);
        colors[std::size_t{row} * width_px_ + column] = packed(color);
      }
    }
    return colors;
  }

 private:
  const OraclePixel& at(std::uint32_t row, std::uint32_t column) const {
    return pixels_[std::size_t{row} * width_px_ + column];
  }
  Color sky(std::uint32_t row) const {
    return mixed(kNight, kDusk, static_cast<double>(row) / height_px_);
  }
  bool onOutline(std::uint32_t row, std::uint32_t column) const {
    const OraclePixel& here = at(row, column);
    const auto differs = [&here](const OraclePixel& other) {
      if (here.object != other.object) return true;
      return glm::dot(here.normal_world, other.normal_world) < 0.7F && here.object != kNoObject;
    };
    return (column + 1 < width_px_ && differs(at(row, column + 1))) ||
           (row + 1 < height_px_ && differs(at(row + 1, column)));
  }
  Color shaded(const OraclePixel& pixel, std::uint32_t row) const {
    if (pixel.object == kNoObject) return sky(row);
    // A pixel's centre may show what the oracle's samples beside it did not: that is seen, too.
    const Verdict verdict = frame_.verdicts[pixel.object];
    const Color base = verdict == Verdict::kMissed
                           ? colorOf(verdict)
                           : mixed(colorOf(Verdict::kSeen), kSeenToo, 0.5 * varied(pixel.object));
    const glm::vec3 light(0.37F, 0.82F, 0.44F);
    const double lit = 0.5 + 0.5 * static_cast<double>(glm::dot(pixel.normal_world, light));
    const double strength = (0.30 + 0.62 * lit) * (0.85 + 0.20 * varied(pixel.object ^ 0x5555U));
    const Color surface = mixed(kNight, base, std::min(1.0, strength));
    const double haze = pixel.distance_m / (pixel.distance_m + 2.5 * haze_distance_m_);
    return mixed(surface, mixed(kDusk, kQuiet, 0.25), 0.75 * haze);
  }

  const FrameToDraw& frame_;
  std::span<const OraclePixel> pixels_;
  std::uint32_t width_px_, height_px_;
  double haze_distance_m_ = 1.0;
};

/// Draws boxes where the camera sees them, whatever stands before them.
class BoxPen {
 public:
  BoxPen(const Canvas& canvas, const FrameToDraw& frame, double width, double height)
      : canvas_(canvas), frame_(frame), width_(width), height_(height) {}

  void outline(ObjectId object, const Color& color) const {
    const Box& box = frame_.scene->instance(object).bounds_world;
    if (!box.finite()) return;
    canvas_.color(color);
    for (unsigned from = 0; from < 8; ++from) {
      for (unsigned axis = 1; axis < 8; axis <<= 1U) {
        if ((from & axis) == 0) edge(clip(box, from), clip(box, from | axis));
      }
    }
    cairo_stroke(canvas_.pen());
  }
  void speck(ObjectId object, const Color& color) const {
    const Box& box = frame_.scene->instance(object).bounds_world;
    const glm::dvec4 middle = 0.5 * clip(box, 0) + 0.5 * clip(box, 7);
    if (!box.finite() || !(middle.w > 0.0)) return;
    canvas_.color(color);
    const glm::dvec2 place = image(middle);
    cairo_arc(canvas_.pen(), place.x, place.y, std::max(1.0, 1.3 * width_ / 1280.0), 0, 6.3);
    cairo_fill(canvas_.pen());
  }

 private:
  glm::dvec4 clip(const Box& box, unsigned corner) const {
    const Camera& c = frame_.camera;
    const glm::dvec3 p((corner & 1U) != 0 ? box.max.x : box.min.x,
                       (corner & 2U) != 0 ? box.max.y : box.min.y,
                       (corner & 4U) != 0 ? box.max.z : box.min.z);
    const glm::dvec4 q(p - c.origin_world, 1.0);
    return {glm::dot(c.x_row, q), glm::dot(c.y_row, q), glm::dot(c.z_row, q), glm::dot(c.w_row, q)};
  }
  glm::dvec2 image(const glm::dvec4& p) const {
    return {(p.x / p.w * 0.5 + 0.5) * width_, (0.5 - p.y / p.w * 0.5) * height_};
  }
  void edge(glm::dvec4 a, glm::dvec4 b) const {
    const double nearest = 1e-6 * std::max(std::abs(a.w), std::abs(b.w));
    if (a.w < nearest && b.w < nearest) return;
    if (a.w < nearest) a = a + (b - a) * ((nearest - a.w) / (b.w - a.w));
    if (b.w < nearest) b = b + (a - b) * ((nearest - b.w) / (a.w - b.w));
    const glm::dvec2 from = image(a), to = image(b);
    // What is far out of the picture would only tire cairo's fixed-point numbers.
    const double limit = 20.0 * (width_ + height_);
    if (!(glm::length(from) < limit && glm::length(to) < limit)) return;
    cairo_move_to(canvas_.pen(), from.x, from.y);
    cairo_line_to(canvas_.pen(), to.x, to.y);
  }

  const Canvas& canvas_;
  const FrameToDraw& frame_;
  double width_, height_;
};

void drawHidden(const Canvas& canvas, const FrameToDraw& frame, double height) {
  const auto count = [&](Verdict v) {
    return static_cast<std::size_t>(std::count(frame.verdicts.begin(), frame.verdicts.end(), v));
  };
  const std::size_t left_out = count(Verdict::kLeftOut), kept = count(Verdict::kKept);
  const double crowd = std::clamp(3000.0 / static_cast<double>(left_out + 1), 0.5, 1.0);
  const BoxPen pen(canvas, frame, canvas.width(), height);
  const auto each = [&](Verdict verdict, const auto& draw) {
    for (ObjectId id = 0; id < frame.verdicts.size(); ++id) {
      if (frame.verdicts[id] == verdict) draw(id);
    }
  };
  const double line = std::max(1.0, canvas.width() / 1280.0);
  cairo_set_line_width(canvas.pen(), line);
  each(Verdict::kLeftOut, [&](ObjectId id) {
    const Color color = mixed(colorOf(Verdict::kLeftOut), kPaper, 0.35);
    pen.speck(id, color.faded(crowd));
    if (left_out <= kMaxLeftOutBoxes) pen.outline(id, color.faded(0.45));
  });
  each(Verdict::kKept, [&](ObjectId id) {
    kept <= kMaxKeptBoxes ? pen.outline(id, colorOf(Verdict::kKept).faded(0.75))
                          : pen.speck(id, colorOf(Verdict::kKept).faded(0.8));
  });
  cairo_set_line_width(canvas.pen(), 3.0 * line);
  each(Verdict::kMissed, [&](ObjectId id) { pen.outline(id, colorOf(Verdict::kMissed)); });
}

Result<Canvas> drawn(const FrameToDraw& frame, std::uint32_t width_px) {
  const double aspect = static_cast<double>(frame.camera.height_px) / frame.camera.width_px;
  const auto height_px =
      static_cast<std::uint32_t>(std::clamp(std::round(width_px * aspect), 16.0, 4.0 * width_px));
  Camera camera = frame.camera;
  camera.width_px = width_px * kOversampling;
  camera.height_px = height_px * kOversampling;
  const auto pixels = frame.oracle->paint(camera);
  if (!pixels) return pixels.error();
  const Painter painter(frame, pixels.value(), camera.width_px, camera.height_px);
  const auto footer_px = static_cast<std::uint32_t>(kFooterPx * (width_px / 1280.0));
  Canvas canvas(width_px, height_px + footer_px);
  canvas.image(painter.paint(), camera.width_px, camera.height_px, 1.0 / kOversampling);
  drawHidden(canvas, frame, height_px);
  canvas.footer(frame);
  return canvas;
}

}  // namespace
}  // namespace culld::report

namespace culld {

Result<void> drawFromCamera(const FrameToDraw& frame, const std::string& path_png,
                            std::uint32_t width_px) {
  const auto canvas = report::drawn(frame, width_px);
  return canvas ? canvas.value().save(path_png) : canvas.error();
}

Result<std::string> pngFromCamera(const FrameToDraw& frame, std::uint32_t width_px) {
  const auto canvas = report::drawn(frame, width_px);
  return canvas ? canvas.value().png() : canvas.error();
}

}  // namespace culld
