// What each path of the HTTP side means, free of sockets: a request in, a reply out.
#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "server/context.h"

namespace culld::server {

struct HttpReply {
  unsigned status = 200;
  std::string content_type = "application/json";
  std::string body;
  std::vector<std::pair<std::string, std::string>> headers;
  std::string error = {};  ///< of an errorReply(), for the log
};

/// {"error": message} with a status.
HttpReply errorReply(unsigned status, const std::string& message);
/// The status that stands for an engine error about an upload or a scene.
HttpReply errorReply(const Error& error);

/// A path taken apart. `scene` is not yet checked.
struct Route {
  enum class Kind {
    kUnknown,
    kPage,
    kLivez,
    kReadyz,
    kVersion,
    kMetrics,
    kStatus,
    kScenes,
    kScene,
    kObjects,
    kLive,
    kTickets
  };
  Kind kind = Kind::kUnknown;
  std::string scene;
  std::string path;  ///< without scheme, host and query
};

/// Takes "/path" and "http://host/path" for the same, and ignores a query.
Route routeOf(std::string_view target);
/// The refusal of a route that speaks of a scene by a name that cannot be.
std::optional<HttpReply> refuseName(const Route& route);
/// "GET, HEAD", ...: what a route allows.
std::string_view allowedMethods(Route::Kind kind) noexcept;

/// Everything but PUT of a scene and the live path, which need their connection.
/// THREADS: the I/O thread, except heavy().
/// REQUIRES: `grant` suffices for the request (server/admission.h).
HttpReply handleRequest(std::string_view method, const Route& route, const Grant& grant,
                        Context& context);
/// Worth a worker's thread: large replies, or the disk.
bool heavy(std::string_view method, const Route& route) noexcept;

/// The scene that a tenant means by a name: its own, else the operator's, which all may see.
std::shared_ptr<Scene> findScene(const std::string& name, const Grant& grant, Context& context);
/// Why an upload under this name would come to more than the tenant's share.
std::optional<HttpReply> refuseShare(const std::string& scene, const Grant& grant,
                                     Context& context);
/// The reply to an upload that was received whole.
HttpReply finishPut(const std::string& scene, Upload upload, const Grant& grant, Context& context);

}  // namespace culld::server
