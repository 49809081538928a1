// The program culld: reads the command line and hands over to the command.
#include <CLI/CLI.hpp>
#include <exception>
#include <string>

#include "server/bench_command.h"
#include "server/build_info.h"
#include "server/check_config_command.h"
#include "server/command_line.h"
#include "server/cull_command.h"
#include "server/methods_command.h"
#include "server/plan_command.h"
#include "server/serve_command.h"

namespace culld {
namespace {

struct Arguments {
  ServeArguments serve;
  bool json = false;
};

int run(int argc, char** argv) {
  CLI::App app("culld answers which objects of a scene a camera can see", "culld");
  app.set_version_flag("--version", server::serverName());
  app.require_subcommand(1);
  Arguments arguments;
  CLI::App* serve = app.add_subcommand("serve", "Runs the daemon");
  serve->add_option("--config", arguments.serve.config_file, "TOML file; flags win over it");
  addServeFlags(*serve, arguments.serve);
  CLI::App* check = app.add_subcommand("check-config", "Prints what serve would be told");
  check->add_option("FILE", arguments.serve.config_file, "TOML file")->required();
  addServeFlags(*check, arguments.serve);
  CLI::App* cull = app.add_subcommand("cull", "Answers a file of cameras in this process");
  cull->prefix_command();
  cull->set_help_flag();
  CLI::App* bench = app.add_subcommand("bench", "Measures error against run time");
  bench->prefix_command();
  bench->set_help_flag();
  CLI::App* plan = app.add_subcommand("plan", "Says what is used for a scene, and why");
  plan->prefix_command();
  plan->set_help_flag();
  CLI::App* methods = app.add_subcommand("methods", "Lists the culling methods");
  methods->add_flag("--json", arguments.json);
  refuseEmptyText(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& failure) {
    if (failure.get_exit_code() == 0) return app.exit(failure);  // --help, --version
    return fail(kUsage, failure.what());
  }
  if (cull->parsed()) return runCull(cull->remaining());
  if (bench->parsed()) return runBench(bench->remaining(), allMethods());
  if (plan->parsed()) return runPlan(plan->remaining());
  if (check->parsed()) return runCheckConfig(arguments.serve);
  if (!serve->parsed()) return runMethods(arguments.json);
  return runServe(arguments.serve);
}

}  // namespace
}  // namespace culld

int main(int argc, char** argv) {
  try {
    return culld::checkStdout(culld::run(argc, argv));
  } catch (const std::exception& failure) {
    return culld::fail(culld::kFailed, failure.what());
  }
}
