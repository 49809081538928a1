// What a connection or a request may do, once it is known who asks.
#pragma once
#include <optional>

#include "server/quota.h"
#include "server/scope.h"
#include "server/secret.h"

namespace culld::server {

struct Grant {
  TenantPtr tenant;
  Scope scope = Scope::kRead;
  std::optional<TokenDigest> token;  ///< none: it did not come of a token
};

}  // namespace culld::server
