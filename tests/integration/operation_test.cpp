// A server as its operator sees it: limits replaced while it runs, proof of life, its own state
// told.
#include <gtest/gtest.h>

#include <future>

#include "tests/integration/server_fixture.h"

namespace culld::testing {
namespace {

using Operation = ServerTest;

TEST_F(Operation, LimitsThatAreReplacedHoldForWhoComesNext) {
  start();
  server::ServerLimits limits = options.limits;
  limits.max_connections = 2;
  server->setLimits(limits);
  const RawSocket one = socket();
  const RawSocket two = socket();
  RawSocket three = socket();
  EXPECT_TRUE(three.readUntil(" 503 "));
  limits.max_connections = 20;
  server->setLimits(limits);
  EXPECT_EQ(request(port(), "GET", "/livez").status, 200);
}

TEST_F(Operation, AServerWhoseThreadHangsIsNotAlive) {
  start();
  std::promise<void> release;
  std::promise<void> alive;
  server->whenAlive([hang = release.get_future().share()] { hang.wait(); });
  server->whenAlive([&alive] { alive.set_value(); });
  auto proof = alive.get_future();
  EXPECT_EQ(proof.wait_for(std::chrono::milliseconds(200)), std::future_status::timeout);
  release.set_value();
  EXPECT_EQ(proof.wait_for(std::chrono::seconds(10)), std::future_status::ready);
}

TEST_F(Operation, SaysWhetherItsConfigurationWasTaken) {
  start();
  const auto says = [this](const std::string& line) {
    return ("\n" + request(port(), "GET", "/metrics").body).find("\n" + line + "\n") !=
           std::string::npos;
  };
  EXPECT_TRUE(says("culld_config_last_reload_successful 1"));
  server->configRead(false);
  EXPECT_TRUE(says("culld_config_last_reload_successful 0"));
  server->configRead(true);
  EXPECT_TRUE(says("culld_config_last_reload_successful 1"));
}

TEST_F(Operation, TimesHowLongCamerasWait) {
  startWithRow();
  LiveClient client(socket(), "row");
  ASSERT_TRUE(client.hello().has_value());
  ASSERT_TRUE(client.openView(1));
  client.send(cameraAt(0));
  ASSERT_TRUE(client.await<protocol::Answer>());
  const std::string text = request(port(), "GET", "/metrics").body;
  EXPECT_NE(text.find("\nculld_queue_duration_seconds_count 1\n"), std::string::npos) << text;
  EXPECT_NE(text.find("\nculld_build_info{compiler=\""), std::string::npos) << text;
}

}  // namespace
}  // namespace culld::testing
