#include "server/tokens_file.h"

#include <toml++/toml.h>

#include <algorithm>
#include <set>

#include "protocol/text.h"
#include "server/disk.h"

namespace culld::server {
namespace {

constexpr std::size_t kMaxFileBytes = std::size_t{1} << 20;
/// All of them are compared with each that a request brings.
constexpr std::size_t kMaxTokens = 1000;
/// Large enough for any machine, small enough to be counted in nanoseconds.
constexpr std::int64_t kMaxQuota = 1'000'000'000'000;

/// Turns the tree of one file into tokens. The first mistake is kept.
class Reader {
 public:
  explicit Reader(const std::string& name) : name_(name) {}

  Result<TokensFile> read(const toml::table& root) {
    for (const auto& [key, value] : root) {
      if (key == "token") {
        readTokens(value);
      } else if (key == "tenant") {
        readTenants(value);
      } else {
        wrong(key, "unknown key \"" + std::string(key.str()) + "\": not token or tenant");
      }
    }
    refuseTwice();
    refuseIdleTenants();
    if (error_) return *std::move(error_);
    return std::move(out_);
  }

 private:
  template <typename Node>
  void wrong(const Node& at, const std::string& what, ErrorCode code = ErrorCode::kInvalidInput) {
    if (error_) return;
    const std::string line = std::to_string(at.source().begin.line);
    error_ = Error{code, protocol::oneLine(name_ + ": line " + line + ": " + what)};
  }

  void readTokens(const toml::node& node) {
    const toml::array* list = node.as_array();
    if (list == nullptr || !list->is_homogeneous<toml::table>()) {
      return wrong(node, "token: not a list of tables; write [[token]]");
    }
    if (list->size() > kMaxTokens) {
      return wrong(node, "more than " + std::to_string(kMaxTokens) + " tokens", ErrorCode::kLimit);
    }
    for (const toml::node& token : *list) readToken(*token.as_table());
  }

  void readToken(const toml::table& table) {
    TokenEntry entry;
    bool has_digest = false;
    bool has_scopes = false;
    for (const auto& [key, value] : table) {
      if (key == "sha256") {
        has_digest = true;
        readDigest(value, entry);
      } else if (key == "tenant") {
        entry.tenant = readTenantName(value);
      } else if (key == "scopes") {
        has_scopes = true;
        readScopes(value, entry);
      } else {
        wrong(key, "token: unknown key \"" + std::string(key.str()) +
                       "\": not sha256, tenant or scopes");
      }
    }
    if (!has_digest) wrong(table, "token: sha256 is missing");
    if (!has_scopes) wrong(table, "token: scopes is missing");
    lines_.push_back(table.source().begin.line);
    out_.tokens.push_back(std::move(entry));
  }

  void readDigest(const toml::node& node, TokenEntry& entry) {
    const auto digits = node.value_exact<std::string_view>();
    const auto digest = digits ? digestFromHex(*digits) : std::nullopt;
    // What is there instead may be the token itself: it is not repeated.
    if (!digest) return wrong(node, "token: sha256 is not 64 hexadecimal digits");
    if (same(*digest, sha256(""))) return wrong(node, "token: sha256 is that of no words at all");
    entry.digest = *digest;
  }

  std::string readTenantName(const toml::node& node) {
    const auto name = node.value_exact<std::string_view>();
    if (name && validSceneName(*name)) return std::string(*name);
    wrong(node, "token: tenant is not [A-Za-z0-9._-]{1,64}");
    return {};
  }

  void readScopes(const toml::node& node, TokenEntry& entry) {
    const toml::array* list = node.as_array();
    if (list == nullptr || list->empty()) return wrong(node, "token: scopes is not a list of any");
    for (const toml::node& item : *list) {
      const auto name = item.value_exact<std::string_view>();
      const auto scope = name ? scopeNamed(*name) : std::nullopt;
      if (!scope) return wrong(item, "token: a scope is one of read, edit, admin");
      entry.scope = std::max(entry.scope, *scope);
    }
  }

  void readTenants(const toml::node& node) {
    const toml::table* tenants = node.as_table();
    if (tenants == nullptr) return wrong(node, "tenant: not a table; write [tenant.NAME]");
    for (const auto& [key, value] : *tenants) {
      const toml::table* quotas = value.as_table();
      const std::string tenant(key.str());
      if (quotas == nullptr) return wrong(key, "tenant." + tenant + ": not a table");
      if (!validSceneName(tenant)) {
        return wrong(key, "tenant \"" + tenant + "\": not [A-Za-z0-9._-]{1,64}");
      }
      tenant_lines_[tenant] = key.source().begin.line;
      readQuotas(tenant, *quotas);
    }
  }

  void readQuotas(const std::string& tenant, const toml::table& table) {
    Quotas& quotas = out_.tenants[tenant];
    for (const auto& [key, value] : table) {
      std::uint64_t* at = key == "cull_ms_per_s" ? &quotas.cull_ms_per_s
                          : key == "bytes_per_s" ? &quotas.bytes_per_s
                          : key == "scenes"      ? &quotas.scenes
                                                 : nullptr;
      const std::string what = "tenant." + tenant + ": ";
      if (at == nullptr) {
        return wrong(key, what + "unknown key \"" + std::string(key.str()) +
                              "\": not cull_ms_per_s, bytes_per_s or scenes");
      }
      const auto number = value.value_exact<std::int64_t>();
      if (!number || *number < 1 || *number > kMaxQuota) {
        return wrong(value, what + std::string(key.str()) + ": not a whole number from 1 to " +
                                std::to_string(kMaxQuota));
      }
      *at = static_cast<std::uint64_t>(*number);
    }
  }

  void refuseTwice() {
    std::map<TokenDigest, toml::source_index> seen;
    for (std::size_t i = 0; i < out_.tokens.size() && !error_; ++i) {
      const auto [first, fresh] = seen.emplace(out_.tokens[i].digest, lines_[i]);
      if (fresh) continue;
      error_ = invalidInput(name_ + ": line " + std::to_string(lines_[i]) +
                            ": token: the same sha256 as in line " + std::to_string(first->second));
    }
  }

  /// Limits under a name that is misspelt would limit nobody.
  void refuseIdleTenants() {
    std::set<std::string> known;
    for (const TokenEntry& token : out_.tokens) known.insert(token.tenant);
    for (const auto& [tenant, line] : tenant_lines_) {
      if (known.contains(tenant) || error_) continue;
      error_ = invalidInput(name_ + ": line " + std::to_string(line) + ": tenant." + tenant +
                            ": no token names it");
    }
  }

  const std::string& name_;
  TokensFile out_;
  std::vector<toml::source_index> lines_;  ///< of out_.tokens
  std::map<std::string, toml::source_index> tenant_lines_;
  std::optional<Error> error_;
};

}  // namespace

Result<TokensFile> parseTokens(std::string_view text, const std::string& name) {
  try {
    const toml::table root = toml::parse(text, name);
    return Reader(name).read(root);
  } catch (const toml::parse_error& failure) {
    return invalidInput(protocol::oneLine(name + ": line " +
                                          std::to_string(failure.source().begin.line) + ": " +
                                          std::string(failure.description())));
  }
}

Result<TokensFile> readTokens(const std::string& path) {
  const auto text = readSmallFile(path, kMaxFileBytes);
  if (!text) return text.error();
  return parseTokens(text.value(), path);
}

}  // namespace culld::server
