#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <iostream>
#include <nlohmann/json.hpp>
#include <vector>

#include "client/cli/commands.h"
#include "client/cli/numbers.h"
#include "culld/connection.h"
#include "culld/scenes.h"

namespace culld::client {
namespace {

using nlohmann::json;

void print(const json& value) {
  std::cout << value.dump(2, ' ', false, json::error_handler_t::replace) << '\n';
}

json jsonOf(const SceneDetails& scene) {
  return {{"name", scene.info.name},
          {"objects", scene.info.objects},
          {"triangles", scene.info.triangles},
          {"version", scene.info.version},
          {"method", scene.method},
          {"bytes", scene.file_bytes},
          {"warnings", scene.warnings}};
}

std::string lineOf(const SceneDetails& scene) {
  return scene.info.name + ": " + std::to_string(scene.info.objects) + " objects, " +
         std::to_string(scene.info.triangles) + " triangles, version " +
         std::to_string(scene.info.version) + ", method " + scene.method;
}

void printScene(const SceneDetails& scene, bool as_json) {
  if (as_json) return print(jsonOf(scene));
  std::cout << lineOf(scene) << '\n';
  for (const std::string& warning : scene.warnings) std::cout << "  warning: " << warning << '\n';
}

/// A bar on the terminal while bytes go out; silent when stderr is a file or a pipe.
class UploadBar {
 public:
  explicit UploadBar(const std::string& what) : what_(what), shown_(isatty(2) == 1) {}
  ~UploadBar() {
    if (percent_ >= 0) std::fputs("\r\033[K", stderr);
  }
  void show(std::uint64_t sent, std::uint64_t total) {
    constexpr std::size_t kWidth = 40;
    const int percent = total == 0 ? 100 : static_cast<int>(sent * 100 / total);
    if (!shown_ || percent <= percent_) return;
    percent_ = percent;
    const std::size_t filled = kWidth * static_cast<std::size_t>(percent) / 100;
    const std::string bar = std::string(filled, '#') + std::string(kWidth - filled, '.');
    const char* after = percent == 100 ? ", the server loads it" : "";
    std::fprintf(stderr, "\rsending %s [%s] %3d%%%s", what_.c_str(), bar.c_str(), percent, after);
  }

 private:
  const std::string& what_;
  bool shown_;
  int percent_ = -1;
};

}  // namespace

int runPut(const Server& server, const std::string& scene, const std::string& file, bool as_json) {
  const auto put = [&] {
    UploadBar bar(file);
    return Scenes(server.address, server.access)
        .put(scene, file,
             [&bar](std::uint64_t sent, std::uint64_t total) { bar.show(sent, total); });
  }();
  if (!put && put.error().code == ErrorCode::kLimit) return fail(kUsage, put.error().message);
  if (!put) return fail(put.error());
  printScene(put.value(), as_json);
  return kFine;
}

int runList(const Server& server, bool as_json) {
  const auto scenes = Scenes(server.address, server.access).list();
  if (!scenes) return fail(scenes.error());
  if (as_json) {
    json list = json::array();
    for (const SceneDetails& scene : scenes.value()) list.push_back(jsonOf(scene));
    print(list);
  } else {
    for (const SceneDetails& scene : scenes.value()) std::cout << lineOf(scene) << '\n';
  }
  return kFine;
}

int runInfo(const Server& server, const std::string& scene, bool as_json) {
  const auto info = Scenes(server.address, server.access).info(scene);
  if (!info) return fail(info.error());
  printScene(info.value(), as_json);
  return kFine;
}

int runRemove(const Server& server, const std::string& scene) {
  const auto removed = Scenes(server.address, server.access).remove(scene);
  return removed ? kFine : fail(removed.error());
}

namespace {

Result<std::vector<double>> pingServer(const Server& server, std::uint32_t count) {
  std::vector<double> ms;
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto start = std::chrono::steady_clock::now();
    const auto about = Scenes(server.address, server.access).server();
    if (!about) return about.error();
    ms.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
                     .count());
  }
  return ms;
}

Result<std::vector<double>> pingScene(const Server& server, const std::string& scene,
                                      std::uint32_t count) {
  auto connection = Connection::open(server.address, scene, server.once());
  if (!connection) return std::move(connection).error();
  std::vector<double> ms;
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto time = connection.value()->ping();
    if (!time) return time.error();
    ms.push_back(std::chrono::duration<double, std::milli>(time.value()).count());
  }
  return ms;
}

}  // namespace

int runPing(const Server& server, const std::string& scene, std::uint32_t count, bool as_json) {
  const auto about = Scenes(server.address, server.access).server();
  if (!about) return fail(about.error());
  auto ms = scene.empty() ? pingServer(server, count) : pingScene(server, scene, count);
  if (!ms) return fail(ms.error());
  const double median = percentile(ms.value(), 50), p95 = percentile(ms.value(), 95);
  if (as_json) {
    print({{"server", about.value().name},
           {"protocol_min", about.value().protocol_min},
           {"protocol_max", about.value().protocol_max},
           {"count", count},
           {"median_ms", median},
           {"p95_ms", p95}});
  } else {
    std::printf("%s: %s, protocol %u to %u, median %.3f ms, p95 %.3f ms of %u\n",
                toString(server.address).c_str(), about.value().name.c_str(),
                about.value().protocol_min, about.value().protocol_max, median, p95, count);
  }
  return kFine;
}

}  // namespace culld::client
