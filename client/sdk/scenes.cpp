#include "culld/scenes.h"

#include <charconv>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <system_error>

#include "client/sdk/dial.h"
#include "client/sdk/http.h"
#include "client/sdk/refusal.h"

namespace culld::client {
namespace {

using nlohmann::json;

/// Reads of a reply what has the right type; a server's word is no more trusted than a file's.
std::uint64_t numberIn(const json& object, const char* key) {
  const auto at = object.find(key);
  return at != object.end() && at->is_number_unsigned() ? at->get<std::uint64_t>() : 0;
}

std::string textIn(const json& object, const char* key) {
  const auto at = object.find(key);
  return at != object.end() && at->is_string() ? at->get<std::string>() : std::string();
}

std::uint64_t hashIn(const json& object) {
  const std::string hex = textIn(object, "hash");
  std::uint64_t hash = 0;
  std::from_chars(hex.data(), hex.data() + hex.size(), hash, 16);
  return hash;
}

std::optional<SceneDetails> sceneIn(const json& object) {
  if (!object.is_object() || textIn(object, "name").empty()) return std::nullopt;
  SceneDetails scene;
  scene.info.name = textIn(object, "name");
  scene.info.version = numberIn(object, "version");
  scene.info.content_hash = hashIn(object);
  scene.info.objects = static_cast<std::uint32_t>(numberIn(object, "objects"));
  scene.info.triangles = numberIn(object, "triangles");
  scene.file_bytes = numberIn(object, "bytes");
  scene.method = textIn(object, "method");
  const auto warnings = object.find("warnings");
  if (warnings == object.end() || !warnings->is_array()) return scene;
  for (const json& line : *warnings) {
    if (line.is_string()) scene.warnings.push_back(line.get<std::string>());
  }
  return scene;
}

std::optional<std::vector<std::uint32_t>> idsIn(const json& object, const char* key) {
  const auto at = object.find(key);
  if (at == object.end() || !at->is_array()) return std::nullopt;
  std::vector<std::uint32_t> ids;
  ids.reserve(at->size());
  for (const json& id : *at) {
    if (!id.is_number_unsigned() || id.get<std::uint64_t>() > 0xFFFFFFFFU) return std::nullopt;
    ids.push_back(id.get<std::uint32_t>());
  }
  return ids;
}

std::string pathOf(const std::string& name) { return "/v1/scenes/" + percentEncoded(name); }

Error unreadable(const Address& address) {
  return {ErrorCode::kUnavailable, toString(address) + ": the reply is not what a culld sends"};
}

/// The JSON of a reply that says yes.
Result<json> ask(const Address& address, const HttpRequest& request, const Access& access,
                 const HttpTimeouts& timeouts) {
  const auto reply = exchange(address, request, access, timeouts);
  if (!reply) return reply.error();
  const auto& [status, body] = reply.value();
  if (status < 200 || status > 299) return refusal(address, status, body);
  if (body.empty()) return json();
  auto parsed = json::parse(body, nullptr, false);
  if (!parsed.is_object()) return unreadable(address);
  return parsed;
}

Result<SceneDetails> sceneOf(const Address& address, const Result<json>& reply) {
  if (!reply) return reply.error();
  auto scene = sceneIn(reply.value());
  if (!scene) return unreadable(address);
  return *std::move(scene);
}

/// What the server says about an upload, with the file in place of the scene's name, which is all
/// that the server knows it by.
Error aboutFile(Error refusal, const std::string& name, const std::string& path) {
  if (refusal.message.rfind(name + ": ", 0) == 0) refusal.message.erase(0, name.size() + 2);
  refusal.message = path + ": " + refusal.message;
  return refusal;
}

}  // namespace

Scenes::Scenes(Address address, Access access, HttpTimeouts timeouts)
    : address_(std::move(address)), access_(std::move(access)), timeouts_(timeouts) {}

Result<ServerDetails> Scenes::server() const {
  const auto reply = ask(address_, {"GET", "/version", {}, {}}, access_, timeouts_);
  if (!reply) return reply.error();
  ServerDetails server;
  server.name = textIn(reply.value(), "server");
  server.protocol_min = static_cast<std::uint32_t>(numberIn(reply.value(), "protocol_min"));
  server.protocol_max = static_cast<std::uint32_t>(numberIn(reply.value(), "protocol_max"));
  if (server.name.empty()) return unreadable(address_);
  return server;
}

Result<std::vector<SceneDetails>> Scenes::list() const {
  const auto reply = ask(address_, {"GET", "/v1/scenes", {}, {}}, access_, timeouts_);
  if (!reply) return reply.error();
  const auto scenes = reply.value().find("scenes");
  if (scenes == reply.value().end() || !scenes->is_array()) return unreadable(address_);
  std::vector<SceneDetails> list;
  for (const json& object : *scenes) {
    auto scene = sceneIn(object);
    if (!scene) return unreadable(address_);
    list.push_back(*std::move(scene));
  }
  return list;
}

Result<SceneDetails> Scenes::info(const std::string& name) const {
  return sceneOf(address_, ask(address_, {"GET", pathOf(name), {}, {}}, access_, timeouts_));
}

Result<Done> Scenes::remove(const std::string& name) const {
  const auto reply = ask(address_, {"DELETE", pathOf(name), {}, {}}, access_, timeouts_);
  if (!reply) return reply.error();
  return Done{};
}

Result<SceneDetails> Scenes::put(const std::string& name, const std::string& path,
                                 const Progress& progress) const {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) {
    return Error{ErrorCode::kIo, path + ": cannot read: Is a directory"};
  }
  const auto reply = ask(address_, {"PUT", pathOf(name), path, progress}, access_, timeouts_);
  const bool refused = !reply && (reply.error().code == ErrorCode::kInvalidInput ||
                                  reply.error().code == ErrorCode::kLimit);
  if (refused) return aboutFile(reply.error(), name, path);
  return sceneOf(address_, reply);
}

Result<ObjectTable> Scenes::objects(const std::string& name) const {
  const auto reply = ask(address_, {"GET", pathOf(name) + "/objects", {}, {}}, access_, timeouts_);
  if (!reply) return reply.error();
  const auto nodes = idsIn(reply.value(), "nodes");
  const auto instances = idsIn(reply.value(), "instances");
  if (!nodes || !instances || nodes->size() != instances->size()) return unreadable(address_);
  ObjectTable table;
  table.version = numberIn(reply.value(), "version");
  table.names.reserve(nodes->size());
  for (std::size_t i = 0; i < nodes->size(); ++i) {
    table.names.push_back({(*nodes)[i], (*instances)[i]});
  }
  return table;
}

}  // namespace culld::client
