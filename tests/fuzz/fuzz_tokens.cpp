// Any text as a file of tokens: one line that says why not and where, or tokens of which each is
// there once and whose limits are somebody's.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <set>
#include <string_view>

#include "server/tokens_file.h"

namespace {

using namespace culld::server;

void require(bool holds) {
  if (!holds) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto parsed = parseTokens({reinterpret_cast<const char*>(data), size}, "fuzz");
  if (!parsed) {
    const std::string& line = parsed.error().message;
    require(line.starts_with("fuzz: line ") && line.size() > 13);
    for (const char c : line) require(c >= ' ' || static_cast<unsigned char>(c) >= 0x80);
    return 0;
  }
  const TokensFile& file = parsed.value();
  std::set<TokenDigest> digests;
  std::set<std::string> tenants;
  for (const TokenEntry& token : file.tokens) {
    digests.insert(token.digest);
    tenants.insert(token.tenant);
    require(token.tenant.find(':') == token.tenant.npos && token.tenant.size() <= 64);
  }
  require(digests.size() == file.tokens.size() && digests.size() <= 1000);
  for (const auto& [tenant, quotas] : file.tenants) {
    require(tenants.contains(tenant) && !tenant.empty());
  }
  return 0;
}
