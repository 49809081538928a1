// Who may do what: tokens, tenants, tickets, origins of browsers, users of the Unix socket. Knows
// nothing of HTTP; server/admission.h does.
#pragma once
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "culling/core/result.h"
#include "server/access_options.h"
#include "server/grant.h"
#include "server/tickets.h"
#include "server/tokens_file.h"

namespace culld::server {

/// Refuses to tell secrets in public, or to let the public in, unless the operator allows it.
/// `listen_host` is an address, or localhost.
/// ERROR: kInvalidInput: one line that says how to allow it.
Result<void> checkExposure(const std::string& listen_host, const AccessOptions& access,
                           const TlsOptions& tls);

/// Reads all files as a start would. ERROR: kInvalidInput: the files' mistakes; a user whom this
/// machine does not know; kIo, kLimit.
Result<void> checkAccess(const AccessOptions& access, const TlsOptions& tls);

/// Reload it while it is used. THREADS: any.
class Access {
 public:
  /// ERROR: as checkAccess().
  static Result<std::unique_ptr<Access>> open(const AccessOptions& options,
                                              const TicketLimits& tickets = {});
  /// Reads everything again. GUARANTEES: tenants keep their debts; after an error all is as it was.
  Result<void> reload(const AccessOptions& options);

  /// False: anyone who reaches the port may do everything.
  bool needsTokens() const;
  bool mayConnect(const Peer& peer) const;
  /// What this peer may do without a token.
  std::optional<Grant> standing(const Peer& peer) const;
  /// For what is open to all.
  Grant stranger() const { return {operator_, Scope::kRead, std::nullopt, {}}; }
  std::optional<Grant> ofToken(std::string_view token) const;
  /// Whether `grant`, which `peer` uses, would still be given: false once its token was withdrawn
  /// or narrowed.
  bool stillGood(const Grant& grant, const Peer& peer) const;
  /// Whether the operator named this origin ("https://HOST[:PORT]").
  bool listsOrigin(std::string_view origin) const;
  /// Whether the operator named an origin of this host ("HOST[:PORT]").
  bool listsHost(std::string_view host) const;

  Tickets& tickets() noexcept { return tickets_; }

 private:
  struct Rules {
    bool tokens_needed = false;
    std::vector<Grant> grants;  ///< one per token
    std::set<std::string> origins;
    std::set<std::uint32_t> users;  ///< of the Unix socket, as the operator named them
  };
  explicit Access(const TicketLimits& tickets);
  Result<std::shared_ptr<const Rules>> read(const AccessOptions& options);
  std::shared_ptr<const Rules> rules() const;

  const TenantPtr operator_ = std::make_shared<Tenant>("");
  Tickets tickets_;
  mutable std::mutex mutex_;  ///< guards the rest
  std::shared_ptr<const Rules> rules_;
  std::map<std::string, TenantPtr> tenants_;
};

}  // namespace culld::server
