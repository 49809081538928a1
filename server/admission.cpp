#include "server/admission.h"

#include <algorithm>
#include <string>
#include <utility>

namespace culld::server {
namespace {

using Kind = Route::Kind;

constexpr std::string_view kTicketPrefix = "culld.ticket.";

bool sameText(std::string_view a, std::string_view b) noexcept {
  const auto lower = [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  };
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [lower](char x, char y) { return lower(x) == lower(y); });
}

std::string_view withoutPort(std::string_view host) noexcept {
  if (host.starts_with('[')) return host.substr(0, host.find(']') + 1);
  return host.substr(0, host.find(':'));
}

/// A name under which a stranger's web page can have been loaded: the owner of a domain may let it
/// point here (DNS rebinding). Addresses, and names without a dot, have no such owner.
bool strangersName(std::string_view host) noexcept {
  const std::string_view name = withoutPort(host);
  if (name.starts_with('[') || name.find('.') == std::string_view::npos) return false;
  return name.find_first_not_of("0123456789.") != std::string_view::npos;
}

HttpReply refusal(unsigned status, const char* reason, const std::string& message,
                  Metrics& metrics) {
  metrics.authFailed(reason);
  return errorReply(status, message);
}

HttpReply unauthorized(const char* reason, const std::string& message, Metrics& metrics) {
  HttpReply reply = refusal(401, reason, message, metrics);
  const bool missing = std::string_view(reason) == "missing";
  reply.headers.emplace_back("WWW-Authenticate", missing ? "Bearer realm=\"culld\""
                                                         : "Bearer realm=\"culld\", "
                                                           "error=\"invalid_token\"");
  return reply;
}

bool ownOrigin(const RequestFacts& facts) noexcept {
  const std::string_view origin = *facts.origin;
  const auto mark = origin.find("://");
  if (mark == std::string_view::npos || !sameText(origin.substr(mark + 3), facts.host)) {
    return false;
  }
  return facts.tls || !strangersName(facts.host);  // a certificate cannot be rebound
}

std::optional<HttpReply> refuseOrigin(const RequestFacts& facts, const Gate& gate) {
  if (!facts.origin || ownOrigin(facts) || gate.access.listsOrigin(*facts.origin)) {
    return std::nullopt;
  }
  return refusal(403, "origin",
                 "Origin: \"" + std::string(facts.origin->substr(0, 200)) +
                     "\" is neither this server's own nor among its origins",
                 gate.metrics);
}

/// Where nobody has to say who he is, a browser on the operator's machine is a way in.
std::optional<HttpReply> refuseHost(const RequestFacts& facts, const Gate& gate) {
  if (gate.access.needsTokens() || facts.tls || facts.peer.unix_socket ||
      !strangersName(facts.host) || gate.access.listsHost(facts.host)) {
    return std::nullopt;
  }
  return refusal(403, "host",
                 "Host: \"" + std::string(facts.host.substr(0, 200)) +
                     "\" is no address, and among no origins of this server",
                 gate.metrics);
}

/// The ticket among the subprotocols; none: there is none.
std::optional<std::string_view> ticketIn(std::string_view offered) noexcept {
  while (!offered.empty()) {
    const auto comma = offered.find(',');
    std::string_view word = offered.substr(0, comma);
    offered = comma == std::string_view::npos ? std::string_view() : offered.substr(comma + 1);
    const auto first = word.find_first_not_of(" \t");
    if (first == std::string_view::npos) continue;
    word = word.substr(first, word.find_last_not_of(" \t") - first + 1);
    if (word.starts_with(kTicketPrefix)) return word.substr(kTicketPrefix.size());
  }
  return std::nullopt;
}

/// RFC 6750 section 2.1. None: not of that form.
std::optional<std::string_view> bearerToken(std::string_view header) noexcept {
  constexpr std::string_view kScheme = "Bearer ";
  if (header.size() <= kScheme.size() || !sameText(header.substr(0, kScheme.size()), kScheme)) {
    return std::nullopt;
  }
  const std::string_view token = header.substr(kScheme.size());
  return token.substr(std::min(token.find_first_not_of(' '), token.size()));
}

std::variant<Grant, HttpReply> whoAsks(const RequestFacts& facts, const Gate& gate) {
  Access& access = gate.access;
  const auto standing = access.standing(facts.peer);
  if (!access.needsTokens()) return *standing;
  if (facts.authorization) {
    const auto token = bearerToken(*facts.authorization);
    if (!token) {
      return unauthorized("malformed", "Authorization: not \"Bearer TOKEN\"", gate.metrics);
    }
    if (auto grant = access.ofToken(*token)) return *std::move(grant);
    return unauthorized("token", "Authorization: this token is not known here", gate.metrics);
  }
  if (facts.route.kind == Kind::kLive) {
    if (const auto ticket = ticketIn(facts.subprotocols)) {
      if (auto grant = access.tickets().redeem(*ticket, gate.now)) {
        return *std::move(grant);
      }
      return unauthorized("ticket", "this ticket is not known here, was used, or is too old",
                          gate.metrics);
    }
  }
  if (standing) return *standing;
  return unauthorized("missing", "Authorization: a token is due here: \"Bearer TOKEN\"",
                      gate.metrics);
}

std::optional<HttpReply> refuseScope(const RequestFacts& facts, const Grant& grant, Scope needed,
                                     Metrics& metrics) {
  if (grant.scope < needed) {
    return refusal(
        403, "scope",
        std::string("the token has not the scope ") + nameOf(needed) + ", which this takes",
        metrics);
  }
  if (facts.route.kind == Kind::kMetrics && !grant.tenant->name().empty()) {
    return refusal(403, "scope", "metrics speak of all tenants, and take a token without one",
                   metrics);
  }
  return std::nullopt;
}

/// What a browser asks before it lets a script of another origin send a token.
HttpReply preflight() {
  HttpReply reply{204, "application/json", "", {}};
  reply.headers.emplace_back("Access-Control-Allow-Methods", "GET, HEAD, PUT, DELETE, POST");
  reply.headers.emplace_back("Access-Control-Allow-Headers", "Authorization, Content-Type");
  reply.headers.emplace_back("Access-Control-Max-Age", "600");
  return reply;
}

}  // namespace

