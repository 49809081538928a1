// The program cullctl: reads the command line and hands over to the command.
#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdlib>
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
  EditArguments edit;
  PairsArguments pairs;
  WatchArguments watch;
  LoadArguments load;
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

/// Returns the option --cameras.
CLI::Option* addCullOptions(CLI::App& app, CullArguments& a) {
  app.add_option("NAME", a.scene, "scene on the server")->required();
  auto* cameras = app.add_option("--cameras", a.cameras, "cameras file, a JSON list");
  app.add_option("--method", a.method, "culling method; auto: the server chooses");
  app.add_option("--guarantee", a.guarantee, "conservative, hole, sampled or approximate");
  app.add_option("--hole-px", a.demand.hole_px, "side of the hole accepted, with hole");
  app.add_option("--accept-missed-px", a.demand.accepted_missed_px,
                 "visible pixels that may be missed");
  app.add_option("--time-us", a.demand.time_us, "time per camera, in microseconds; 0: no limit");
  app.add_option("--width", a.width_px, "image width, for cameras that do not say");
  app.add_option("--height", a.height_px, "image height, for cameras that do not say");
  return cameras;
}

void addCull(CLI::App& app, Arguments& a, Command& command) {
  CLI::App* cull = app.add_subcommand("cull", "Answer a file of cameras");
  addCullOptions(*cull, a.fly.cull)->required();
  cull->add_option("-o,--output", a.fly.cull.output, "answers file to write")->required();
  cull->callback([&] { command = [&](const Server& at) { return runCull(at, a.fly.cull); }; });
  CLI::App* fly = app.add_subcommand("fly", "Fly along cameras and watch the answers");
  addCullOptions(*fly, a.fly.cull)->required();
  auto* output = fly->add_option("-o,--output", a.fly.cull.output, "answers file to write");
  auto* json = fly->add_option("--json", a.fly.json_output, "per-frame measurements to write");
  fly->add_flag("--loop", a.fly.loop, "again and again, until interrupted")
      ->excludes(output)
      ->excludes(json);
  fly->callback([&] { command = [&](const Server& at) { return runFly(at, a.fly); }; });
}

void addEdit(CLI::App& app, Arguments& a, Command& command) {
  EditArguments& e = a.edit;
  CLI::App* edit = app.add_subcommand("edit", "Change a scene: all of it or nothing");
  edit->add_option("NAME", e.scene, "scene on the server")->required();
  edit->add_option("--set", e.set, "ID=12 numbers: moves an object; rows of world from mesh")
      ->allow_extra_args(false);
  edit->add_option("--add", e.add, "ID=12 numbers: a further instance of the object's mesh")
      ->allow_extra_args(false);
  edit->add_option("--hide", e.hide, "IDs, with commas")->allow_extra_args(false);
  edit->add_option("--show", e.show, "IDs that were hidden")->allow_extra_args(false);
  edit->add_option("--remove", e.remove, "IDs, for good")->allow_extra_args(false);
  edit->add_option("--expect-version", e.expected_version, "only if the scene is at this version");
  edit->add_flag("--objects", e.by_object, "IDs are object ids, not nodes of the file");
  edit->add_flag("--json", e.json, "print JSON");
  edit->callback([&] { command = [&](const Server& at) { return runEdit(at, a.edit); }; });
  CLI::App* watch = app.add_subcommand("watch", "Follow the changes of a scene");
  watch->add_option("NAME", a.watch.scene, "scene on the server")->required();
  watch->add_option("--count", a.watch.count, "end after so many lines; 0: never");
  watch->add_flag("--json", a.watch.json, "print a JSON object a line");
  watch->callback([&] { command = [&](const Server& at) { return runWatch(at, a.watch); }; });
}

void addPairs(CLI::App& app, Arguments& a, Command& command) {
  CLI::App* pairs = app.add_subcommand("pairs", "Tell which viewers may see which targets");
  pairs->add_option("NAME", a.pairs.scene, "scene on the server")->required();
  pairs->add_option("--viewers", a.pairs.viewers, "places file, a JSON list")->required();
  pairs->add_option("--targets", a.pairs.targets, "places file, a JSON list")->required();
  pairs->add_option("--time-us", a.pairs.time_us, "time in microseconds; 0: two seconds");
  pairs->add_flag("--json", a.pairs.json, "print JSON");
  pairs->callback([&] { command = [&](const Server& at) { return runPairs(at, a.pairs); }; });
}

/// CLI::Range lets NaN through.
CLI::Validator aNumber() {
  const auto check = [](const std::string& text) {
    return std::isnan(std::strtod(text.c_str(), nullptr)) ? text + " is not a number" : "";
  };
  return {check, ""};
}

void addLoad(CLI::App& app, Arguments& a, Command& command) {
  LoadArguments& l = a.load;
  CLI::App* load = app.add_subcommand("load", "Send cameras of many clients by the clock");
  addCullOptions(*load, l.cull);
  const auto positive = CLI::Range(1e-3, 1e6);
  const auto not_negative = CLI::Range(0.0, 1e6);
  load->add_option("--clients", l.clients, "connections")->check(CLI::Range(1U, 10'000U));
  load->add_option("--views", l.views, "views of each")->check(CLI::Range(1U, 1'000U));
  load->add_option("--rate", l.rate_hz, "cameras a second and view")
      ->check(positive)
      ->check(aNumber());
  load->add_option("--seconds", l.seconds, "how long")->check(positive)->check(aNumber());
  load->add_option("--radius", l.radius_m, "motion bound, m: ask again on leaving it")
      ->check(not_negative)
      ->check(aNumber());
  load->add_option("--angle", l.angle_rad, "motion bound, radians")
      ->check(not_negative)
      ->check(aNumber());
  load->add_option("--late-ms", l.late_ms, "answers after this are late; 0: the time of a camera")
      ->check(not_negative)
      ->check(aNumber());
  load->add_option("--verify", l.verify_every, "ask every so manieth camera again; 0: none");
  load->add_flag("--json", l.json, "print JSON");
  load->callback([&] { command = [&](const Server& at) { return runLoad(at, a.load); }; });
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
  addEdit(app, arguments, command);
  addPairs(app, arguments, command);
  addLoad(app, arguments, command);
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
