// What a request through culld costs beyond the cull itself, against the least that the same
// library can do: a bare WebSocket echo. One client, one request in flight, both servers in turn so
// that the machine's other work meets both alike.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <cstdio>
#include <exception>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "protocol/codec.h"
#include "server/server.h"
#include "tests/integration/raw_client.h"
#include "tests/scenes/model.h"

namespace culld {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
using asio::ip::tcp;
using testing::LiveClient;
using testing::RawSocket;
using Steady = std::chrono::steady_clock;

/// Sends every message of one connection back.
class Echo {
 public:
  Echo() : acceptor_(io_, {asio::ip::address_v4::loopback(), 0}), socket_(io_) {
    acceptor_.async_accept(beast::get_lowest_layer(socket_).socket(), [this](beast::error_code e) {
      if (e) return;
      beast::get_lowest_layer(socket_).socket().set_option(tcp::no_delay(true));
      socket_.binary(true);
      socket_.async_accept([this](beast::error_code failure) {
        if (!failure) read();
      });
    });
    thread_ = std::thread([this] { io_.run(); });
  }
  ~Echo() {
    io_.stop();
    thread_.join();
  }
  std::uint16_t port() const { return acceptor_.local_endpoint().port(); }

 private:
  void read() {
    socket_.async_read(buffer_, [this](beast::error_code e, std::size_t) {
      if (!e) write();
    });
  }
  void write() {
    socket_.async_write(buffer_.data(), [this](beast::error_code e, std::size_t) {
      buffer_.consume(buffer_.size());
      if (!e) read();
    });
  }

  asio::io_context io_{1};
  tcp::acceptor acceptor_;
  beast::websocket::stream<beast::tcp_stream> socket_;
  beast::flat_buffer buffer_;
  std::thread thread_;
};

struct Series {
  std::vector<double> us;
  double at(double share) {
    std::sort(us.begin(), us.end());
    const auto last = static_cast<double>(us.size() - 1);
    return us[static_cast<std::size_t>(share * last)];
  }
};

/// A few triangles in view, so that the answer is small and the cull as short as can be.
std::string writeScene(std::uint32_t objects) {
  scenes::Model model;
  model.addMaterial({});
  const auto mesh = model.addMesh({"t", {{{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {0, 1, 2}}, 0}}});
  for (std::uint32_t i = 0; i < objects; ++i) {
    model.addNode({scenes::kNone, mesh, scenes::movedBy({2.0 * i, 0, 0}), ""});
  }
  const auto bytes = scenes::toGlb(model);
  std::string path = "/tmp/bench_roundtrip_" + std::to_string(::getpid()) + ".glb";
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
  return path;
}

protocol::CameraUpdate cameraAt(double x, std::uint32_t ack) {
  protocol::LookAt look;
  look.eye = {x, 0, 10};
  look.target = {x, 0, 0};
  protocol::CameraUpdate update;
  update.view = 1;
  update.camera.pose = look;
  update.ack_frame = ack;
  return update;
}

double microseconds(Steady::duration d) {
  return std::chrono::duration<double, std::micro>(d).count();
}

class Bench {
 public:
  Bench(LiveClient& culld, LiveClient& echo) : culld_(culld), echo_(echo) {}

  bool askCulld(std::uint32_t i) {
    const auto request = protocol::encode({i, cameraAt(i % 100, frame_)});
    const std::string bytes(request.begin(), request.end());
    const auto start = Steady::now();
    if (!culld_.sendFrame(2, bytes)) return false;
    const auto reply = culld_.receiveFrame();
    const auto end = Steady::now();
    if (!reply) return false;
    const std::vector<std::uint8_t> data(reply->payload.begin(), reply->payload.end());
    const auto message = protocol::decode(data, protocol::kMaxReplyBytes);
    const auto* answer =
        message.ok() ? std::get_if<protocol::Answer>(&message.value().body) : nullptr;
    if (answer == nullptr) return false;
    frame_ = answer->frame;
    culld_us.us.push_back(microseconds(end - start));
    cull_us.us.push_back(static_cast<double>(answer->stats.cull_ns) * 1e-3);
    reply_bytes.us.push_back(static_cast<double>(data.size()));
    return true;
  }

