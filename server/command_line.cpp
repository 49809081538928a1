#include "server/command_line.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <iostream>
#include <utility>

#include "protocol/text.h"

namespace culld {

ExitCode exitCodeOf(const Error& error) noexcept {
  return error.code == ErrorCode::kUnavailable ? kUnavailable : kUsage;
}

int fail(ExitCode code, std::string_view message) {
  std::fprintf(stderr, "culld: %s\n", protocol::oneLine(message).c_str());
  return code;
}

void refuseEmptyText(CLI::App& app) {
  for (CLI::Option* option : app.get_options()) {
    if (option->get_expected_max() == 0) continue;  // a flag
    option->check([](const std::string& text) { return text.empty() ? "is empty" : ""; });
  }
  for (CLI::App* command : app.get_subcommands({})) refuseEmptyText(*command);
}

std::optional<int> parseArguments(CLI::App& app, std::vector<std::string> arguments) {
  refuseEmptyText(app);
  std::reverse(arguments.begin(), arguments.end());  // the order that CLI11 takes
  try {
    app.parse(std::move(arguments));
  } catch (const CLI::CallForHelp&) {
    std::cout << app.help();
    return kFine;
  } catch (const CLI::ParseError& error) {
    return fail(kUsage, error.what());
  }
  return std::nullopt;
}

int checkStdout(int code) {
  const auto written = protocol::flushStdout();
  return written || code != kFine ? code : fail(kDisk, written.error().message);
}

}  // namespace culld
