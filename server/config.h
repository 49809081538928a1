// What `culld serve` is told: a file, the environment and flags, of which the later win. Values
// keep where they came from, so that a mistake is one line that names its place.
// docs/configuration.md lists every key; a test holds it together with server/config_keys.cpp.
#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "culling/core/result.h"
#include "server/access_options.h"
#include "server/limits.h"
#include "server/log.h"

namespace culld::server {

struct Config {
  std::string listen = "127.0.0.1:7420";
  std::string unix_path;
  std::string data_folder;
  std::size_t threads = 0;
  std::string backend = "auto";
  std::string simd = "auto";
  std::map<std::string, std::string> scenes;  ///< name, file
  LogOptions log;
  ServerLimits limits;
  TlsOptions tls;
  AccessOptions access;

  /// By key, who gave it: "--listen", "CULLD_LISTEN", "culld.toml:3". Others have their default.
  std::map<std::string, std::string> origins;
};

/// A whole number, a number, yes or no, a text, a list of texts.
using ConfigValue = std::variant<std::int64_t, double, bool, std::string, std::vector<std::string>>;

/// What somebody wants a key to be. The key is known and the value is of its kind.
struct Setting {
  std::string key;     ///< "limits.max_views"
  ConfigValue value;   ///< paths are absolute, or start where the process does
  std::string origin;  ///< as in Config::origins
  std::string shown;   ///< how a mistake in the value is told: "culld.toml:3: threads = -1"
};
using Settings = std::vector<Setting>;

/// `path` names the file in messages and is where its relative paths begin.
/// ERROR: kInvalidInput, "FILE:LINE: what is wrong", with the nearest key for one that is unknown.
Result<Settings> settingsOfFile(std::string_view text, const std::string& path);
/// ERROR: as settingsOfFile(); kIo: cannot be read; kLimit: larger than 1 MiB.
Result<Settings> settingsOfFile(const std::string& path);

/// `environment` is NAME=VALUE pairs; names that are no key's are left alone, as they may be
/// another program's, unless they look like a slip of the pen. ERROR: kInvalidInput.
Result<Settings> settingsOfEnvironment(const std::vector<std::string>& environment);
std::vector<std::string> processEnvironment();

/// `flags` are (key, text) pairs; for a scene ("scenes", "NAME=FILE"). ERROR: kInvalidInput.
Result<Settings> settingsOfFlags(const std::vector<std::pair<std::string, std::string>>& flags);

/// The defaults, changed by each of the layers in turn. ERROR: kInvalidInput, a value that cannot
/// be.
Result<Config> merged(const std::vector<Settings>& layers);

/// The keys of values that differ and that only a start takes up.
std::vector<std::string> changedForRestart(const Config& before, const Config& after);

/// As a TOML file that says the same, with the origin of each value as a comment.
std::string describe(const Config& config);

struct ListenAddress {
  std::string host;  ///< without brackets, localhost as 127.0.0.1
  std::uint16_t port = 0;
};
/// "HOST:PORT", "[::1]:PORT". ERROR: kInvalidInput.
Result<ListenAddress> parseListen(const std::string& text);

}  // namespace culld::server
