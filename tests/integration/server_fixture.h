// A server in this process on a free port, with a method whose answers are foretold.
#pragma once
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>

#include "server/server.h"
#include "tests/integration/raw_client.h"
#include "tests/scenes/row_glb.h"
#include "tests/unit/server/fake_method.h"

namespace culld::testing {

class ServerTest : public ::testing::Test {
 protected:
  ServerTest() {
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder);
  }
  ~ServerTest() override {
    server.reset();
    std::filesystem::remove_all(folder);
  }

  void start() {
    options.listen_port = 0;
    options.methods = table;
    options.data_folder = (folder / "data").string();
    options.threads = 2;
    auto started = server::Server::start(options);
    ASSERT_TRUE(started.ok()) << started.error().message;
    server = std::move(started).value();
    const auto failures = server->loadScenes();
    ASSERT_TRUE(failures.ok()) << failures.error().message;
    EXPECT_TRUE(failures.value().empty());
  }
  void startWithRow(std::uint32_t objects = 300) {
    start();
    EXPECT_EQ(request(port(), "PUT", "/v1/scenes/row", rowGlb(objects)).status, 201);
  }
  std::uint16_t port() const { return server->port(); }
  RawSocket socket() const { return RawSocket::tcp(port()); }

  /// Connections that the daemon holds, this question's own not counted.
  double heldConnections() const {
    const std::string text = request(port(), "GET", "/metrics").body;
    const auto at = text.find("\nculld_connections ");
    return at == std::string::npos ? 1e9 : std::stod(text.substr(at + 19)) - 1.0;
  }

  bool awaitNoConnections(std::chrono::seconds limit) const {
    const auto until = std::chrono::steady_clock::now() + limit;
    while (heldConnections() > 0) {
      if (std::chrono::steady_clock::now() > until) return false;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return true;
  }

  /// Triangles in a row, one per node.
  static std::string rowGlb(std::uint32_t objects) {
    const auto bytes = scenes::rowGlb(objects);
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  }
  static protocol::CameraUpdate cameraAt(double x, std::uint32_t ack = 0, std::uint32_t view = 1) {
    protocol::LookAt look;
    look.eye = {x, 0, 5};
    look.target = {x, 0, 0};
    protocol::CameraUpdate update;
    update.view = view;
    update.camera.pose = look;
    update.ack_frame = ack;
    return update;
  }

  const std::filesystem::path folder =
      std::filesystem::path(::testing::TempDir()) / ("culld_" + std::to_string(::getpid()));
  server::FakeMethod fake;
  const Method* table[1] = {&fake};
  server::ServerOptions options;
  std::unique_ptr<server::Server> server;
};

}  // namespace culld::testing