  bool askEcho(std::uint32_t i) {
    const auto request = protocol::encode({i, cameraAt(i % 100, frame_)});
    const std::string bytes(request.begin(), request.end());
    const auto start = Steady::now();
    if (!echo_.sendFrame(2, bytes) || !echo_.receiveFrame()) return false;
    echo_us.us.push_back(microseconds(Steady::now() - start));
    return true;
  }

  Series culld_us, cull_us, echo_us, reply_bytes;

 private:
  LiveClient& culld_;
  LiveClient& echo_;
  std::uint32_t frame_ = 0;
};

void report(Bench& bench, bool json) {
  const double ratio = (bench.culld_us.at(0.5) - bench.cull_us.at(0.5)) / bench.echo_us.at(0.5);
  const nlohmann::ordered_json out = {
      {"requests", bench.culld_us.us.size()},         {"culld_p50_us", bench.culld_us.at(0.5)},
      {"culld_p99_us", bench.culld_us.at(0.99)},      {"echo_p50_us", bench.echo_us.at(0.5)},
      {"echo_p99_us", bench.echo_us.at(0.99)},        {"cull_p50_us", bench.cull_us.at(0.5)},
      {"reply_bytes_p50", bench.reply_bytes.at(0.5)}, {"p50_without_cull_over_echo", ratio}};
  if (json) {
    std::printf("%s\n", out.dump().c_str());
    return;
  }
  for (const auto& [key, value] : out.items()) {
    std::printf("%-28s %.2f\n", key.c_str(), value.get<double>());
  }
}

int run(std::uint32_t objects, std::uint32_t rounds, bool json) {
  const std::string path = writeScene(objects);
  server::ServerOptions options;
  options.listen_port = 0;
  options.methods = allMethods();
  options.scene_files = {{"bench", path}};
  options.limits.session.max_messages_per_s = 0;  // one client asks as fast as it is answered
  auto server = server::Server::start(options);
  const bool loaded = server.ok() && server.value()->loadScenes().ok();
  std::remove(path.c_str());
  if (!loaded) {
    std::fprintf(stderr, "bench_roundtrip: cannot serve\n");
    return 1;
  }
  Echo echo;
  LiveClient to_culld(RawSocket::tcp(server.value()->port()), "bench");
  LiveClient to_echo(RawSocket::tcp(echo.port()), "bench");
  if (!to_culld.hello() || !to_culld.openView(1) || to_echo.upgradeStatus() != 101) return 1;
  Bench warm_up(to_culld, to_echo);
  Bench bench(to_culld, to_echo);
  constexpr std::uint32_t kBatch = 100;
  for (std::uint32_t i = 0; i < (rounds + 5) * kBatch; ++i) {
    Bench& now = i < 5 * kBatch ? warm_up : bench;
    const bool culld_turn = (i / kBatch) % 2 == 0;
    if (!(culld_turn ? now.askCulld(i) : now.askEcho(i))) {
      std::fprintf(stderr, "bench_roundtrip: no reply\n");
      return 1;
    }
  }
  report(bench, json);
  return 0;
}

}  // namespace
}  // namespace culld

int main(int argc, char** argv) try {
  CLI::App app("Round trip of a small answer through culld against a bare WebSocket echo");
  std::uint32_t objects = 200;
  std::uint32_t rounds = 200;
  bool json = false;
  app.add_option("--objects", objects)->capture_default_str();
  app.add_option("--rounds", rounds, "Batches of 100 requests, half of them echoes")
      ->capture_default_str()
      ->check(CLI::Range(2U, 1'000'000U));
  app.add_flag("--json", json);
  CLI11_PARSE(app, argc, argv);
  return culld::run(objects, rounds, json);
} catch (const std::exception& failure) {
  std::fprintf(stderr, "bench_roundtrip: %s\n", failure.what());
  return 2;
}
