// Values of the configuration as text, and words that were meant to be others.
#include <algorithm>
#include <array>
#include <charconv>
#include <nlohmann/json.hpp>

#include "server/config_keys.h"

namespace culld::server {
namespace {

template <typename Number>
Result<ConfigValue> parseNumber(const std::string& text, KeyKind kind) {
  Number value{};
  const char* end = text.data() + text.size();
  const auto [stop, failure] = std::from_chars(text.data(), end, value);
  if (failure == std::errc() && stop == end) return ConfigValue(value);
  return invalidInput("not " + std::string(nameOf(kind)));
}

ConfigValue commaSeparated(const std::string& text) {
  std::vector<std::string> parts;
  std::size_t begin = 0;
  for (std::size_t comma = 0; comma != std::string::npos; begin = comma + 1) {
    comma = text.find(',', begin);
    parts.push_back(text.substr(begin, comma == std::string::npos ? comma : comma - begin));
  }
  return parts;
}

/// A JSON string is a TOML string, but for the one control character that JSON leaves alone.
std::string quoted(const std::string& text) {
  std::string json =
      nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  for (auto at = json.find('\x7f'); at != std::string::npos; at = json.find('\x7f')) {
    json.replace(at, 1, "\\u007F");
  }
  return json;
}

std::string numberText(double value) {
  std::array<char, 32> digits{};
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
  return {digits.data(), end};
}

std::size_t distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t above = row[j];
      const std::size_t changed = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      row[j] = std::min({row[j - 1] + 1, above + 1, changed});
      diagonal = above;
    }
  }
  return row[b.size()];
}

std::string_view lastPart(std::string_view name) { return name.substr(name.rfind('.') + 1); }

}  // namespace

std::string_view nameOf(KeyKind kind) {
  switch (kind) {
    case KeyKind::kWhole:
      return "a whole number";
    case KeyKind::kNumber:
      return "a number";
    case KeyKind::kSwitch:
      return "true or false";
    case KeyKind::kText:
      return "a text";
    case KeyKind::kPath:
      return "a path";
    case KeyKind::kList:
      break;
  }
  return "a list of texts";
}

Result<ConfigValue> parseValue(KeyKind kind, const std::string& text) {
  switch (kind) {
    case KeyKind::kWhole:
      return parseNumber<std::int64_t>(text, kind);
    case KeyKind::kNumber:
      return parseNumber<double>(text, kind);
    case KeyKind::kSwitch:
      if (text == "true" || text == "false") return ConfigValue(text == "true");
      return invalidInput("not true or false");
    case KeyKind::kList:
      return commaSeparated(text);
    case KeyKind::kText:
    case KeyKind::kPath:
      break;
  }
  return ConfigValue(text);
}

std::string toToml(const ConfigValue& value) {
  if (const auto* whole = std::get_if<std::int64_t>(&value)) return std::to_string(*whole);
  if (const auto* number = std::get_if<double>(&value)) return numberText(*number);
  if (const auto* yes = std::get_if<bool>(&value)) return *yes ? "true" : "false";
  if (const auto* text = std::get_if<std::string>(&value)) return quoted(*text);
  std::string out;
  for (const std::string& entry : std::get<std::vector<std::string>>(value)) {
    out += (out.empty() ? "" : ", ") + quoted(entry);
  }
  return "[" + out + "]";
}

std::optional<std::string> nearest(std::string_view word, std::span<const std::string> candidates,
                                   std::optional<std::size_t> most) {
  constexpr std::size_t kLongest = 64;
  if (word.empty() || word.size() > kLongest) return std::nullopt;
  std::optional<std::string> best;
  std::size_t best_distance = most.value_or(std::max<std::size_t>(1, word.size() / 4)) + 1;
  for (const std::string& candidate : candidates) {
    // A key that stands in the wrong table is as far away as its own name is.
    const std::size_t far =
        std::min(distance(word, candidate), distance(lastPart(word), lastPart(candidate)));
    if (far >= best_distance) continue;
    best_distance = far;
    best = candidate;
  }
  return best;
}

std::string suggestion(const std::optional<std::string>& name) {
  return name ? "; did you mean " + *name + "?" : "";
}

}  // namespace culld::server
