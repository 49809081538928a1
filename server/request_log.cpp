#include "server/request_log.h"

namespace culld::server {
namespace {

constexpr std::size_t kLongestPath = 200;

void logRefusal(Log& log, const AnsweredRequest& request, const HttpReply& reply) {
  const bool fault = reply.status == 500;
  const auto say = fault ? &Log::error : &Log::info;
  (log.*say)(fault ? "request failed" : "request refused",
             {{"method", request.method},
              {"path", request.route.path.substr(0, kLongestPath)},
              {"status", reply.status},
              {"peer", request.peer},
              {"error", reply.error}});
}

}  // namespace

void logReply(Log& log, const AnsweredRequest& request, const HttpReply& reply) {
  if (reply.status >= 400) return logRefusal(log, request, reply);
  if (request.method == "PUT") {
    return log.info("scene uploaded", {{"scene", request.stored_scene},
                                       {"peer", request.peer},
                                       {"bytes", request.uploaded_bytes},
                                       {"replaced", reply.status == 200}});
  }
  if (request.method == "DELETE") {
    return log.info("scene removed", {{"scene", request.stored_scene}, {"peer", request.peer}});
  }
  log.debug("request", {{"method", request.method},
                        {"path", request.route.path.substr(0, kLongestPath)},
                        {"peer", request.peer}});
}

}  // namespace culld::server
