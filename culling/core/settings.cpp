#include "culling/core/settings.h"

#include <charconv>
#include <cmath>
#include <optional>
#include <system_error>

namespace culld {
namespace {

/// Exactly and in the fewest digits.
std::string numberText(double value) {
  char text[32];
  const auto [end, error] = std::to_chars(text, text + sizeof text, value);
  return {text, error == std::errc() ? end : text};
}

std::optional<double> readValue(const Setting& setting, std::string_view text) {
  if (setting.isSwitch()) {
    if (text == "on") return 1.0;
    if (text == "off") return 0.0;
    return std::nullopt;
  }
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  if (!(value >= setting.least && value <= setting.most)) return std::nullopt;  // nor NaN
  if (setting.whole && value != std::floor(value)) return std::nullopt;
  return value;
}

Error unknownSetting(std::string_view name, std::span<const Setting> table) {
  std::string known;
  for (const Setting& setting : table)
    known += (known.empty() ? "" : ", ") + std::string(setting.name);
  return invalidInput("setting " + std::string(name) + ": unknown; there " +
                      (known.empty() ? "are none" : "are " + known));
}

}  // namespace

std::string valuesOf(const Setting& setting) {
  if (setting.isSwitch()) return "on, off";
  return numberText(setting.least) + " to " + numberText(setting.most) +
         (setting.whole ? "" : ", fractions too");
}

std::string valueText(const Setting& setting, double value) {
  if (setting.isSwitch()) return value != 0.0 ? "on" : "off";
  return numberText(value);
}

SettingValues::SettingValues(std::span<const Setting> table) : table_(table) {
  for (const Setting& setting : table) values_.push_back(setting.standard);
}

double SettingValues::number(std::string_view name) const noexcept {
  std::size_t i = 0;
  while (i + 1 < table_.size() && table_[i].name != name) ++i;
  return values_[i];
}

Result<void> SettingValues::set(std::string_view text) {
  const std::size_t sign = text.find('=');
  const std::string_view name = text.substr(0, sign);
  for (std::size_t i = 0; i < table_.size(); ++i) {
    if (table_[i].name != name) continue;
    const auto value =
        sign == std::string_view::npos ? std::nullopt : readValue(table_[i], text.substr(sign + 1));
    if (!value) {
      return invalidInput("setting " + std::string(text) + ": its values are " +
                          valuesOf(table_[i]));
    }
    values_[i] = *value;
    return Done{};
  }
  return unknownSetting(name, table_);
}

}  // namespace culld
