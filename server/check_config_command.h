// `culld check-config`: what `culld serve` would be told, without serving.
#pragma once
#include "server/serve_arguments.h"

namespace culld {

/// Prints the configuration, each value with its origin. Returns the exit code of the program.
int runCheckConfig(const ServeArguments& arguments);

}  // namespace culld
