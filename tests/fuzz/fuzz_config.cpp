// Any text as a configuration file: one line that says where it is wrong, or a configuration that,
// printed and read again, is the same. The first byte chooses whether it is a file or a variable.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

#include "server/config_keys.h"

namespace {

using namespace culld;
using namespace culld::server;

void require(bool holds) {
  if (!holds) std::abort();
}

void requireSame(const Config& a, const Config& b) {
  for (const ConfigKey& key : configKeys()) require(key.get(a) == key.get(b));
  require(a.scenes == b.scenes);
  require(changedForRestart(a, b).empty());
}

void requirePrintsItself(const Config& config) {
  const auto again = settingsOfFile(describe(config), "again.toml");
  require(again.ok());
  const auto back = merged({again.value()});
  require(back.ok());
  requireSame(config, back.value());
}

void readFile(std::string_view text) {
  const auto settings = settingsOfFile(text, "fuzz.toml");
  if (!settings) return require(settings.error().message.starts_with("fuzz.toml:"));
  for (const Setting& setting : settings.value()) {
    require(setting.origin.starts_with("fuzz.toml:"));
    require(setting.key.starts_with("scenes.") || findKey(setting.key) != nullptr);
  }
  const auto config = merged({settings.value()});
  if (!config) return require(config.error().message.starts_with("fuzz.toml:"));
  requirePrintsItself(config.value());
}

void readVariable(const std::string& entry) {
  const auto settings = settingsOfEnvironment({entry});
  if (!settings) return require(settings.error().message.starts_with("CULLD_"));
  const auto config = merged({settings.value()});
  if (!config) require(config.error().message.starts_with(entry));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string text(reinterpret_cast<const char*>(data) + 1, size - 1);
  if (data[0] == '$') {
    readVariable(text);
  } else {
    readFile(text);
  }
  return 0;
}
