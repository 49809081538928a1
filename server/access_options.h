// Who may use the daemon, and how they reach it, as the operator says it: plain data for the
// configuration to fill. Access and TlsKeys make something of it.
#pragma once
#include <string>
#include <vector>

namespace culld::server {

struct AccessOptions {
  std::string tokens_file;              ///< empty: who reaches the port may do everything
  std::vector<std::string> origins;     ///< of browsers, besides the server's own: "https://HOST"
  std::vector<std::string> unix_users;  ///< names or numbers; empty: whom the socket file lets in
  bool allow_public = false;            ///< a public address without tokens, or tokens without TLS
};

/// Of the TCP port; PEM files. Both or none.
struct TlsOptions {
  std::string certificate_file;  ///< the server's own first, then those that vouch for it
  std::string key_file;

  bool enabled() const noexcept { return !certificate_file.empty() || !key_file.empty(); }
};

}  // namespace culld::server
