#include "server/methods_command.h"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>

#include "culling/culler.h"

namespace culld {
namespace {

nlohmann::json settingsOf(const Method& method) {
  nlohmann::json table = nlohmann::json::array();
  for (const Setting& setting : method.settings()) {
    table.push_back({{"name", std::string(setting.name)},
                     {"meaning", std::string(setting.meaning)},
                     {"standard", valueText(setting, setting.standard)},
                     {"values", valuesOf(setting)}});
  }
  return table;
}

nlohmann::json methodsTable() {
  nlohmann::json table = nlohmann::json::array();
  for (const Method* method : allMethods()) {
    const MethodInfo info = method->info();
    table.push_back({{"name", std::string(info.name)},
                     {"source", std::string(info.source)},
                     {"guarantee", std::string(guaranteeName(info.guarantee))},
                     {"needs", std::string(info.needs)},
                     {"settings", settingsOf(*method)}});
  }
  return table;
}

std::string text(const nlohmann::json& row, const char* key) { return row.at(key); }

void printTable(const nlohmann::json& table) {
  std::size_t width = 0;
  for (const auto& row : table) width = std::max(width, text(row, "name").size());
  const auto line = [name_width = static_cast<int>(width)](
                        const std::string& name, const std::string& guarantee,
                        const std::string& needs, const std::string& source) {
    std::printf("%-*s %-13s %-12s %s\n", name_width, name.c_str(), guarantee.c_str(), needs.c_str(),
                source.c_str());
  };
  line("name", "guarantee", "needs", "source");
  for (const auto& row : table) {
    line(text(row, "name"), text(row, "guarantee"), text(row, "needs"), text(row, "source"));
    for (const auto& setting : row.at("settings")) {
      std::printf("  :%s=%s  %s (%s)\n", text(setting, "name").c_str(),
                  text(setting, "standard").c_str(), text(setting, "meaning").c_str(),
                  text(setting, "values").c_str());
    }
  }
}

}  // namespace

int runMethods(bool json) {
  const nlohmann::json table = methodsTable();
  if (json) {
    std::printf("%s\n", table.dump(2).c_str());
  } else {
    printTable(table);
  }
  return 0;
}

}  // namespace culld
