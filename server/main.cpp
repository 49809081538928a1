// The program culld: reads the command line and hands over to the command.
#include <CLI/CLI.hpp>
#include <exception>
#include <string>

#include "culling/core/simd.h"
#include "server/bench_command.h"
#include "server/build_info.h"
#include "server/command_line.h"
#include "server/cull_command.h"
#include "server/methods_command.h"
#include "server/plan_command.h"
#include "server/serve_command.h"

namespace culld {
namespace {

struct Arguments {
  ServeArguments serve;
  std::string backend = "auto";
  std::string simd = "auto";
  bool json = false;
};

CLI::App* addServe(CLI::App& app, Arguments& arguments) {
  CLI::App* serve = app.add_subcommand("serve", "Runs the daemon");
  ServeArguments& s = arguments.serve;
  serve->add_option("--listen", s.listen, "HOST:PORT; port 0 takes a free one")
      ->capture_default_str();
  serve->add_option("--unix", s.unix_path, "Listen on this Unix socket too");
  serve->add_option("--data", s.data_folder, "Keep uploaded scenes here across restarts");
  serve->add_option("--scene", s.scenes, "NAME=FILE; may be repeated");
  serve->add_option("--threads", s.threads, "For culling; 0: as many as cores")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  serve->add_option("--backend", arguments.backend, "auto or cpu")->capture_default_str();
  serve->add_option("--simd", arguments.simd, "Force a SIMD target: sse4, avx2, avx3")
      ->capture_default_str();
  return serve;
}

int run(int argc, char** argv) {
  CLI::App app("culld answers which objects of a scene a camera can see", "culld");
  app.set_version_flag("--version", server::serverName());
  app.require_subcommand(1);
  Arguments arguments;
  const CLI::App* serve = addServe(app, arguments);
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
  if (!serve->parsed()) return runMethods(arguments.json);
  if (arguments.backend != "auto" && arguments.backend != "cpu") {
    return fail(kUsage, "--backend " + arguments.backend + ": this build has cpu only");
  }
  if (auto forced = forceSimdTarget(arguments.simd); !forced) {
    return fail(kUsage, forced.error().message);
  }
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
