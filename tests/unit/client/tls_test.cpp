// wss:// and tokens, against a TLS server of one connection with certificates made here.
#include <gtest/gtest.h>
#include <openssl/pem.h>
#include <openssl/x509v3.h>
#include <unistd.h>

#include <boost/asio/ssl.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/ssl.hpp>
#include <boost/beast/websocket.hpp>
#include <boost/beast/websocket/ssl.hpp>
#include <fstream>
#include <memory>
#include <string>
#include <thread>

#include "culld/connection.h"
#include "culld/scenes.h"
#include "tests/unit/client/scripted_server.h"

namespace culld::client {
namespace {

namespace ssl = boost::asio::ssl;

template <typename T, void (*kFree)(T*)>
struct Freed {
  void operator()(T* p) const { kFree(p); }
};
using Key = std::unique_ptr<EVP_PKEY, Freed<EVP_PKEY, EVP_PKEY_free>>;
using Certificate = std::unique_ptr<X509, Freed<X509, X509_free>>;

/// A certificate that vouches for itself, for `alt_name` ("IP:127.0.0.1").
struct Identity {
  explicit Identity(const std::string& alt_name)
      : key(EVP_EC_gen("P-256")), certificate(X509_new()) {
    X509* x = certificate.get();
    X509_set_version(x, 2);
    ASN1_INTEGER_set(X509_get_serialNumber(x), 1);
    X509_gmtime_adj(X509_getm_notBefore(x), -3600);
    X509_gmtime_adj(X509_getm_notAfter(x), 3600);
    X509_set_pubkey(x, key.get());
    X509_NAME* name = X509_get_subject_name(x);
    const unsigned char common[] = "culld test";
    X509_NAME_add_entry_by_txt(name, "CN", MBSTRING_ASC, common, -1, -1, 0);
    X509_set_issuer_name(x, name);
    extend(NID_basic_constraints, "critical,CA:TRUE");
    extend(NID_subject_alt_name, alt_name);
    X509_sign(x, key.get(), EVP_sha256());
  }
  void extend(int nid, const std::string& value) {
    X509_EXTENSION* extension = X509V3_EXT_conf_nid(nullptr, nullptr, nid, value.c_str());
    X509_add_ext(certificate.get(), extension, -1);
    X509_EXTENSION_free(extension);
  }
  void writeCertificate(const std::string& path) const {
    FILE* file = std::fopen(path.c_str(), "w");
    ASSERT_NE(file, nullptr);
    PEM_write_X509(file, certificate.get());
    std::fclose(file);
  }
  Key key;
  Certificate certificate;
};

class TlsServer {
 public:
  using Stream = websocket::stream<beast::ssl_stream<tcp::socket>>;
  TlsServer(const Identity& identity, std::function<void(Stream&)> play)
      : thread_([this, &identity, play = std::move(play)] {
          ssl::context context(ssl::context::tls_server);
          SSL_CTX_use_certificate(context.native_handle(), identity.certificate.get());
          SSL_CTX_use_PrivateKey(context.native_handle(), identity.key.get());
          Stream stream(acceptor_.accept(), context);
          beast::error_code ec;
          stream.next_layer().handshake(ssl::stream_base::server, ec);
          if (!ec) play(stream);
          handshake_failed = bool(ec);
        }) {}
  ~TlsServer() { join(); }
  void join() {
    if (thread_.joinable()) thread_.join();
  }
  Address address(const std::string& host = "127.0.0.1") const {
    return {host, acceptor_.local_endpoint().port(), {}, true};
  }
  bool handshake_failed = false;

