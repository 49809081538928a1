// A configuration file: TOML, of which every key must be known and every value of its kind.
#include <toml++/toml.h>
#include <algorithm>
#include <filesystem>
#include <iterator>

#include "server/config_keys.h"
#include "server/disk.h"
#include "server/scene_files.h"

namespace culld::server {
namespace {

constexpr std::size_t kMostBytes = std::size_t{1} << 20;
constexpr std::string_view kScenes = "scenes";

std::string_view kindOf(const toml::node& node) {
  switch (node.type()) {
    case toml::node_type::table:
      return "a table";
    case toml::node_type::array:
      return "a list";
    case toml::node_type::string:
      return "a text";
    case toml::node_type::integer:
      return "a whole number";
    case toml::node_type::floating_point:
      return "a number";
    case toml::node_type::boolean:
      return "true or false";
    default:
      return "a date or time";
  }
}

/// Reads one file's tree into settings; stops at the first mistake.
class Reader {
 public:
  explicit Reader(std::string path)
      : path_(std::move(path)), folder_(std::filesystem::path(path_).parent_path()) {
    tables_.emplace_back(kScenes);
    for (const ConfigKey& key : configKeys()) {
      names_.push_back(key.name);
      const auto dot = key.name.find('.');
      if (dot == std::string::npos) continue;
      if (tables_.back() != key.name.substr(0, dot)) tables_.push_back(key.name.substr(0, dot));
    }
    names_.insert(names_.end(), tables_.begin(), tables_.end());
  }

  Result<Settings> read(const toml::table& root) {
    for (const auto& [key, node] : root) {
      const bool table = std::find(tables_.begin(), tables_.end(), key.str()) != tables_.end();
      auto done = table ? readTable(key, node) : readKey(key, std::string(key.str()), node);
      if (!done) return done.error();
    }
    return std::move(settings_);
  }

 private:
  std::string place(const toml::key& key) const {
    return path_ + ":" + std::to_string(key.source().begin.line);
  }

  Result<void> wrongKind(const toml::key& key, const std::string& name, const toml::node& node,
                         std::string_view wanted) const {
    return invalidInput(place(key) + ": " + name + ": " + std::string(kindOf(node)) + " where " +
                        std::string(wanted) + " belongs");
  }

  Result<void> readTable(const toml::key& key, const toml::node& node) {
    const std::string name(key.str());
    const toml::table* table = node.as_table();
    if (table == nullptr) return wrongKind(key, name, node, "a table");
    for (const auto& [entry, value] : *table) {
      const std::string full = name + "." + std::string(entry.str());
      auto done = name == kScenes ? readScene(entry, value) : readKey(entry, full, value);
      if (!done) return done;
    }
    return Done{};
  }

  Result<void> readScene(const toml::key& key, const toml::node& node) {
    const std::string name(key.str());
    if (!validSceneName(name)) {
      return invalidInput(place(key) + ": scenes." + name + ": name is not [A-Za-z0-9._-]{1,64}");
    }
    const auto file = node.value_exact<std::string>();
    if (!file) return wrongKind(key, "scenes." + name, node, nameOf(KeyKind::kPath));
    add(key, "scenes." + name, KeyKind::kPath, *file);
    return Done{};
  }

  Result<void> readKey(const toml::key& place_of, const std::string& name, const toml::node& node) {
    const ConfigKey* key = findKey(name);
    if (key == nullptr) {
      return invalidInput(place(place_of) + ": " + name + " is not known" +
                          suggestion(nearest(name, names_)));
    }
    auto value = valueOf(node, key->kind);
    if (!value) return wrongKind(place_of, name, node, nameOf(key->kind));
    add(place_of, name, key->kind, *std::move(value));
    return Done{};
  }

  static std::optional<ConfigValue> valueOf(const toml::node& node, KeyKind kind) {
    switch (kind) {
      case KeyKind::kWhole:
        if (const auto* whole = node.as_integer()) return ConfigValue(whole->get());
        break;
      case KeyKind::kNumber:
        if (const auto* number = node.as_floating_point()) return ConfigValue(number->get());
        if (const auto* whole = node.as_integer()) {
          return ConfigValue(static_cast<double>(whole->get()));
        }
        break;
      case KeyKind::kSwitch:
        if (const auto* yes = node.as_boolean()) return ConfigValue(yes->get());
        break;
      case KeyKind::kText:
      case KeyKind::kPath:
        if (const auto* text = node.as_string()) return ConfigValue(text->get());
        break;
      case KeyKind::kList:
        return listOf(node);
    }
    return std::nullopt;
  }

  /// Users may be given as numbers.
  static std::optional<ConfigValue> listOf(const toml::node& node) {
    const toml::array* array = node.as_array();
    if (array == nullptr) return std::nullopt;
    std::vector<std::string> out;
    for (const toml::node& entry : *array) {
      if (const auto* text = entry.as_string()) {
        out.push_back(text->get());
      } else if (const auto* whole = entry.as_integer()) {
        out.push_back(std::to_string(whole->get()));
      } else {
        return std::nullopt;
      }
    }
    return out;
  }

  void add(const toml::key& key, const std::string& name, KeyKind kind, ConfigValue value) {
    const std::string shown = place(key) + ": " + name + " = " + toToml(value);
    if (auto* text = std::get_if<std::string>(&value); text && kind == KeyKind::kPath) {
      // An absolute path stays as it is; an empty one is a mistake that set() names.
      if (!text->empty()) *text = (folder_ / *text).string();
    }
    settings_.push_back({name, std::move(value), place(key), shown});
  }

  const std::string path_;
  const std::filesystem::path folder_;
  std::vector<std::string> names_;
  std::vector<std::string> tables_;
  Settings settings_;
};

}  // namespace

Result<Settings> settingsOfFile(std::string_view text, const std::string& path) {
  try {
    return Reader(path).read(toml::parse(text));
  } catch (const toml::parse_error& failure) {
    return invalidInput(path + ":" + std::to_string(failure.source().begin.line) + ": " +
                        std::string(failure.description()));
  }
}

Result<Settings> settingsOfFile(const std::string& path) {
  const auto text = readSmallFile(path, kMostBytes);
  if (!text) return text.error();
  return settingsOfFile(text.value(), path);
}

}  // namespace culld::server
