// `culld cull`: answers a file of cameras on one scene in this process, without a daemon.
#pragma once
#include <string>
#include <vector>

namespace culld {

/// Runs the command with the arguments that follow the word `cull`; what is wrong is said on stderr
/// in one line. Returns the exit code of the program (docs/clients.md "Exit codes").
int runCull(std::vector<std::string> arguments);

}  // namespace culld
