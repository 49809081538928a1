// What can be turned about a method: the parts that its source describes, each a switch or a
// number, so that what a part brings can be measured.
#pragma once
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "culling/core/result.h"

namespace culld {

struct Setting {
  std::string_view name;     ///< lower case and '-'
  std::string_view meaning;  ///< one line, with the unit
  double standard = 1.0;
  double least = 0.0, most = 1.0;
  bool whole = true;  ///< no fractions

  /// Written "on" and "off".
  constexpr bool isSwitch() const noexcept { return whole && least == 0.0 && most == 1.0; }
};

/// A value for each setting of a table, which must outlive it. Starts with the standard ones.
class SettingValues {
 public:
  explicit SettingValues(std::span<const Setting> table);

  /// REQUIRES: a name of the table.
  double number(std::string_view name) const noexcept;
  bool on(std::string_view name) const noexcept { return number(name) != 0.0; }

  /// `text`: "NAME=VALUE". ERROR: kInvalidInput: a name that the table has not, no value of it.
  Result<void> set(std::string_view text);

 private:
  std::span<const Setting> table_;
  std::vector<double> values_;
};

/// "on, off", or "4 to 12".
std::string valuesOf(const Setting& setting);
/// "on", "0.25": a value as set() reads it.
std::string valueText(const Setting& setting, double value);

}  // namespace culld
