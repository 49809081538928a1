// Anything at all on the daemon's socket: requests, uploads, upgrades and frames, in pieces. The
// connection must end once the client's half has, what comes back must be HTTP, and the daemon must
// go on.
#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>

#include "server/server.h"
#include "tests/integration/raw_client.h"
#include "tests/unit/server/fake_method.h"

namespace {

using namespace culld;
using testing::RawSocket;

void require(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "fuzz_http: %s\n", what);
  std::abort();
}

/// One daemon for all inputs, as in life.
class Daemon {
 public:
  Daemon()
      : folder_(std::filesystem::temp_directory_path() /
                ("fuzz_http." + std::to_string(::getpid()))) {
    std::filesystem::create_directories(folder_);
    server::ServerOptions options;
    options.listen_port = 0;
    options.unix_path = path();
    options.data_folder = (folder_ / "data").string();
    options.threads = 1;
    options.methods = table_;
    options.limits.max_scenes = 8;
    options.limits.max_upload_bytes = 100'000;
    auto started = server::Server::start(std::move(options));
    require(started.ok(), "no daemon");
    server_ = std::move(started).value();
    require(server_->loadScenes().ok(), "no scenes");
    const std::string scene = R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{}]})";
    RawSocket socket = RawSocket::unixDomain(path());
    socket.send(putHeader("held", scene.size()) + scene);
    require(testing::readAnswer(socket).status == 201, "the first upload failed");
  }
  ~Daemon() {
    server_.reset();
    std::error_code ignored;  // a temporary folder that stays harms nobody
    std::filesystem::remove_all(folder_, ignored);
  }

  std::string path() const { return (folder_ / "socket").string(); }

  static std::string putHeader(const std::string& scene, std::size_t bytes) {
    return "PUT /v1/scenes/" + scene +
           " HTTP/1.1\r\nHost: x\r\nContent-Length: " + std::to_string(bytes) + "\r\n\r\n";
  }

 private:
  const std::filesystem::path folder_;
  server::FakeMethod fake_;
  const Method* table_[1] = {&fake_};
  std::unique_ptr<server::Server> server_;
};

/// The first byte chooses what stands before the rest, so that the fuzzer need not find it.
std::string opening(std::uint8_t choice, std::size_t rest) {
  switch (choice % 4) {
    case 1:
      return "GET /v1/scenes/held/live HTTP/1.1\r\nHost: x\r\nUpgrade: websocket\r\n"
             "Connection: Upgrade\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
             "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Protocol: culld.v1\r\n\r\n";
    case 2:
      return Daemon::putHeader("up", rest);
    case 3:
      return "PUT /v1/scenes/up HTTP/1.1\r\nHost: x\r\nTransfer-Encoding: chunked\r\n\r\n";
    default:
      return {};
  }
}

void livesOn(const Daemon& daemon) {
  RawSocket socket = RawSocket::unixDomain(daemon.path());
  socket.send("GET /livez HTTP/1.1\r\nHost: x\r\n\r\n");
  require(testing::readAnswer(socket).status == 200, "the daemon does not answer any more");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const Daemon daemon;
  static std::uint64_t inputs = 0;
  if (size < 2) return 0;
  const std::size_t piece = data[1] == 0 ? size : data[1];
  std::string bytes = opening(data[0], size - 2);
  bytes.append(reinterpret_cast<const char*>(data) + 2, size - 2);
  RawSocket socket = RawSocket::unixDomain(daemon.path());
  require(socket.connected(), "the daemon does not accept any more");
  for (std::size_t at = 0; at < bytes.size(); at += piece) {
    if (!socket.send(std::string_view(bytes).substr(at, piece))) break;  // refused half-way
  }
  socket.shutdownWrite();
  const auto reply = socket.readToEnd();
  require(reply.has_value(), "the connection does not end");
  require(reply->empty() || reply->starts_with("HTTP/1.1 "), "what came back is not HTTP");
  if (++inputs % 256 == 0) livesOn(daemon);
  return 0;
}
