// Whether a request is let in, and with what rights: the rules of access in words of HTTP, free of
// sockets.
#pragma once
#include <optional>
#include <string_view>
#include <variant>

#include "server/access.h"
#include "server/http_api.h"

namespace culld::server {

/// What the rules look at. The views live as long as the request.
struct RequestFacts {
  std::string_view method;
  const Route& route;
  Peer peer;
  bool tls = false;
  std::string_view host;
  std::optional<std::string_view> origin;         ///< only browsers send one
  std::optional<std::string_view> authorization;  ///< the header
  std::string_view subprotocols;                  ///< offered at an upgrade, as the header has them
};

/// Who decides, and when.
struct Gate {
  Access& access;
  Metrics& metrics;
  Time now;
};

/// What a method on a route asks for; none: it is open to all.
std::optional<Scope> neededScope(std::string_view method, Route::Kind kind) noexcept;

/// The rights that the request comes with, or its refusal: 401, 403 or 429, which is counted. A
/// browser's question before a request (OPTIONS) is answered here too.
std::variant<Grant, HttpReply> admit(const RequestFacts& facts, const Gate& gate);

/// Lets scripts of this origin, which the operator named, read the reply (CORS).
void letOriginRead(std::string_view origin, HttpReply& reply);

/// 429 with Retry-After, counted.
HttpReply quotaReply(const QuotaRefusal& refusal, Metrics& metrics);

}  // namespace culld::server
