// The program cullctl: reads the command line and hands over to the command.
#include <CLI/CLI.hpp>
#include <exception>
#include <functional>

#include "client/cli/commands.h"

namespace culld::client {
namespace {

struct Arguments {
  std::string connect = "ws://127.0.0.1:7420";
  Access access;
  std::string scene, file;
  bool json = false;
  std::uint32_t count = 1;
  FlyArguments fly;
};

/// Chosen while the command line is read, run afterwards.
using Command = std::function<int(const Server&)>;

void addScenes(CLI::App& app, Arguments& a, Command& command) {
  CLI::App* put = app.add_subcommand("put", "Upload a scene; one of that name is replaced");
  put->add_option("NAME", a.scene, "scene on the server")->required();
  put->add_option("FILE", a.file, "glTF scene, .glb")->required();
  put->add_flag("--json", a.json, "print JSON");
  put->callback(
      [&] { command = [&](const Server& at) { return runPut(at, a.scene, a.file, a.json); }; });
  CLI::App* list = app.add_subcommand("list", "List the scenes of the server");
  list->add_flag("--json", a.json, "print JSON");
  list->callback([&] { command = [&](const Server& at) { return runList(at, a.json); }; });
  CLI::App* info = app.add_subcommand("info", "Describe a scene");
  info->add_option("NAME", a.scene, "scene on the server")->required();
  info->add_flag("--json", a.json, "print JSON");
  info->callback([&] { command = [&](const Server& at) { return runInfo(at, a.scene, a.json); }; });
  CLI::App* remove = app.add_subcommand("remove", "Remove a scene from the server");
  remove->add_option("NAME", a.scene, "scene on the server")->required();
  remove->callback([&] { command = [&](const Server& at) { return runRemove(at, a.scene); }; });
}

void addPing(CLI::App& app, Arguments& a, Command& command) {
  CLI::App* ping = app.add_subcommand("ping", "Time the way to the server and back");
  ping->add_option("NAME", a.scene, "through the message layer of this scene");
  ping->add_option("--count", a.count, "so many times")->check(CLI::Range(1U, 1'000'000U));
  ping->add_flag("--json", a.json, "print JSON");
  ping->callback(
      [&] { command = [&](const Server& at) { return runPing(at, a.scene, a.count, a.json); }; });
}

void addCullOptions(CLI::App& app, CullArguments& a) {
  app.add_option("NAME", a.scene, "scene on the server")->required();
  app.add_option("--cameras", a.cameras, "cameras file, a JSON list")->required();
  app.add_option("--method", a.method, "culling method; auto: the server chooses");
  app.add_option("--guarantee", a.guarantee, "conservative, hole, sampled or approximate");
  app.add_option("--hole-px", a.demand.hole_px, "side of the hole accepted, with hole");
  app.add_option("--accept-missed-px", a.demand.accepted_missed_px,
                 "visible pixels that may be missed");
  app.add_option("--time-us", a.demand.time_us, "time per camera, in microseconds; 0: no limit");
  app.add_option("--width", a.width_px, "image width, for cameras that do not say");
  app.add_option("--height", a.height_px, "image height, for cameras that do not say");
}

void addCull(CLI::App& app, Arguments& a, Command& command) {
  CLI::App* cull = app.add_subcommand("cull", "Answer a file of cameras");
  addCullOptions(*cull, a.fly.cull);
  cull->add_option("-o,--output", a.fly.cull.output, "answers file to write")->required();
  cull->callback([&] { command = [&](const Server& at) { return runCull(at, a.fly.cull); }; });
  CLI::App* fly = app.add_subcommand("fly", "Fly along cameras and watch the answers");
  addCullOptions(*fly, a.fly.cull);
  auto* output = fly->add_option("-o,--output", a.fly.cull.output, "answers file to write");
  auto* json = fly->add_option("--json", a.fly.json_output, "per-frame measurements to write");
  fly->add_flag("--loop", a.fly.loop, "again and again, until interrupted")
      ->excludes(output)
      ->excludes(json);
  fly->callback([&] { command = [&](const Server& at) { return runFly(at, a.fly); }; });
}

/// An empty name or path is a shell variable that was never set, not a wish.
void refuseEmptyText(CLI::App& app) {
  for (CLI::Option* option : app.get_options()) {
    if (option->get_expected_max() == 0) continue;  // a flag
    option->check([](const std::string& text) { return text.empty() ? "is empty" : ""; });
  }
  for (CLI::App* command : app.get_subcommands({})) refuseEmptyText(*command);
}

int run(int argc, char** argv) {
  Arguments arguments;
  Command command;
  CLI::App app("asks a culld server which objects a camera can see", "cullctl");
  app.set_version_flag("--version", CULLD_VERSION);
  app.add_option("--connect", arguments.connect, "ws://HOST:PORT, wss://HOST:PORT or unix:PATH")
      ->capture_default_str();
  app.add_option("--token", arguments.access.token, "bearer token for the server")
      ->envname("CULLD_TOKEN");
  app.add_option("--ca", arguments.access.ca_file,
                 "certificates to trust with wss://, PEM; else those of the system");
  app.require_subcommand(1);
  app.fallthrough();
  addScenes(app, arguments, command);
  addPing(app, arguments, command);
  addCull(app, arguments, command);
  refuseEmptyText(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // help, version
    return fail(kUsage, error.what());
  }
  auto address = parseAddress(arguments.connect);
  if (!address) return fail(kUsage, "--connect " + address.error().message);
  return command({std::move(address).value(), arguments.access});
}

}  // namespace
}  // namespace culld::client

int main(int argc, char** argv) {
  try {
    return culld::client::checkStdout(culld::client::run(argc, argv));
  } catch (const std::exception& error) {  // out of memory, no threads
    return culld::client::fail(culld::client::kFailed, error.what());
  }
}
