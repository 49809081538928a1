// What a server at work writes into its log: a line per event, and nothing that lets anyone in.
#include <gtest/gtest.h>

#include <regex>
#include <sstream>
#include <thread>

#include "tests/integration/server_fixture.h"

namespace culld::testing {
namespace {

namespace wire = protocol;

class LogLines : public ServerTest {
 protected:
  LogLines() { options.log = &log; }
  LiveClient connect() {
    LiveClient client(socket(), "row");
    EXPECT_TRUE(client.hello().has_value());
    EXPECT_TRUE(client.openView(1));
    return client;
  }
  /// All that was written; the server is gone after that.
  std::vector<std::string> lines() {
    server->drain();
    server.reset();
    std::vector<std::string> found;
    std::istringstream text(out.str());
    for (std::string line; std::getline(text, line);) {
      found.push_back(line.substr(line.find(' ') + 1));  // without the time
    }
    return found;
  }
  static std::size_t count(const std::vector<std::string>& lines, const std::string& pattern) {
    const std::regex wanted(pattern);
    return static_cast<std::size_t>(
        std::count_if(lines.begin(), lines.end(),
                      [&](const std::string& line) { return std::regex_match(line, wanted); }));
  }
  static std::string all(const std::vector<std::string>& lines) {
    std::string text;
    for (const std::string& line : lines) text += line + "\n";
    return text;
  }

  std::ostringstream out;
  server::Log log{out, steadyClock()};
  const std::string peer = R"(peer=127\.0\.0\.1:\d+)";
};

TEST_F(LogLines, ASession) {
  startWithRow();
  {
    LiveClient client = connect();
    client.send(cameraAt(0));
    ASSERT_TRUE(client.await<wire::Answer>());
    client.send(cameraAt(0, 0, 9));  // a view that is not open
    ASSERT_TRUE(client.await<wire::ErrorReply>());
    for (std::uint32_t i = 0; i < 3; ++i) {
      client.send(wire::Edit{0, {{wire::EditKind::kHide, i, {}}}});
      ASSERT_TRUE(client.await<wire::Edited>());
    }
  }
  const auto found = lines();
  const std::string who = "session=1 scene=row " + peer;
  EXPECT_EQ(count(found, "info session opened " + who), 1U) << all(found);
  EXPECT_EQ(count(found, "info message refused " + who + " code=unknown-view"), 1U) << all(found);
  EXPECT_EQ(count(found, "info scene edited " + who + " edits=3"), 1U) << all(found);
  EXPECT_EQ(count(found, "info session closed " + who +
                             " why=.* seconds=.* answers=1 answer_bytes=\\d+ "
                             "received_bytes=\\d+ edits=3 refusals=1"),
            1U)
      << all(found);
}

TEST_F(LogLines, EditsThatAreASecondApartAreTwoBursts) {
  startWithRow();
  {
    LiveClient client = connect();
    for (std::uint32_t i = 0; i < 2; ++i) {
      if (i > 0) std::this_thread::sleep_for(std::chrono::milliseconds(1500));
      client.send(wire::Edit{0, {{wire::EditKind::kHide, i, {}}}});
      ASSERT_TRUE(client.await<wire::Edited>());
    }
  }
  const auto found = lines();
  EXPECT_EQ(count(found, "info scene edited session=1 scene=row " + peer + " edits=1"), 2U)
      << all(found);
}

TEST_F(LogLines, UploadsRemovalsAndRefusals) {
  startWithRow();
  EXPECT_EQ(request(port(), "PUT", "/v1/scenes/row", rowGlb(5)).status, 200);
  EXPECT_EQ(request(port(), "PUT", "/v1/scenes/bad", "no scene").status, 422);
  EXPECT_EQ(request(port(), "GET", "/nowhere?secret\"\n").status, 400);
  EXPECT_EQ(request(port(), "GET", "/nowhere?ticket=secret").status, 404);
  EXPECT_EQ(request(port(), "DELETE", "/v1/scenes/row").status, 204);
  EXPECT_EQ(request(port(), "GET", "/livez").status, 200);
  const auto found = lines();
  EXPECT_EQ(count(found, "info scene uploaded scene=row " + peer + " bytes=\\d+ replaced=false"),
            1U)
      << all(found);
  EXPECT_EQ(count(found, "info scene uploaded scene=row " + peer + " bytes=\\d+ replaced=true"), 1U)
      << all(found);
  EXPECT_EQ(count(found, "info request refused method=PUT path=/v1/scenes/bad status=422 " + peer +
                             " error=\".*\""),
            1U)
      << all(found);
  EXPECT_EQ(count(found, "info request refused method=GET path=/nowhere status=404 " + peer +
                             " error=\".*\""),
            1U)
      << all(found);
  EXPECT_EQ(count(found, "info scene removed scene=row " + peer), 1U) << all(found);
  EXPECT_EQ(all(found).find("secret"), std::string::npos) << all(found);
  EXPECT_EQ(all(found).find("/livez"), std::string::npos) << "only at the level debug";
}

TEST_F(LogLines, ConnectionsThatAreTooMany) {
  options.limits.max_connections = 1;
  start();
  const RawSocket held = socket();
  for (int i = 0; i < 3; ++i) {
    RawSocket refused = socket();
    EXPECT_TRUE(refused.readUntil(" 503 "));
  }
  const auto found = lines();
  EXPECT_EQ(count(found, "warning connection refused why=\"too many connections.*\" limit=1"), 3U)
      << all(found);
}

}  // namespace
}  // namespace culld::testing
