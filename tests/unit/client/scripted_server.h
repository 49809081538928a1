// A server that does what a test says, for clients to meet what a real one does only on a bad day.
#pragma once
#include <gtest/gtest.h>

#include <atomic>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "culld/connection.h"
#include "protocol/codec.h"
#include "protocol/id_set.h"
#include "protocol/limits.h"
#include "protocol/version.h"

namespace culld::client {

namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using boost::asio::ip::tcp;
using namespace std::chrono_literals;
using Ids = std::vector<std::uint32_t>;
using protocol::Answer;
using protocol::CameraUpdate;
using protocol::Message;

/// One client's other end, blocking. Every wrong turn of the client is a test failure.
class Peer {
 public:
  explicit Peer(tcp::socket socket) : ws_(std::move(socket)) {}

  void accept() {
    beast::flat_buffer in;
    http::read(ws_.next_layer(), in, upgrade_);
    ws_.set_option(websocket::stream_base::decorator([](websocket::response_type& reply) {
      reply.set(http::field::sec_websocket_protocol, protocol::kSubprotocol);
    }));
    ws_.accept(upgrade_);
    ws_.binary(true);
  }
  const http::request<http::string_body>& upgrade() const { return upgrade_; }
  /// Answers the upgrade with something else.
  void refuse(unsigned status, const std::string& body) {
    beast::flat_buffer in;
    http::read(ws_.next_layer(), in, upgrade_);
    http::response<http::string_body> reply(http::int_to_status(status), 11, body);
    reply.prepare_payload();
    http::write(ws_.next_layer(), reply);
  }
  void greet(std::uint64_t version = 1) {
    accept();
    const Message hello = next();
    EXPECT_TRUE(std::holds_alternative<protocol::Hello>(hello.body));
    protocol::Welcome welcome;
    welcome.protocol = protocol::kProtocolMax;
    welcome.scene = {"town", version, 6 + version, 1000, 5000};
    send({hello.id, welcome});
  }
  protocol::OpenView openView() {
    const Message open = next();
    const auto* view = std::get_if<protocol::OpenView>(&open.body);
    EXPECT_NE(view, nullptr);
    if (view == nullptr) return {};
    send({open.id, protocol::ViewOpened{view->view, "raster", Guarantee::kConservative}});
    return *view;
  }
  Message next() {
    beast::flat_buffer in;
    ws_.read(in);
    const auto bytes = in.cdata();
    auto message = protocol::decode({static_cast<const std::uint8_t*>(bytes.data()), bytes.size()},
                                    protocol::kMaxRequestBytes);
    EXPECT_TRUE(message.ok());
    return message ? message.value() : Message{};
  }
  std::pair<std::uint64_t, CameraUpdate> nextCamera() {
    const Message message = next();
    const auto* update = std::get_if<CameraUpdate>(&message.body);
    EXPECT_NE(update, nullptr);
    return {message.id, update != nullptr ? *update : CameraUpdate{}};
  }
  void send(const Message& message) { sendBytes(protocol::encode(message)); }
  void sendBytes(const std::vector<std::uint8_t>& bytes) { ws_.write(boost::asio::buffer(bytes)); }
  /// As a server that is killed.
  void cut() { ws_.next_layer().close(); }
  void awaitEnd() {
    beast::flat_buffer in;
    beast::error_code ec;
    while (!ec && ws_.is_open()) ws_.read(in, ec);
  }

 private:
  websocket::stream<tcp::socket> ws_;
  http::request<http::string_body> upgrade_;
};

/// A server on a thread of its own that takes one connection after the other; the test says what it
/// does with each.
class Script {
 public:
  using Play = std::function<void(Peer&)>;

  explicit Script(Play play) : Script(std::vector<Play>{std::move(play)}) {}
  explicit Script(std::vector<Play> plays)
      : thread_([this, plays = std::move(plays)] {
          for (const Play& play : plays) {
            try {
              Peer peer(acceptor_.accept());
              if (ending_) return;
              play(peer);
            } catch (const std::exception& e) {
              ADD_FAILURE() << "scripted server: " << e.what();
            }
          }
        }) {}
  ~Script() {
    ending_ = true;
    tcp::socket knock(io_);  // for a server that still waits for a client
    beast::error_code ignored;
    knock.connect(acceptor_.local_endpoint(), ignored);
    thread_.join();
  }
  Address address() const { return {"127.0.0.1", acceptor_.local_endpoint().port(), {}}; }

 private:
  boost::asio::io_context io_;
  tcp::acceptor acceptor_{io_, tcp::endpoint(tcp::v4(), 0)};
  std::atomic<bool> ending_ = false;
  std::thread thread_;
};

inline Answer wholeAnswer(std::uint32_t frame, const Ids& ids) {
  Answer answer;
  answer.view = 1;
  answer.frame = frame;
  answer.scene_version = 1;
  answer.scene_objects = 1000;
  const auto set = protocol::encodeSmallest(ids);
  answer.encoding = set.encoding;
  answer.payload = set.payload;
  answer.object_count = static_cast<std::uint32_t>(ids.size());
  answer.set_hash = protocol::setHash(ids);
  answer.method = "raster";
  return answer;
}

inline Answer changedAnswer(std::uint32_t frame, const Ids& ids, std::uint32_t baseline,
                            const Ids& from) {
  Answer answer = wholeAnswer(frame, ids);
  const auto set = protocol::encodeAddRemove(from, ids);
  answer.baseline = baseline;
  answer.encoding = set.encoding;
  answer.payload = set.payload;
  return answer;
}

/// Short waits, one connection.
inline ConnectOptions quick() {
  ConnectOptions options;
  options.timeouts = {2000ms, 2000ms, 10'000ms};
  options.reconnect.enabled = false;
  return options;
}

/// Calls back until it is gone: what a callback refers to is declared before it.
struct Client {
  explicit Client(const Address& address, const ConnectOptions& options = quick()) {
    auto opened = Connection::open(address, "town", options);
    EXPECT_TRUE(opened.ok()) << opened.error().message;
    if (!opened) return;
    connection = std::move(opened).value();
    auto made = connection->openView();
    EXPECT_TRUE(made.ok()) << made.error().message;
    if (made) view = std::make_unique<View>(made.value());
  }
  std::unique_ptr<Connection> connection;
  std::unique_ptr<View> view;
};

}  // namespace culld::client
