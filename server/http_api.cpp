#include "server/http_api.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "protocol/text.h"
#include "protocol/version.h"
#include "server/disk.h"
#include "server/plan_summary.h"
#include "server/status_page.h"

namespace culld::server {
namespace {

using nlohmann::json;
using Kind = Route::Kind;

constexpr std::string_view kScenesPath = "/v1/scenes";

std::string dump(const json& value) {
  // Names and messages may hold bytes that are not UTF-8.
  return value.dump(-1, ' ', false, json::error_handler_t::replace) + "\n";
}

HttpReply textReply(unsigned status, std::string body) {
  return {status, "text/plain; charset=utf-8", std::move(body) + "\n", {}};
}

json describeScene(const std::string& name, const SceneEntry& entry) {
  const SceneVersionPtr version = entry.scene->current();
  const SceneSnapshot& scene = *version->snapshot();
  const auto method = version->method("auto");
  return {{"name", name},
          {"objects", scene.objectCount()},
          {"triangles", scene.triangleCount()},
          {"version", scene.version()},
          {"hash", hex16(scene.contentHash())},
          {"bytes", entry.file_bytes},
          {"method", method ? std::string(method.value()->info().name) : ""},
          {"warnings", std::vector<std::string>(scene.warnings().begin(), scene.warnings().end())}};
}

json planJson(const SceneVersion& version) {
  const auto plan = summarizePlan(version);
  if (!plan) return nullptr;
  return {{"stages", plan->stages},
          {"occlusion", plan->occlusion},
          {"why", plan->why},
          {"gain_us", plan->gain_us}};
}

json usesJson(const std::vector<MethodUse>& uses) {
  json out = json::array();
  for (const MethodUse& use : uses) {
    out.push_back({{"method", use.method},
                   {"answers", use.answers},
                   {"out_of_budget", use.out_of_budget},
                   {"objects", use.objects},
                   {"cull_seconds", use.cull_seconds}});
  }
  return out;
}

HttpReply sceneList(Context& context) {
  json scenes = json::array();
  for (const auto& [name, entry] : context.store.list()) {
    scenes.push_back(describeScene(name, entry));
  }
  return {200, "application/json", dump({{"scenes", std::move(scenes)}}), {}};
}

HttpReply status(Context& context) {
  json scenes = json::array();
  for (const auto& [name, entry] : context.store.list()) {
    std::size_t sessions = 0;
    std::size_t views = 0;
    for (const LivePeer* peer : context.live) {
      if (peer->scene() != entry.scene) continue;
      ++sessions;
      views += peer->viewCount();
    }
    json scene = describeScene(name, entry);
    scene["sessions"] = sessions;
    scene["views"] = views;
    scene["plan"] = planJson(*entry.scene->current());
    scene["uses"] = usesJson(context.metrics.usesOf(entry.scene->name()));
    scenes.push_back(std::move(scene));
  }
  const Metrics::Totals t = context.metrics.totals();
  const auto up = std::chrono::duration<double>(context.clock.now() - context.started);
  return {200,
          "application/json",
          dump({{"version", context.server_name},
                {"ready", context.ready.load()},
                {"draining", context.draining.load()},
                {"uptime_s", up.count()},
                {"totals",
                 {{"connections", t.connections},
                  {"sessions", t.sessions},
                  {"views", t.views},
                  {"answers", t.answers},
                  {"answer_bytes", t.answer_bytes},
                  {"superseded", t.superseded},
                  {"errors", t.errors},
                  {"edits", t.edits},
                  {"cull_seconds", t.cull_seconds}}},
                {"scenes", std::move(scenes)}}),
          {}};
}

/// What each object is called in files: its glTF node and its number among the node's instances.
HttpReply objectTable(const std::string& name, const SceneEntry& entry) {
  const SceneVersionPtr version = entry.scene->current();
  const SceneSnapshot& scene = *version->snapshot();
  std::string nodes;
  std::string instances;
  for (std::size_t i = 0; i < scene.objectCount(); ++i) {
    const Instance& object = scene.instance(static_cast<ObjectId>(i));
    if (i > 0) nodes += ',', instances += ',';
    nodes += std::to_string(object.node);
    instances += std::to_string(object.instance_number);
  }
  return {200,
          "application/json",
          "{\"scene\":\"" + name + "\",\"version\":" + std::to_string(scene.version()) +
              ",\"objects\":" + std::to_string(scene.objectCount()) +
              ",\"triangles\":" + std::to_string(scene.triangleCount()) + ",\"nodes\":[" + nodes +
              "],\"instances\":[" + instances + "]}\n",
          {}};
}

HttpReply removeScene(const std::string& name, Context& context) {
  const auto removed = context.store.remove(name);
  if (!removed) return errorReply(removed.error());
  context.onIoThread([&context, scene = removed.value()] {
    context.metrics.scenesHeld(context.store.names(), context.store.damaged().size());
    if (scene == nullptr) return;  // nobody was served what was damaged
    context.goAway(scene.get(), "scene \"" + scene->name() + "\" was removed");
  });
  return {204, "application/json", "", {}};
}

HttpReply aboutScene(std::string_view method, const Route& route, Context& context) {
  if (auto refusal = refuseName(route)) return *std::move(refusal);
  if (method == "DELETE" && !context.ready) {
    return errorReply(503, "scene \"" + route.scene + "\": the server is still loading scenes");
  }
  if (method == "DELETE") return removeScene(route.scene, context);
  const auto scenes = context.store.list();
  const auto at = scenes.find(route.scene);
  if (at == scenes.end()) return errorReply(404, "scene \"" + route.scene + "\" is not known");
  if (route.kind == Kind::kObjects) return objectTable(at->first, at->second);
  return {200, "application/json", sceneJson(at->first, at->second), {}};
}

HttpReply readiness(const Context& context) {
  if (context.draining) return textReply(503, "draining");
  return context.ready ? textReply(200, "ready") : textReply(503, "loading");
}

HttpReply version(const Context& context) {
  return {200,
          "application/json",
          dump({{"server", context.server_name},
                {"protocol_min", protocol::kProtocolMin},
                {"protocol_max", protocol::kProtocolMax}}),
          {}};
}

/// What a proxy asks for as "http://HOST/PATH" is "/PATH" (RFC 9112 section 3.2.2).
std::string_view pathIn(std::string_view target) {
  for (const std::string_view scheme : {"http://", "https://"}) {
    const auto same = [](char a, char b) {
      return a == (b >= 'A' && b <= 'Z' ? static_cast<char>(b - 'A' + 'a') : b);
    };
    if (target.size() <= scheme.size() ||
        !std::equal(scheme.begin(), scheme.end(), target.begin(), same)) {
      continue;
    }
    const auto end = target.find_first_of("/?", scheme.size());
    if (end == scheme.size()) return {};  // no host
    if (end == std::string_view::npos || target[end] == '?') return "/";
    target.remove_prefix(end);
    break;
  }
  return target.substr(0, target.find('?'));
}

Route matched(std::string_view path) {
  if (path == "/") return {Kind::kPage, "", ""};
  if (path == "/livez") return {Kind::kLivez, "", ""};
  if (path == "/readyz") return {Kind::kReadyz, "", ""};
  if (path == "/version") return {Kind::kVersion, "", ""};
  if (path == "/metrics") return {Kind::kMetrics, "", ""};
  if (path == "/v1/status") return {Kind::kStatus, "", ""};
  if (path == kScenesPath) return {Kind::kScenes, "", ""};
  if (!path.starts_with(kScenesPath) || path[kScenesPath.size()] != '/') return {};
  const std::string_view rest = path.substr(kScenesPath.size() + 1);
  const auto slash = rest.find('/');
  std::string name(rest.substr(0, slash));
  if (slash == std::string_view::npos) return {Kind::kScene, std::move(name), ""};
  const std::string_view what = rest.substr(slash + 1);
  if (what == "live") return {Kind::kLive, std::move(name), ""};
  if (what == "objects") return {Kind::kObjects, std::move(name), ""};
  return {};
}

/// As messages name it: no longer than a line.
std::string quoted(const Route& route) {
  constexpr std::size_t kLongest = 200;
  return "path \"" + route.path.substr(0, kLongest) + "\"";
}

}  // namespace

std::string sceneJson(const std::string& name, const SceneEntry& entry) {
  return dump(describeScene(name, entry));
}

HttpReply errorReply(unsigned status, const std::string& message) {
  return {status, "application/json", dump({{"error", protocol::oneLine(message)}}), {}, message};
}

HttpReply errorReply(const Error& error) {
  switch (error.code) {
    case ErrorCode::kInvalidInput:
    case ErrorCode::kUnsupported:
      return errorReply(422, error.message);
    case ErrorCode::kNotFound:
      return errorReply(404, error.message);
    case ErrorCode::kLimit:
      return errorReply(413, error.message);
    case ErrorCode::kIo:
      return errorReply(500, error.message);
    case ErrorCode::kUnavailable:
      break;
  }
  return errorReply(503, error.message);
}

Route routeOf(std::string_view target) {
  const std::string_view path = pathIn(target);
  Route route = matched(path);
  route.path = std::string(path);
  return route;
}

std::optional<HttpReply> refuseName(const Route& route) {
  const bool named =
      route.kind == Kind::kScene || route.kind == Kind::kObjects || route.kind == Kind::kLive;
  if (!named || validSceneName(route.scene)) return std::nullopt;
  return errorReply(400, "scene name \"" + route.scene + "\": not [A-Za-z0-9._-]{1,64}");
}

std::string_view allowedMethods(Kind kind) noexcept {
  return kind == Kind::kScene ? "GET, HEAD, PUT, DELETE" : "GET, HEAD";
}

bool heavy(std::string_view method, const Route& route) noexcept {
  return route.kind == Kind::kObjects || (route.kind == Kind::kScene && method == "DELETE");
}

HttpReply handleRequest(std::string_view method, const Route& route, Context& context) {
  if (route.kind == Kind::kUnknown) return errorReply(404, quoted(route) + " is not known");
  const bool reads = method == "GET" || method == "HEAD";
  if (!reads && !(route.kind == Kind::kScene && method == "DELETE")) {
    HttpReply reply =
        errorReply(405, quoted(route) + ": method " + std::string(method) + ", allowed are " +
                            std::string(allowedMethods(route.kind)));
    reply.headers.emplace_back("Allow", std::string(allowedMethods(route.kind)));
    return reply;
  }
  switch (route.kind) {
    case Kind::kPage:
      return {200, "text/html; charset=utf-8", std::string(statusPage()), {}};
    case Kind::kLivez:
      return textReply(200, "live");
    case Kind::kReadyz:
      return readiness(context);
    case Kind::kVersion:
      return version(context);
    case Kind::kMetrics:
      return {200, "text/plain; version=0.0.4; charset=utf-8", context.metrics.text(), {}};
    case Kind::kStatus:
      return status(context);
    case Kind::kScenes:
      return sceneList(context);
    case Kind::kScene:
    case Kind::kObjects:
      return aboutScene(method, route, context);
    case Kind::kLive:
    case Kind::kUnknown:
      break;
  }
  if (auto refusal = refuseName(route)) return *std::move(refusal);
  HttpReply reply = errorReply(426, quoted(route) + ": a WebSocket upgrade is due here");
  reply.headers.emplace_back("Upgrade", "websocket");
  reply.headers.emplace_back("Connection", "Upgrade");
  return reply;
}

HttpReply finishPut(const std::string& scene, Upload upload, Context& context) {
  const auto fresh = context.store.finishUpload(scene, std::move(upload));
  if (!fresh) return errorReply(fresh.error());
  const auto scenes = context.store.list();
  const auto at = scenes.find(scene);
  if (at == scenes.end()) return errorReply(404, "scene \"" + scene + "\" was removed meanwhile");
  context.onIoThread([&context, held = at->second.scene] {
    context.metrics.scenesHeld(context.store.names(), context.store.damaged().size());
    context.sceneMoved(held.get());
  });
  return {fresh.value() ? 201U : 200U, "application/json", sceneJson(scene, at->second), {}};
}

}  // namespace culld::server
