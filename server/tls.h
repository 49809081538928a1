// The certificate and key of the TCP port, which an operator may renew while the daemon runs.
#pragma once
#include <chrono>
#include <memory>
#include <mutex>

#include "culling/core/result.h"
#include "server/access_options.h"

namespace boost::asio::ssl {
class context;
}

namespace culld::server {

using TlsContext = boost::asio::ssl::context;

/// THREADS: any.
class TlsKeys {
 public:
  /// ERROR: kInvalidInput, with the file's name: no certificate, no key, or one that is not the
  /// other's; a half of them. kIo: cannot be read.
  static Result<std::unique_ptr<TlsKeys>> open(const TlsOptions& options);
  ~TlsKeys();

  /// New connections get the new ones, old connections live on with theirs.
  void take(TlsKeys&& fresh);
  /// For the next connection.
  std::shared_ptr<TlsContext> current() const;
  /// When the certificate ends, as seconds since 1970.
  std::int64_t expires() const;

 private:
  struct Keys {
    std::shared_ptr<TlsContext> context;
    std::int64_t expires = 0;
  };
  explicit TlsKeys(Keys keys);
  static Result<Keys> read(const TlsOptions& options);

  mutable std::mutex mutex_;
  Keys keys_;
};

}  // namespace culld::server
