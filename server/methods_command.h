// `culld methods`: what this build can do.
#pragma once

namespace culld {

/// Prints the table of methods to stdout. Returns the exit code of the program.
int runMethods(bool json);

}  // namespace culld
