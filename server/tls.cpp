#include "server/tls.h"

#include <openssl/ssl.h>
#include <openssl/x509.h>

#include <boost/asio/ssl/context.hpp>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <fstream>
#include <utility>

#include "protocol/text.h"

namespace culld::server {
namespace {

namespace ssl = boost::asio::ssl;
using boost::system::error_code;

/// For TLS 1.2: forward secrecy and authenticated encryption only. All of TLS 1.3 is that.
constexpr const char* kCiphers = "ECDHE+AESGCM:ECDHE+CHACHA20";

Result<void> readable(const std::string& path) {
  const std::ifstream file(path, std::ios::binary);
  if (file) return Done{};
  return Error{ErrorCode::kIo, protocol::oneLine(path + ": cannot read: " + std::strerror(errno))};
}

Error wrongFile(const std::string& path, const char* what, const error_code& failure) {
  return invalidInput(protocol::oneLine(path + ": " + what + ": " + failure.message()));
}

std::int64_t expiryOf(ssl::context& context) {
  const X509* certificate = SSL_CTX_get0_certificate(context.native_handle());
  std::tm time{};
  if (certificate == nullptr || ASN1_TIME_to_tm(X509_get0_notAfter(certificate), &time) != 1) {
    return 0;
  }
  return static_cast<std::int64_t>(::timegm(&time));
}

}  // namespace

TlsKeys::TlsKeys(Keys keys) : keys_(std::move(keys)) {}
TlsKeys::~TlsKeys() = default;

Result<std::unique_ptr<TlsKeys>> TlsKeys::open(const TlsOptions& options) {
  auto keys = read(options);
  if (!keys) return keys.error();
  return std::unique_ptr<TlsKeys>(new TlsKeys(std::move(keys).value()));
}

void TlsKeys::take(TlsKeys&& fresh) {
  const std::scoped_lock lock(mutex_, fresh.mutex_);
  keys_ = std::move(fresh.keys_);
}

Result<TlsKeys::Keys> TlsKeys::read(const TlsOptions& options) {
  if (options.certificate_file.empty()) return invalidInput("tls: a key without a certificate");
  if (options.key_file.empty()) return invalidInput("tls: a certificate without a key");
  for (const std::string* path : {&options.certificate_file, &options.key_file}) {
    if (auto r = readable(*path); !r) return r.error();
  }
  auto context = std::make_shared<ssl::context>(ssl::context::tls_server);
  SSL_CTX* native = context->native_handle();
  SSL_CTX_set_min_proto_version(native, TLS1_2_VERSION);
  SSL_CTX_set_cipher_list(native, kCiphers);
  SSL_CTX_set_options(
      native, SSL_OP_NO_RENEGOTIATION | SSL_OP_NO_COMPRESSION | SSL_OP_CIPHER_SERVER_PREFERENCE);
  SSL_CTX_set_mode(native, SSL_MODE_RELEASE_BUFFERS);
  error_code failure;
  context->set_password_callback([](std::size_t, ssl::context::password_purpose) { return ""; },
                                 failure);
  context->use_certificate_chain_file(options.certificate_file, failure);
  if (failure) return wrongFile(options.certificate_file, "not a PEM certificate", failure);
  context->use_private_key_file(options.key_file, ssl::context::pem, failure);
  if (failure) {
    return wrongFile(options.key_file, "not the PEM key of the certificate", failure);
  }
  const std::int64_t expires = expiryOf(*context);
  return Keys{std::move(context), expires};
}

std::shared_ptr<TlsContext> TlsKeys::current() const {
  const std::lock_guard lock(mutex_);
  return keys_.context;
}

std::int64_t TlsKeys::expires() const {
  const std::lock_guard lock(mutex_);
  return keys_.expires;
}

}  // namespace culld::server
