// The report of `culld plan` in sentences.
#include <cstdio>
#include <nlohmann/json.hpp>
#include <sstream>

#include "server/plan_report.h"

namespace culld {
namespace {

using nlohmann::json;

/// A number as people write it: three digits that say something, no exponent.
std::string number(double value) {
  char text[64];
  const int decimals = value >= 100.0 ? 0 : value >= 10.0 ? 1 : value >= 1.0 ? 2 : 3;
  std::snprintf(text, sizeof text, "%.*f", decimals, value);
  return text;
}

/// What is not finite is null in JSON.
std::string number(const json& value) {
  return value.is_number() ? number(value.get<double>()) : "-";
}
std::string percent(const json& share) { return number(100.0 * share.get<double>()) + " %"; }
std::string words(const json& text) { return text.get<std::string>(); }
std::string count(const json& value) { return std::to_string(value.get<std::uint64_t>()); }
std::string megabytes(const json& bytes) { return number(bytes.get<double>() * 1e-6) + " MB"; }

void sceneText(const json& scene, std::ostream& out) {
  out << words(scene["file"]) << ": " << count(scene["objects"]) << " objects, "
      << count(scene["triangles"]) << " triangles (" << count(scene["blocking_triangles"])
      << " block), " << megabytes(scene["bytes"]) << "\n\nMeasured\n";
  const json& size = scene["size_m"];
  out << "  objects            a tenth are below " << number(size["p10"]) << " m, half below "
      << number(size["median"]) << " m, nine tenths below " << number(size["p90"]) << " m; "
      << number(scene["triangles_per_object"]) << " triangles each\n";
  out << "  depth complexity   " << number(scene["depth_complexity"]) << " boxes on a ray\n";
  out << "  occluders          on " << percent(scene["occluder_potential"])
      << " of the rays something that blocks stands before something else\n";
  out << "  closed             " << percent(scene["closedness"])
      << " of the rays among the objects end at something that blocks\n";
  out << "  2.5D               " << percent(scene["upright"])
      << " of the objects stand in one heap with what is above and below them\n";
}

void viewsText(const json& report, std::ostream& out) {
  const json& views = report["views"];
  const json& prices = report["prices"];
  if (views["stages"].empty()) return;
  out << "  looking around     " << number(views["counted_work_ms"])
      << " ms of counted work, with an object sent at " << number(prices["object_us"])
      << " us and a triangle at " << number(prices["triangle_us"]) << " us\n";
  for (const json& stage : views["stages"]) {
    out << "  " << words(stage["method"]) << ": of " << number(stage["in_frustum"])
        << " objects in the frustum, " << number(stage["answered_without"])
        << " answered without it and " << number(stage["answered_with"]) << " with it, for "
        << number(stage["work_us"]) << " us a view; pays in " << count(stage["pays_in"]) << " of "
        << count(stage["sampled"]) << " sampled views and brings " << number(stage["gain_us"])
        << " us on average (at most " << number(stage["gain_at_most_us"]) << ")\n";
  }
}

void depthText(const json& depth, std::ostream& out) {
  if (depth["views"].get<int>() == 0) return;
  out << "  surfaces a pixel   " << number(depth["mean"]) << " on average, at most "
      << count(depth["p95"]) << " in 95 % of the pixels, " << count(depth["most"])
      << " at most, in " << count(depth["views"]) << " views\n";
}

void listText(const char* title, const json& lines, std::ostream& out) {
  out << "\n" << title << "\n";
  for (const json& line : lines) {
    out << "  " << words(line["what"]) << ": " << words(line["why"]) << "\n";
  }
}

void camerasText(const json& cameras, std::ostream& out) {
  out << "\nOn " << count(cameras["count"]) << " cameras, " << count(cameras["rounds"])
      << " rounds, each method in turn\n";
  char row[160];
  std::snprintf(row, sizeof row, "  %-10s %12s %12s %12s %12s %14s %10s\n", "method", "min us",
                "median us", "objects", "triangles", "price us", "occlusion");
  out << row;
  for (const json& m : cameras["methods"]) {
    std::snprintf(row, sizeof row, "  %-10s %12s %12s %12s %12s %14s %10s\n",
                  words(m["method"]).c_str(), number(m["min_us"]).c_str(),
                  number(m["median_us"]).c_str(), number(m["objects"]).c_str(),
                  number(m["triangles"]).c_str(), number(m["price_us"]).c_str(),
                  count(m["with_occlusion"]).c_str());
    out << row;
  }
  out << "  (times, objects and triangles a camera; price: least time and what is sent;\n"
         "  occlusion: cameras that the occlusion stage answered)\n";
}

}  // namespace

std::string planText(const std::string& text) {
  const json report = json::parse(text);
  std::ostringstream out;
  sceneText(report["scene"], out);
  viewsText(report, out);
  depthText(report["depth"], out);
  listText("Used", report["used"]["stages"], out);
  out << "  " << megabytes(report["used"]["prepared_bytes"]) << " beyond the scene\n";
  listText("Left out", report["left_out"], out);
  if (report.contains("cameras")) camerasText(report["cameras"], out);
  return out.str();
}

}  // namespace culld
