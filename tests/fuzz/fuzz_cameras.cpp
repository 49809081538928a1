// Any text as a cameras file: one line that says why not, or cameras whose numbers are all finite,
// and which say the same when they are written down again.
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

#include "protocol/camera_file.h"

namespace {

using namespace culld::protocol;

void require(bool holds) {
  if (!holds) std::abort();
}

std::string written(double value) {
  require(std::isfinite(value));
  std::array<char, 32> digits{};
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
  return {digits.data(), end};
}

template <std::size_t N>
std::string written(const std::array<double, N>& values) {
  std::string text = "[";
  for (const double value : values) text += (text.size() > 1 ? "," : "") + written(value);
  return text + "]";
}

std::string written(const Camera& camera) {
  std::string text = "{";
  if (const auto* look = std::get_if<LookAt>(&camera.pose)) {
    text += "\"eye\":" + written(look->eye) + ",\"target\":" + written(look->target) +
            ",\"up\":" + written(look->up) + ",\"yfov\":" + written(look->yfov_rad) +
            ",\"aspect\":" + written(look->aspect) + ",\"znear\":" + written(look->znear_m) +
            ",\"zfar\":" + (look->zfar_m ? written(*look->zfar_m) : "null");
  } else {
    const auto& matrices = *std::get_if<Matrices>(&camera.pose);
    text +=
        "\"view\":" + written(matrices.view) + ",\"projection\":" + written(matrices.projection);
  }
  for (const std::uint32_t side : {camera.width_px, camera.height_px}) {
    require(side >= 1 && side <= kMaxImageSide);
  }
  return text + ",\"radius\":" + written(camera.radius_m) +
         ",\"angle\":" + written(camera.angle_rad) +
         ",\"width\":" + std::to_string(camera.width_px) +
         ",\"height\":" + std::to_string(camera.height_px) + "}";
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto cameras = parseCameras(text, "fuzz");
  if (!cameras) {
    const std::string& line = cameras.error().message;
    require(line.starts_with("fuzz: ") && line.size() > 6 && line.size() < 200);
    for (const char c : line) require(c >= ' ' && c <= '~');
    return 0;
  }
  require(text.find('\0') == text.npos);
  std::string again = "[";
  for (const Camera& camera : cameras.value()) {
    again += (again.size() > 1 ? "," : "") + written(camera);
  }
  const auto back = parseCameras(again + "]", "again");
  require(back.ok() && back.value() == cameras.value());
  return 0;
}
