// What a connection or a request may do, once it is known who asks.
#pragma once
#include <cstdint>
#include <optional>

#include "server/quota.h"
#include "server/scope.h"
#include "server/secret.h"

namespace culld::server {

/// Where a connection came from, as the kernel says.
struct Peer {
  bool unix_socket = false;
  std::uint32_t user = 0;  ///< of a Unix socket
};

struct Grant {
  TenantPtr tenant;
  Scope scope = Scope::kRead;
  std::optional<TokenDigest> token;  ///< none: it did not come of a token
  Peer given_to;                     ///< who had it first: a ticket is another's to redeem
};

}  // namespace culld::server