std::optional<Scope> neededScope(std::string_view method, Kind kind) noexcept {
  switch (kind) {
    case Kind::kUnknown:
    case Kind::kPage:
    case Kind::kLivez:
    case Kind::kReadyz:
    case Kind::kVersion:
      return std::nullopt;
    case Kind::kScene:
      return method == "GET" || method == "HEAD" ? Scope::kRead : Scope::kAdmin;
    case Kind::kMetrics:
    case Kind::kStatus:
    case Kind::kScenes:
    case Kind::kObjects:
    case Kind::kLive:
    case Kind::kTickets:
      break;
  }
  return Scope::kRead;
}

std::variant<Grant, HttpReply> admit(const RequestFacts& facts, const Gate& gate) {
  if (auto refused = refuseOrigin(facts, gate)) return *std::move(refused);
  if (facts.method == "OPTIONS" && facts.origin) return preflight();
  const auto needed = neededScope(facts.method, facts.route.kind);
  if (!needed) return gate.access.stranger();
  if (auto refused = refuseHost(facts, gate)) return *std::move(refused);
  auto asked = whoAsks(facts, gate);
  const Grant* grant = std::get_if<Grant>(&asked);
  if (grant == nullptr) return asked;
  if (auto refused = refuseScope(facts, *grant, *needed, gate.metrics)) {
    return *std::move(refused);
  }
  if (const auto spent = grant->tenant->refuseBytes(gate.now)) {
    return quotaReply(*spent, gate.metrics);
  }
  return asked;
}

void letOriginRead(std::string_view origin, HttpReply& reply) {
  reply.headers.emplace_back("Access-Control-Allow-Origin", std::string(origin));
  reply.headers.emplace_back("Vary", "Origin");
}

HttpReply quotaReply(const QuotaRefusal& refusal, Metrics& metrics) {
  metrics.quotaRejected(nameOf(refusal.reason));
  HttpReply reply = errorReply(429, refusal.message);
  reply.headers.emplace_back("Retry-After", std::to_string(refusal.retry_after.count()));
  return reply;
}

}  // namespace culld::server
