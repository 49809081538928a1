#include "server/access.h"

#include <pwd.h>
#include <unistd.h>

#include <algorithm>
#include <boost/asio/ip/address.hpp>
#include <charconv>
#include <utility>

#include "protocol/text.h"
#include "server/tls.h"

namespace culld::server {
namespace {

std::string lowerCase(std::string_view text) {
  std::string out(text);
  for (char& c : out) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return out;
}

std::string_view afterScheme(std::string_view origin) {
  const auto at = origin.find("://");
  return at == std::string_view::npos ? origin : origin.substr(at + 3);
}

Result<std::string> readOrigin(const std::string& text) {
  const std::string origin = lowerCase(text);
  const std::string_view host = afterScheme(origin);
  const bool scheme = origin.starts_with("http://") || origin.starts_with("https://");
  if (scheme && !host.empty() && host.find_first_of("/?#@* ") == std::string_view::npos) {
    return origin;
  }
  return invalidInput(
      protocol::oneLine("origin \"" + text + "\": not http://HOST[:PORT] or https://HOST[:PORT]"));
}

Result<std::uint32_t> readUser(const std::string& text) {
  std::uint32_t number = 0;
  const char* end = text.data() + text.size();
  const auto [stop, failure] = std::from_chars(text.data(), end, number);
  if (failure == std::errc() && stop == end) return number;
  std::vector<char> buffer(16384);
  passwd entry{};
  passwd* found = nullptr;
  if (::getpwnam_r(text.c_str(), &entry, buffer.data(), buffer.size(), &found) == 0 &&
      found != nullptr) {
    return static_cast<std::uint32_t>(entry.pw_uid);
  }
  return invalidInput(protocol::oneLine("unix user \"" + text + "\": not known on this machine"));
}

/// Root may take the process over anyhow.
bool ownsProcess(const Peer& peer) { return peer.user == ::geteuid() || peer.user == 0; }

bool isPublic(const std::string& host) {
  boost::system::error_code failure;
  const auto address = boost::asio::ip::make_address(host, failure);
  // What is no address cannot be listened on, which the server says in its own words.
  return !failure && !address.is_loopback();
}

}  // namespace

Result<void> checkExposure(const std::string& listen_host, const AccessOptions& access,
                           const TlsOptions& tls) {
  const bool open = isPublic(listen_host) && !access.allow_public;
  if (open && access.tokens_file.empty()) {
    return invalidInput("listen " + listen_host +
                        ": a public address, and whoever reaches it may do everything; name a file "
                        "of tokens, or allow it with --allow-public");
  }
  if (open && !tls.enabled()) {
    return invalidInput("listen " + listen_host +
                        ": a public address, and tokens would cross the network in plain text; "
                        "name a certificate and its key, or allow it with --allow-public");
  }
  return Done{};
}

Result<void> checkAccess(const AccessOptions& access, const TlsOptions& tls) {
  if (tls.enabled()) {
    if (auto keys = TlsKeys::open(tls); !keys) return keys.error();
  }
  if (auto opened = Access::open(access); !opened) return opened.error();
  return Done{};
}

Access::Access(const TicketLimits& tickets) : tickets_(tickets) {}

Result<std::unique_ptr<Access>> Access::open(const AccessOptions& options,
                                             const TicketLimits& tickets) {
  std::unique_ptr<Access> access(new Access(tickets));
  if (auto read = access->reload(options); !read) return read.error();
  return access;
}

Result<void> Access::reload(const AccessOptions& options) {
  auto fresh = read(options);
  if (!fresh) return fresh.error();
  const std::lock_guard lock(mutex_);
  rules_ = std::move(fresh).value();
  return Done{};
}

Result<std::shared_ptr<const Access::Rules>> Access::read(const AccessOptions& options) {
  auto rules = std::make_shared<Rules>();
  for (const std::string& origin : options.origins) {
    auto read = readOrigin(origin);
    if (!read) return read.error();
    rules->origins.insert(std::move(read).value());
  }
  for (const std::string& user : options.unix_users) {
    const auto read = readUser(user);
    if (!read) return read.error();
    rules->users.insert(read.value());
  }
  rules->tokens_needed = !options.tokens_file.empty();
  if (!rules->tokens_needed) return std::shared_ptr<const Rules>(std::move(rules));
  const auto file = readTokens(options.tokens_file);
  if (!file) return file.error();
  const std::lock_guard lock(mutex_);
  for (const TokenEntry& token : file.value().tokens) {
    TenantPtr& tenant = tenants_[token.tenant];
    if (token.tenant.empty()) tenant = operator_;
    if (tenant == nullptr) tenant = std::make_shared<Tenant>(token.tenant);
    const auto quotas = file.value().tenants.find(token.tenant);
    tenant->setQuotas(quotas == file.value().tenants.end() ? Quotas{} : quotas->second);
    rules->grants.push_back({tenant, token.scope, token.digest, {}});
  }
  return std::shared_ptr<const Rules>(std::move(rules));
}

std::shared_ptr<const Access::Rules> Access::rules() const {
  const std::lock_guard lock(mutex_);
  return rules_;
}

bool Access::needsTokens() const { return rules()->tokens_needed; }

bool Access::mayConnect(const Peer& peer) const {
  if (!peer.unix_socket || ownsProcess(peer)) return true;
  const auto rules = this->rules();
  return rules->users.empty() || rules->users.contains(peer.user);
}

std::optional<Grant> Access::standing(const Peer& peer) const {
  const auto rules = this->rules();
  const bool known = peer.unix_socket && (ownsProcess(peer) || rules->users.contains(peer.user));
  if (rules->tokens_needed && !known) return std::nullopt;
  return Grant{operator_, Scope::kAdmin, std::nullopt, peer};
}

std::optional<Grant> Access::ofToken(std::string_view token) const {
  const TokenDigest digest = sha256(token);
  const auto rules = this->rules();
  std::optional<Grant> found;
  for (const Grant& grant : rules->grants) {
    if (same(*grant.token, digest)) found = grant;  // and on: time tells nothing
  }
  return found;
}

bool Access::stillGood(const Grant& grant, const Peer& peer) const {
  if (!mayConnect(peer)) return false;
  if (!grant.token) return standing(grant.given_to).has_value();
  const auto rules = this->rules();
  return std::any_of(rules->grants.begin(), rules->grants.end(), [&grant](const Grant& now) {
    return same(*now.token, *grant.token) && now.tenant == grant.tenant && now.scope >= grant.scope;
  });
}

bool Access::listsOrigin(std::string_view origin) const {
  return rules()->origins.contains(lowerCase(origin));
}

bool Access::listsHost(std::string_view host) const {
  const auto rules = this->rules();
  const std::string wanted = lowerCase(host);
  return std::any_of(
      rules->origins.begin(), rules->origins.end(),
      [&wanted](const std::string& origin) { return afterScheme(origin) == wanted; });
}

}  // namespace culld::server
