// What `culld serve` and `culld check-config` are given, and the configuration that it amounts to.
#pragma once
#include <map>
#include <string>
#include <vector>

#include "server/command_line.h"
#include "server/config.h"

namespace culld {

struct ServeArguments {
  std::string config_file;                   ///< empty: $CULLD_CONFIG, or none
  std::map<std::string, std::string> flags;  ///< by key; empty: not given
  std::vector<std::string> scenes;           ///< NAME=FILE
};

/// A flag for each key that has one, and --scene.
void addServeFlags(CLI::App& command, ServeArguments& arguments);

/// File, environment and flags, as they are now. ERROR: one line; `code` is what to exit with.
Result<server::Config> readConfig(const ServeArguments& arguments, ExitCode& code);

/// Refuses a public address without tokens and TLS that was not allowed.
/// ERROR: one line, a bad configuration.
Result<void> checkListen(const server::Config& config);

/// Whether everything was said on the command line: then a mistake in it is one of usage.
ExitCode mistakeIn(const server::Config& config);

}  // namespace culld
