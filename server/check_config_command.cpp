#include "server/check_config_command.h"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <iostream>

namespace culld {

int runCheckConfig(const ServeArguments& arguments) {
  ExitCode code = kFine;
  const auto config = readConfig(arguments, code);
  if (!config) return fail(code, config.error().message);
  for (const auto& [name, file] : config.value().scenes) {
    if (::access(file.c_str(), R_OK) == 0) continue;
    return fail(mistakeIn(config.value()), config.value().origins.at("scenes." + name) +
                                               ": scenes." + name + ": " + file + ": " +
                                               std::strerror(errno));
  }
  if (auto safe = checkAccess(config.value()); !safe) return fail(kConfig, safe.error().message);
  std::cout << server::describe(config.value());
  return kFine;
}

}  // namespace culld
