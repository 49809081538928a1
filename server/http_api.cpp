#include "server/http_api.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "protocol/text.h"
#include "protocol/version.h"
#include "server/admission.h"
#include "server/disk.h"
#include "server/plan_summary.h"
#include "server/scene_names.h"
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

json describeScene(std::string_view name, const SceneEntry& entry) {
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

/// What a tenant sees, by the names that it knows; its own scene hides the operator's of that name,
/// also if it is damaged.
std::map<std::string, SceneEntry> visibleScenes(const Grant& grant, Context& context) {
  std::map<std::string, SceneEntry> visible;
  for (auto& [stored, entry] : context.store.list()) {
    const std::string_view owner = ownerOf(stored);
    const std::string name(publicName(stored));
    if (owner.empty()) visible.emplace(name, entry);
    if (owner == grant.tenant->name()) visible.insert_or_assign(name, entry);
  }
  for (const std::string& stored : context.store.damaged()) {
    if (ownerOf(stored) == grant.tenant->name()) visible.erase(std::string(publicName(stored)));
  }
  return visible;
}

HttpReply sceneList(const Grant& grant, Context& context) {
  json scenes = json::array();
  for (const auto& [name, entry] : visibleScenes(grant, context)) {
    scenes.push_back(describeScene(name, entry));
  }
  return {200, "application/json", dump({{"scenes", std::move(scenes)}}), {}};
}

json totals(const Metrics::Totals& t) {
  return {{"connections", t.connections},
          {"sessions", t.sessions},
          {"views", t.views},
          {"answers", t.answers},
          {"answer_bytes", t.answer_bytes},
          {"superseded", t.superseded},
          {"errors", t.errors},
          {"edits", t.edits},
          {"cull_seconds", t.cull_seconds}};
}

void addUse(json& out, const Scene& scene, const Context& context) {
  std::size_t sessions = 0;
  std::size_t views = 0;
  for (const LivePeer* peer : context.live) {
    if (peer->scene().get() != &scene) continue;
    ++sessions;
    views += peer->viewCount();
  }
  out["sessions"] = sessions;
  out["views"] = views;
  out["uses"] = usesJson(context.metrics.usesOf(scene.name()));
}

/// How busy the others are is not a tenant's business.
HttpReply status(const Grant& grant, Context& context) {
  const std::string& tenant = grant.tenant->name();
  json scenes = json::array();
  for (const auto& [name, entry] : visibleScenes(grant, context)) {
    json scene = describeScene(name, entry);
    scene["plan"] = planJson(*entry.scene->current());
    if (ownerOf(entry.scene->name()) == tenant) addUse(scene, *entry.scene, context);
    scenes.push_back(std::move(scene));
  }
  const auto up = std::chrono::duration<double>(context.clock.now() - context.started);
  json out = {{"version", context.server_name},
              {"ready", context.ready.load()},
              {"draining", context.draining.load()},
              {"uptime_s", up.count()},
              {"scenes", std::move(scenes)}};
  if (tenant.empty()) out["totals"] = totals(context.metrics.totals());
  return {200, "application/json", dump(out), {}};
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

HttpReply removeScene(const std::string& name, const Grant& grant, Context& context) {
  const std::string stored = ownedName(grant.tenant->name(), name);
  if (!context.store.holds(stored) && findScene(name, grant, context) != nullptr) {
    context.metrics.authFailed("scope");
    return errorReply(403, "scene \"" + name + "\" is the operator's, not this tenant's");
  }
  const auto removed = context.store.remove(stored);
  if (!removed) return errorReply(removed.error());
  context.onIoThread([&context, name, scene = removed.value()] {
    context.metrics.scenesHeld(context.store.names(), context.store.damaged().size());
    if (scene == nullptr) return;  // nobody was served what was damaged
    context.goAway(scene.get(), "scene \"" + name + "\" was removed");
  });
  return {204, "application/json", "", {}};
}

HttpReply aboutScene(std::string_view method, const Route& route, const Grant& grant,
                     Context& context) {
  if (auto refusal = refuseName(route)) return *std::move(refusal);
  if (method == "DELETE" && !context.ready) {
    return errorReply(503, "scene \"" + route.scene + "\": the server is still loading scenes");
  }
  if (method == "DELETE") return removeScene(route.scene, grant, context);
  const auto scenes = visibleScenes(grant, context);
  const auto at = scenes.find(route.scene);
  if (at == scenes.end()) return errorReply(404, "scene \"" + route.scene + "\" is not known");
  if (route.kind == Kind::kObjects) return objectTable(at->first, at->second);
  return {200, "application/json", dump(describeScene(at->first, at->second)), {}};
}

HttpReply makeTicket(const Grant& grant, Context& context) {
  auto issued = context.access.tickets().issue(grant, context.clock.now());
  if (!issued) return errorReply(500, "no randomness to make a ticket of");
  if (const auto* refusal = std::get_if<QuotaRefusal>(&*issued)) {
    return quotaReply(*refusal, context.metrics);
  }
  return {201,
          "application/json",
          dump({{"ticket", *std::get_if<std::string>(&*issued)},
                {"expires_s", context.access.tickets().lifetime().count()}}),
          {}};
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
  if (path == "/v1/tickets") return {Kind::kTickets, "", ""};
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
  if (kind == Kind::kTickets) return "POST";
  return kind == Kind::kScene ? "GET, HEAD, PUT, DELETE" : "GET, HEAD";
}

bool heavy(std::string_view method, const Route& route) noexcept {
  return route.kind == Kind::kObjects || (route.kind == Kind::kScene && method == "DELETE");
}

std::shared_ptr<Scene> findScene(const std::string& name, const Grant& grant, Context& context) {
  const std::string own = ownedName(grant.tenant->name(), name);
  return context.store.find(context.store.holds(own) ? own : name);
}

HttpReply handleRequest(std::string_view method, const Route& route, const Grant& grant,
                        Context& context) {
  if (route.kind == Kind::kUnknown) return errorReply(404, quoted(route) + " is not known");
  if (route.kind == Kind::kTickets && method == "POST") return makeTicket(grant, context);
  const bool reads = route.kind != Kind::kTickets && (method == "GET" || method == "HEAD");
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
      return status(grant, context);
    case Kind::kScenes:
      return sceneList(grant, context);
    case Kind::kScene:
    case Kind::kObjects:
      return aboutScene(method, route, grant, context);
    case Kind::kLive:
    case Kind::kTickets:
    case Kind::kUnknown:
      break;
  }
  if (auto refusal = refuseName(route)) return *std::move(refusal);
  HttpReply reply = errorReply(426, quoted(route) + ": a WebSocket upgrade is due here");
  reply.headers.emplace_back("Upgrade", "websocket");
  reply.headers.emplace_back("Connection", "Upgrade");
  return reply;
}

std::optional<HttpReply> refuseShare(const std::string& scene, const Grant& grant,
                                     Context& context) {
  const std::string& tenant = grant.tenant->name();
  if (context.store.holds(ownedName(tenant, scene))) return std::nullopt;
  auto names = context.store.names();
  names.merge(context.store.damaged());
  const auto held = std::count_if(names.begin(), names.end(), [&tenant](const std::string& name) {
    return ownerOf(name) == tenant;
  });
  const auto refusal = grant.tenant->refuseScene(static_cast<std::size_t>(held));
  if (!refusal) return std::nullopt;
  return quotaReply(*refusal, context.metrics);
}

HttpReply finishPut(const std::string& scene, Upload upload, const Grant& grant, Context& context) {
  const std::lock_guard counted(grant.tenant->sceneChanges());
  if (auto refusal = refuseShare(scene, grant, context)) return *std::move(refusal);
  const std::string stored = ownedName(grant.tenant->name(), scene);
  const auto fresh = context.store.finishUpload(stored, std::move(upload));
  if (!fresh) return errorReply(fresh.error());
  const auto scenes = context.store.list();
  const auto at = scenes.find(stored);
  if (at == scenes.end()) return errorReply(404, "scene \"" + scene + "\" was removed meanwhile");
  context.onIoThread([&context, held = at->second.scene] {
    context.metrics.scenesHeld(context.store.names(), context.store.damaged().size());
    context.sceneMoved(held.get());
  });
  return {
      fresh.value() ? 201U : 200U, "application/json", dump(describeScene(scene, at->second)), {}};
}

}  // namespace culld::server
