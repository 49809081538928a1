#include "server/serve_arguments.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>

#include "server/access.h"
#include "server/config_keys.h"

namespace culld {

void addServeFlags(CLI::App& command, ServeArguments& arguments) {
  const server::Config defaults;
  for (const server::ConfigKey& key : server::configKeys()) {
    if (key.flag.empty()) continue;
    if (key.kind == server::KeyKind::kSwitch) {
      command.add_flag_callback(
          key.flag, [&text = arguments.flags[key.name]] { text = "true"; }, key.what);
      continue;
    }
    CLI::Option* option = command.add_option(key.flag, arguments.flags[key.name], key.what);
    const auto value = key.get(defaults);
    const auto* text = std::get_if<std::string>(&value);
    if (text && !text->empty()) option->default_str(*text);
  }
  command.add_option("--scene", arguments.scenes, "NAME=FILE; may be repeated");
}

Result<server::Config> readConfig(const ServeArguments& arguments, ExitCode& code) {
  code = kUsage;
  std::vector<std::pair<std::string, std::string>> given;
  for (const auto& [key, text] : arguments.flags) {
    if (!text.empty()) given.emplace_back(key, text);
  }
  for (const std::string& scene : arguments.scenes) given.emplace_back("scenes", scene);
  auto flags = server::settingsOfFlags(given);
  if (!flags) return flags.error();
  if (auto alone = server::merged({flags.value()}); !alone) return alone.error();

  code = kConfig;
  std::vector<server::Settings> layers;
  const char* named = std::getenv("CULLD_CONFIG");
  const std::string file = arguments.config_file.empty() && named ? named : arguments.config_file;
  if (!file.empty()) {
    auto in_file = server::settingsOfFile(file);
    if (!in_file) return in_file.error();
    layers.push_back(std::move(in_file).value());
  }
  auto in_environment = server::settingsOfEnvironment(server::processEnvironment());
  if (!in_environment) return in_environment.error();
  layers.push_back(std::move(in_environment).value());
  layers.push_back(std::move(flags).value());
  return server::merged(layers);
}

Result<void> checkListen(const server::Config& config) {
  const auto address = server::parseListen(config.listen);
  if (!address) return address.error();
  return server::checkExposure(address.value().host, config.access, config.tls);
}

ExitCode mistakeIn(const server::Config& config) {
  const bool flags_only =
      std::all_of(config.origins.begin(), config.origins.end(),
                  [](const auto& origin) { return origin.second.starts_with("--"); });
  return flags_only ? kUsage : kConfig;
}

}  // namespace culld
