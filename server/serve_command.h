// `culld serve`: runs the daemon until SIGTERM or SIGINT.
#pragma once
#include "server/serve_arguments.h"

namespace culld {

/// Returns the exit code of the program.
int runServe(const ServeArguments& arguments);

}  // namespace culld
