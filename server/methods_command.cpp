#include "server/methods_command.h"

#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>

#include "culling/culler.h"

namespace culld {

int runMethods(bool json) {
  nlohmann::json table = nlohmann::json::array();
  for (const Method* method : allMethods()) {
    const MethodInfo info = method->info();
    table.push_back({{"name", std::string(info.name)},
                     {"source", std::string(info.source)},
                     {"guarantee", std::string(guaranteeName(info.guarantee))},
                     {"needs", std::string(info.needs)}});
  }
  if (json) {
    std::printf("%s\n", table.dump(2).c_str());
    return 0;
  }
  const auto text = [](const nlohmann::json& row, const char* key) {
    return row.at(key).get<std::string>();
  };
  std::printf("%-12s %-13s %-12s %s\n", "name", "guarantee", "needs", "source");
  for (const auto& row : table) {
    std::printf("%-12s %-13s %-12s %s\n", text(row, "name").c_str(), text(row, "guarantee").c_str(),
                text(row, "needs").c_str(), text(row, "source").c_str());
  }
  return 0;
}

}  // namespace culld
