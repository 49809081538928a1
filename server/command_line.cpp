#include "server/command_line.h"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <string>

#include "protocol/text.h"

namespace culld {

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

int checkStdout(int code) {
  const auto written = protocol::flushStdout();
  return written || code != kFine ? code : fail(kDisk, written.error().message);
}

}  // namespace culld
