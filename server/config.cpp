#include "server/config.h"

#include <unistd.h>

#include <algorithm>

#include "server/config_keys.h"
#include "server/scene_files.h"

namespace culld::server {
namespace {

constexpr std::string_view kScene = "scenes.";

/// What the mistake is in, then what it is.
Error wrong(const std::string& where, const Error& error) {
  return invalidInput(where + ": " + error.message);
}

Result<void> apply(Config& config, const Setting& setting) {
  config.origins[setting.key] = setting.origin;
  if (setting.key.starts_with(kScene)) {
    const auto& file = std::get<std::string>(setting.value);
    if (file.empty()) return invalidInput(setting.shown + ": is empty");
    config.scenes[setting.key.substr(kScene.size())] = file;
    return Done{};
  }
  const auto set = findKey(setting.key)->set(config, setting.value);
  return set ? Result<void>(Done{}) : wrong(setting.shown, set.error());
}

Result<Setting> sceneFlag(const std::string& text) {
  const auto equals = text.find('=');
  if (equals == std::string::npos || equals == 0 || equals + 1 == text.size()) {
    return invalidInput("--scene " + text + ": not NAME=FILE");
  }
  const std::string name = text.substr(0, equals);
  if (!validSceneName(name)) {
    return invalidInput("--scene " + text + ": name is not [A-Za-z0-9._-]{1,64}");
  }
  return Setting{std::string(kScene) + name, text.substr(equals + 1), "--scene", "--scene " + text};
}

std::string originOf(const Config& config, const std::string& key) {
  const auto at = config.origins.find(key);
  return at == config.origins.end() ? "default" : at->second;
}

void addLine(std::string& out, std::string line, const std::string& origin) {
  constexpr std::size_t kColumn = 48;
  if (line.size() < kColumn) line.resize(kColumn, ' ');
  out += line + "  # " + origin + "\n";
}

}  // namespace

std::vector<std::string> processEnvironment() {
  std::vector<std::string> out;
  for (char** entry = environ; entry != nullptr && *entry != nullptr; ++entry) {
    out.emplace_back(*entry);
  }
  return out;
}

Result<Settings> settingsOfEnvironment(const std::vector<std::string>& environment) {
  std::vector<std::string> names;
  for (const ConfigKey& key : configKeys()) names.push_back(key.variable());
  Settings out;
  for (const std::string& entry : environment) {
    const std::string name = entry.substr(0, entry.find('='));
    if (!name.starts_with("CULLD_") || name.size() == entry.size()) continue;
    const auto at = std::find(names.begin(), names.end(), name);
    if (at == names.end()) {
      if (const auto meant = nearest(name, names, 2)) {
        return invalidInput(name + " is not known" + suggestion(meant));
      }
      continue;
    }
    const ConfigKey& key = configKeys()[static_cast<std::size_t>(at - names.begin())];
    auto value = parseValue(key.kind, entry.substr(name.size() + 1));
    if (!value) return wrong(entry, value.error());
    out.push_back({key.name, std::move(value).value(), name, entry});
  }
  return out;
}

Result<Settings> settingsOfFlags(const std::vector<std::pair<std::string, std::string>>& flags) {
  Settings out;
  for (const auto& [name, text] : flags) {
    if (name == "scenes") {
      auto scene = sceneFlag(text);
      if (!scene) return scene.error();
      const std::string& key = scene.value().key;
      const auto same = [&key](const Setting& earlier) { return earlier.key == key; };
      if (std::any_of(out.begin(), out.end(), same)) {
        return invalidInput("--scene " + text + ": the name " + key.substr(kScene.size()) +
                            " is given twice");
      }
      out.push_back(std::move(scene).value());
      continue;
    }
    const ConfigKey* key = findKey(name);
    if (key == nullptr || key->flag.empty()) return invalidInput(name + " has no flag");
    auto value = parseValue(key->kind, text);
    const std::string shown = key->flag + " " + text;
    if (!value) return wrong(shown, value.error());
    out.push_back({name, std::move(value).value(), key->flag, shown});
  }
  return out;
}

Result<Config> merged(const std::vector<Settings>& layers) {
  Config config;
  for (const Settings& layer : layers) {
    for (const Setting& setting : layer) {
      if (auto applied = apply(config, setting); !applied) return applied.error();
    }
  }
  return config;
}

std::vector<std::string> changedForRestart(const Config& before, const Config& after) {
  std::vector<std::string> out;
  for (const ConfigKey& key : configKeys()) {
    if (!key.reloaded && key.get(before) != key.get(after)) out.push_back(key.name);
  }
  if (before.scenes != after.scenes) out.emplace_back("scenes");
  return out;
}

std::string describe(const Config& config) {
  std::string out;
  std::string table;
  for (const ConfigKey& key : configKeys()) {
    const auto dot = key.name.find('.');
    const ConfigValue value = key.get(config);
    const auto* text = std::get_if<std::string>(&value);
    if (text && text->empty()) continue;  // not given: there is no such thing as an empty one
    if (dot != std::string::npos && key.name.substr(0, dot) != table) {
      table = key.name.substr(0, dot);
      out += "\n[" + table + "]\n";
    }
    const std::string name = dot == std::string::npos ? key.name : key.name.substr(dot + 1);
    addLine(out, name + " = " + toToml(value), originOf(config, key.name));
  }
  if (!config.scenes.empty()) out += "\n[scenes]\n";
  for (const auto& [name, file] : config.scenes) {
    addLine(out, toToml(name) + " = " + toToml(file), originOf(config, std::string(kScene) + name));
  }
  return out;
}

}  // namespace culld::server
