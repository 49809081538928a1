// The file that says who holds a token and what it is good for (docs/protocol.md "Tokens").
#pragma once
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "culling/core/result.h"
#include "server/quota.h"
#include "server/scope.h"
#include "server/secret.h"

namespace culld::server {

struct TokenEntry {
  TokenDigest digest{};
  std::string tenant;  ///< empty: the operator
  Scope scope = Scope::kRead;
};

struct TokensFile {
  std::vector<TokenEntry> tokens;
  std::map<std::string, Quotas> tenants;  ///< those with limits
};

/// `name` is what messages call it. GUARANTEES: every digest is there once; every tenant with
/// limits has a token. ERROR: kInvalidInput, with the line; kLimit.
Result<TokensFile> parseTokens(std::string_view text, const std::string& name);
/// ERROR: as parseTokens; kIo.
Result<TokensFile> readTokens(const std::string& path);

}  // namespace culld::server