 private:
  boost::asio::io_context io_;
  tcp::acceptor acceptor_{io_, tcp::endpoint(tcp::v4(), 0)};
  std::thread thread_;
};

const Identity& identity() {
  static const Identity kIdentity("IP:127.0.0.1,DNS:localhost");
  return kIdentity;
}

std::string certificateFile() {
  const std::string path =
      ::testing::TempDir() + "culld_tls_test_ca." + std::to_string(::getpid()) + ".pem";
  identity().writeCertificate(path);
  return path;
}

ConnectOptions trusting(const std::string& ca_file, const std::string& token = {}) {
  ConnectOptions options = quick();
  options.access = {token, ca_file};
  return options;
}

/// A conversation of one camera; returns the Authorization header of the upgrade.
std::string serveOneCamera(TlsServer::Stream& ws) {
  beast::flat_buffer in;
  http::request<http::string_body> upgrade;
  http::read(ws.next_layer(), in, upgrade);
  ws.set_option(websocket::stream_base::decorator([](websocket::response_type& reply) {
    reply.set(http::field::sec_websocket_protocol, protocol::kSubprotocol);
  }));
  ws.accept(upgrade);
  ws.binary(true);
  beast::error_code ec;
  for (;;) {
    beast::flat_buffer message;
    ws.read(message, ec);
    if (ec) break;
    const auto bytes = message.cdata();
    const auto said = protocol::decode(
        {static_cast<const std::uint8_t*>(bytes.data()), bytes.size()}, protocol::kMaxRequestBytes);
    Message reply{said.value().id, {}};
    if (std::holds_alternative<protocol::Hello>(said.value().body)) {
      protocol::Welcome welcome;
      welcome.protocol = protocol::kProtocolMax;
      welcome.scene = {"town", 1, 7, 1000, 5000};
      reply.body = welcome;
    } else if (std::holds_alternative<protocol::OpenView>(said.value().body)) {
      reply.body = protocol::ViewOpened{1, "raster", Guarantee::kConservative};
    } else if (std::holds_alternative<CameraUpdate>(said.value().body)) {
      reply.body = wholeAnswer(1, {1, 2, 3});
    } else {
      continue;
    }
    ws.write(boost::asio::buffer(protocol::encode(reply)));
  }
  return std::string(upgrade[http::field::authorization]);
}

TEST(Tls, CarriesAConversationAndTheToken) {
  for (const std::string host : {"127.0.0.1", "localhost"}) {
    std::string authorization;
    TlsServer server(identity(), [&](auto& ws) { authorization = serveOneCamera(ws); });
    {
      const Client client(server.address(host), trusting(certificateFile(), "s3cret"));
      ASSERT_NE(client.view, nullptr);
      const auto frame = client.view->cull({});
      ASSERT_TRUE(frame.ok()) << frame.error().message;
      EXPECT_EQ(frame.value()->visible, (Ids{1, 2, 3}));
    }
    server.join();
    EXPECT_EQ(authorization, "Bearer s3cret");
  }
}

TEST(Tls, RefusesAServerThatNobodyVouchesFor) {
  const Identity other("IP:127.0.0.1");
  TlsServer server(other, [](auto&) {});
  const auto connection = Connection::open(server.address(), "town", trusting(certificateFile()));
  ASSERT_FALSE(connection.ok());
  EXPECT_NE(connection.error().message.find("certificate verify failed"), std::string::npos)
      << connection.error().message;
  server.join();
  EXPECT_TRUE(server.handshake_failed);
}

TEST(Tls, TrustsOnlyTheSystemWithoutAFile) {
  TlsServer server(identity(), [](auto&) {});
  EXPECT_FALSE(Connection::open(server.address(), "town", quick()).ok());
}

TEST(Tls, RefusesACertificateOfAnotherHost) {
  const Identity other("DNS:elsewhere.example");
  const std::string path = ::testing::TempDir() + "culld_tls_test_other.pem";
  other.writeCertificate(path);
  for (const std::string host : {"127.0.0.1", "localhost"}) {
    TlsServer server(other, [](auto&) {});
    EXPECT_FALSE(Connection::open(server.address(host), "town", trusting(path)).ok());
    server.join();
    EXPECT_TRUE(server.handshake_failed);
  }
}

TEST(Tls, DoesNotWaitForeverForAHandshake) {
  boost::asio::io_context io;
  tcp::acceptor mute(io, tcp::endpoint(tcp::v4(), 0));  // the kernel accepts, nobody answers
  ConnectOptions options = trusting(certificateFile());
  options.timeouts.connect = 200ms;
  const auto start = std::chrono::steady_clock::now();
  const auto connection =
      Connection::open({"127.0.0.1", mute.local_endpoint().port(), {}, true}, "town", options);
  ASSERT_FALSE(connection.ok());
  EXPECT_EQ(connection.error().code, ErrorCode::kUnavailable);
  EXPECT_LT(std::chrono::steady_clock::now() - start, 2s);
}

TEST(Tls, NamesAFileThatHoldsNoCertificates) {
  const std::string path = ::testing::TempDir() + "culld_tls_test_empty.pem";
  std::ofstream(path) << "nothing";
  for (const std::string& file : {path, std::string("/nonexistent/ca.pem")}) {
    const auto connection = Connection::open({"127.0.0.1", 1, {}, true}, "town", trusting(file));
    ASSERT_FALSE(connection.ok());
    EXPECT_EQ(connection.error().code, ErrorCode::kInvalidInput);
    EXPECT_EQ(connection.error().message.rfind(file + ": no certificates", 0), 0U)
        << connection.error().message;
  }
}

TEST(Tls, ListsScenesWithTheToken) {
  std::string authorization;
  TlsServer server(identity(), [&](TlsServer::Stream& ws) {
    beast::flat_buffer in;
    http::request<http::string_body> request;
    http::read(ws.next_layer(), in, request);
    authorization = std::string(request[http::field::authorization]);
    http::response<http::string_body> reply(http::status::ok, 11, R"({"scenes":[]})");
    reply.prepare_payload();
    http::write(ws.next_layer(), reply);
  });
  const auto scenes = Scenes(server.address(), {"t0ken", certificateFile()}).list();
  server.join();
  ASSERT_TRUE(scenes.ok()) << scenes.error().message;
  EXPECT_TRUE(scenes.value().empty());
  EXPECT_EQ(authorization, "Bearer t0ken");
}

TEST(Token, ThatCannotBeALineOfAHeaderIsRefused) {
  for (const std::string token : {"a b", "a\r\nX: y", "\xc3\xa4"}) {
    ConnectOptions options = quick();
    options.access.token = token;
    const auto connection = Connection::open({"127.0.0.1", 1, {}}, "town", options);
    ASSERT_FALSE(connection.ok());
    EXPECT_EQ(connection.error().code, ErrorCode::kInvalidInput);
    EXPECT_EQ(connection.error().message.find(token), std::string::npos);  // never repeated
    EXPECT_FALSE(Scenes({"127.0.0.1", 1, {}}, options.access).list().ok());
  }
}

TEST(Token, IsAskedForByAServerThatWantsOne) {
  Script server([](Peer& peer) {
    peer.refuse(401, R"({"error":"a bearer token is needed"})");
    EXPECT_EQ(peer.upgrade()[http::field::authorization], "");
  });
  const auto connection = Connection::open(server.address(), "town", quick());
  ASSERT_FALSE(connection.ok());
  EXPECT_EQ(connection.error().code, ErrorCode::kForbidden);
  EXPECT_EQ(connection.error().message, toString(server.address()) + ": a bearer token is needed");
}

}  // namespace
}  // namespace culld::client
