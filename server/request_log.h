// What the log says about a request that was replied to.
#pragma once
#include <cstdint>
#include <string>

#include "server/http_api.h"
#include "server/log.h"

namespace culld::server {

/// Paths are without queries, and headers are not told: what lets somebody in may stand there.
struct AnsweredRequest {
  std::string method, peer;
  const Route& route;
  std::string stored_scene;          ///< of the path, as the store has it: it names the tenant
  std::uint64_t uploaded_bytes = 0;  ///< of a PUT
};

void logReply(Log& log, const AnsweredRequest& request, const HttpReply& reply);

}  // namespace culld::server
