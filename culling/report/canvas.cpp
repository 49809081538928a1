#include "culling/report/canvas.h"

#include <algorithm>
#include <cmath>

namespace culld::report {

Color mixed(const Color& a, const Color& b, double share) {
  const auto mix = [share](double x, double y) { return x + (y - x) * share; };
  return {mix(a.red, b.red), mix(a.green, b.green), mix(a.blue, b.blue), mix(a.alpha, b.alpha)};
}

Color colorOf(Verdict verdict) {
  switch (verdict) {
    case Verdict::kOutside:
      return {0.200, 0.240, 0.295};
    case Verdict::kLeftOut:
      return {0.410, 0.545, 0.745};
    case Verdict::kKept:
      return {0.985, 0.640, 0.150};
    case Verdict::kSeen:
      return {0.230, 0.800, 0.610};
    case Verdict::kMissed:
      break;
  }
  return {1.000, 0.130, 0.260};
}

Canvas::Canvas(std::uint32_t width_px, std::uint32_t height_px)
    : width_(width_px),
      height_(height_px),
      surface_(cairo_image_surface_create(CAIRO_FORMAT_RGB24, static_cast<int>(width_px),
                                          static_cast<int>(height_px))),
      pen_(cairo_create(surface_.get())) {
  fillRect(0, 0, width_, height_, kNight);
}

void Canvas::color(const Color& c) const {
  cairo_set_source_rgba(pen(), c.red, c.green, c.blue, c.alpha);
}

void Canvas::fillRect(double x, double y, double width, double height, const Color& c) const {
  color(c);
  cairo_rectangle(pen(), x, y, width, height);
  cairo_fill(pen());
}

double Canvas::text(double x, double y, double size, const Color& c, const std::string& line,
                    bool bold) const {
  cairo_select_font_face(pen(), "DejaVu Sans", CAIRO_FONT_SLANT_NORMAL,
                         bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
  cairo_set_font_size(pen(), size);
  color(c);
  cairo_move_to(pen(), x, y);
  cairo_show_text(pen(), line.c_str());
  cairo_text_extents_t extents;
  cairo_text_extents(pen(), line.c_str(), &extents);
  return extents.x_advance;
}

void Canvas::footer(const FrameToDraw& frame) const {
  std::array<std::uint64_t, kVerdictCount> count{};
  for (const Verdict verdict : frame.verdicts) ++count[static_cast<std::size_t>(verdict)];
  const double unit = width_ / 1280.0;  // lettering grows with the picture
  const double top = height_ - kFooterPx * unit;
  fillRect(0, top, width_, kFooterPx * unit, kNight);
  fillRect(0, top, width_, 1, kDusk);
  const double left = 22 * unit;
  text(left, top + 32 * unit, 17 * unit, kPaper, frame.title, true);
  struct Entry {
    Verdict verdict;
    const char* name;
  };
  constexpr std::array<Entry, kVerdictCount> kEntries{{{Verdict::kSeen, "truly visible, answered"},
                                                       {Verdict::kKept, "hidden, answered anyway"},
                                                       {Verdict::kLeftOut, "hidden, left out"},
                                                       {Verdict::kOutside, "outside the view"},
                                                       {Verdict::kMissed, "visible, missed"}}};
  double x = left;
  const double line = top + 63 * unit;
  for (const Entry& entry : kEntries) {
    const std::uint64_t number = count[static_cast<std::size_t>(entry.verdict)];
    const Color swatch = entry.verdict == Verdict::kOutside
                             ? mixed(colorOf(entry.verdict), kQuiet, 0.4)
                             : colorOf(entry.verdict);
    fillRect(x, line - 12 * unit, 14 * unit, 14 * unit, swatch);
    x += 21 * unit;
    x += text(x, line, 15 * unit, kPaper, grouped(number), true) + 6 * unit;
    x += text(x, line, 14 * unit, kQuiet, entry.name) + 24 * unit;
  }
}

std::uint32_t packed(const Color& color) {
  const auto byte = [&color](double x) {
    return static_cast<std::uint32_t>(std::lround(std::clamp(x * color.alpha, 0.0, 1.0) * 255.0));
  };
  const auto alpha = static_cast<std::uint32_t>(std::lround(color.alpha * 255.0));
  return alpha << 24U | byte(color.red) << 16U | byte(color.green) << 8U | byte(color.blue);
}

void Canvas::image(std::span<const std::uint32_t> pixels, std::uint32_t width_px,
                   std::uint32_t height_px, double scale) const {
  const std::unique_ptr<cairo_surface_t, Release> source(cairo_image_surface_create(
      CAIRO_FORMAT_ARGB32, static_cast<int>(width_px), static_cast<int>(height_px)));
  if (cairo_surface_status(source.get()) != CAIRO_STATUS_SUCCESS) return;  // save() reports it
  cairo_surface_flush(source.get());
  unsigned char* to = cairo_image_surface_get_data(source.get());
  const int stride = cairo_image_surface_get_stride(source.get());
  for (std::uint32_t row = 0; row < height_px; ++row) {
    const auto line = pixels.subspan(std::size_t{row} * width_px, width_px);
    const auto bytes = std::as_bytes(line);
    std::transform(bytes.begin(), bytes.end(), to + static_cast<std::ptrdiff_t>(row) * stride,
                   [](std::byte b) { return std::to_integer<unsigned char>(b); });
  }
  cairo_surface_mark_dirty(source.get());
  cairo_save(pen());
  cairo_scale(pen(), scale, scale);
  cairo_set_source_surface(pen(), source.get(), 0, 0);
  cairo_pattern_set_filter(cairo_get_source(pen()), CAIRO_FILTER_GOOD);
  cairo_paint(pen());
  cairo_restore(pen());
}

Result<void> Canvas::save(const std::string& path_png) const {
  cairo_status_t status = cairo_status(pen());
  if (status == CAIRO_STATUS_SUCCESS) {
    status = cairo_surface_write_to_png(surface_.get(), path_png.c_str());
  }
  if (status == CAIRO_STATUS_SUCCESS) return Done{};
  return Error{ErrorCode::kIo, path_png + ": cannot write: " + cairo_status_to_string(status)};
}

Result<std::string> Canvas::png() const {
  std::string bytes;
  const auto append = [](void* to, const unsigned char* data, unsigned length) {
    static_cast<std::string*>(to)->append(data, data + length);
    return CAIRO_STATUS_SUCCESS;
  };
  cairo_status_t status = cairo_status(pen());
  if (status == CAIRO_STATUS_SUCCESS) {
    status = cairo_surface_write_to_png_stream(surface_.get(), append, &bytes);
  }
  if (status == CAIRO_STATUS_SUCCESS) return bytes;
  return Error{ErrorCode::kUnavailable, std::string("picture: ") + cairo_status_to_string(status)};
}

std::string grouped(std::uint64_t number) {
  std::string digits = std::to_string(number);
  for (std::size_t at = digits.size(); at > 3; at -= 3) digits.insert(at - 3, "\u2009");
  return digits;
}

}  // namespace culld::report
