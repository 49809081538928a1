// What the commands of culld have in common: exit codes, one line of error, the checks of arguments
// and of stdout that each of them needs.
#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "culling/core/result.h"

namespace CLI {
class App;
}

namespace culld {

/// docs/clients.md "Exit codes".
enum ExitCode { kFine = 0, kFailed = 1, kUsage = 2, kUnavailable = 69, kDisk = 74, kConfig = 78 };

/// What a command ends with after a failure that is not about its input's contents.
ExitCode exitCodeOf(const Error& error) noexcept;

/// Says what is wrong, in one line on stderr that begins with the program's name. Returns `code`.
int fail(ExitCode code, std::string_view message);

/// From now on an option of `app` or its subcommands that is given as "" is a usage error: an empty
/// name or path is a shell variable that was never set, not a wish.
void refuseEmptyText(CLI::App& app);

/// Parses the arguments of one command of culld. None: go on; else the exit code of --help, which
/// has been printed, or of a usage error, which has been said.
std::optional<int> parseArguments(CLI::App& app, std::vector<std::string> arguments);

/// `code`, or kDisk after it has said so if something that was printed never reached its reader.
int checkStdout(int code);

}  // namespace culld
