#include "client/cli/places_file.h"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>

#include "protocol/text.h"

namespace culld::client {
namespace {

using nlohmann::json;
using protocol::Error;
using protocol::invalidInput;
using protocol::Place;
using protocol::Result;

constexpr std::size_t kMostBytes = std::size_t{16} << 20;

/// Reads one place; the first thing that is wrong stays.
class PlaceReader {
 public:
  explicit PlaceReader(const json& place) : place_(place) {}

  std::string wrong;

  Place read() {
    if (!place_.is_object()) {
      wrong = "not an object";
      return {};
    }
    for (const auto& [key, value] : place_.items()) {
      // A misspelt radius would be none, and the answer worth less than it seems.
      if (key != "at" && key != "min" && key != "max" && key != "radius") {
        wrong = "\"" + protocol::oneLine(key) + "\" is not known; there are at, min, max, radius";
        break;
      }
    }
    if (!wrong.empty()) return {};
    Place place;
    const bool point = place_.contains("at");
    if (point == (place_.contains("min") || place_.contains("max"))) {
      wrong = R"(wants either "at" or "min" and "max")";
      return {};
    }
    place.min = vector(point ? "at" : "min");
    place.max = vector(point ? "at" : "max");
    if (place_.contains("radius")) place.radius_m = number(place_["radius"], "radius", "a number");
    return place;
  }

 private:
  double number(const json& value, const char* field, const char* wanted) {
    if (value.is_number()) return value.get<double>();
    if (wrong.empty()) wrong = std::string("\"") + field + "\" is not " + wanted;
    return 0.0;
  }

  std::array<double, 3> vector(const char* field) {
    constexpr const char* kWanted = "a list of 3 numbers";
    const auto at = place_.find(field);
    const bool three = at != place_.end() && at->is_array() && at->size() == 3;
    if (!three) return {number({}, field, kWanted), 0.0, 0.0};
    std::array<double, 3> out{};
    for (std::size_t i = 0; i < 3; ++i) out[i] = number((*at)[i], field, kWanted);
    return out;
  }

  const json& place_;
};

}  // namespace

Result<std::vector<Place>> parsePlaces(std::string_view text, const std::string& name) {
  const json list = json::parse(text, nullptr, false);
  if (!list.is_array()) return invalidInput(name + ": not a JSON list");
  std::vector<Place> places;
  for (std::size_t i = 0; i < list.size(); ++i) {
    PlaceReader reader(list[i]);
    places.push_back(reader.read());
    if (reader.wrong.empty()) continue;
    return invalidInput(name + ": place " + std::to_string(i) + ": " + reader.wrong);
  }
  return places;
}

Result<std::vector<Place>> readPlacesFile(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string text(kMostBytes + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (!file && !file.eof()) return invalidInput(path + ": cannot read: " + std::strerror(errno));
  text.resize(static_cast<std::size_t>(file.gcount()));
  if (text.size() > kMostBytes) return invalidInput(path + ": larger than 16 MiB");
  return parsePlaces(text, path);
}

}  // namespace culld::client
