// The keys of the configuration as a table: what reads, checks, prints and documents them.
#pragma once
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "server/config.h"

namespace culld::server {

enum class KeyKind : std::uint8_t { kWhole, kNumber, kSwitch, kText, kPath, kList };

struct ConfigKey {
  std::string name;  ///< "listen", "limits.max_views"
  std::string flag;  ///< of culld serve; empty: none
  KeyKind kind = KeyKind::kText;
  bool reloaded = false;  ///< SIGHUP makes it take effect
  std::string range;      ///< "1 to 64", "auto or cpu"; empty: not bounded
  std::string what;       ///< one line for --help
  /// REQUIRES: a value of `kind`. ERROR: kInvalidInput, why it cannot be.
  std::function<Result<void>(Config&, const ConfigValue&)> set;
  std::function<ConfigValue(const Config&)> get;

  /// The variable that stands for it: CULLD_LIMITS_MAX_VIEWS.
  std::string variable() const;
};

/// In the order in which they are printed: those of a table stand together.
const std::vector<ConfigKey>& configKeys();
const ConfigKey* findKey(std::string_view name);

/// "a whole number", "a text": what a value of this kind is called.
std::string_view nameOf(KeyKind kind);

/// The value of `kind` that a flag's or a variable's text stands for. ERROR: kInvalidInput.
Result<ConfigValue> parseValue(KeyKind kind, const std::string& text);
/// As TOML writes it.
std::string toToml(const ConfigValue& value);

/// The candidate that `word` was meant to be, if any is near: `most` slips at most, or one in four
/// letters.
std::optional<std::string> nearest(std::string_view word, std::span<const std::string> candidates,
                                   std::optional<std::size_t> most = std::nullopt);
/// "; did you mean NAME?", or nothing.
std::string suggestion(const std::optional<std::string>& name);

}  // namespace culld::server
