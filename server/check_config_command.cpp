#include "server/check_config_command.h"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <iostream>

#include "culling/core/simd.h"
#include "server/access.h"

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
  const server::Config& c = config.value();
  if (auto safe = checkListen(c); !safe) return fail(kConfig, safe.error().message);
  if (auto read = server::checkAccess(c.access, c.tls); !read) {
    return fail(kConfig, read.error().message);
  }
  if (auto forced = forceSimdTarget(c.simd); !forced) {
    return fail(mistakeIn(c), forced.error().message);
  }
  std::cout << server::describe(config.value());
  return kFine;
}

}  // namespace culld
