// Log lines: one event a line whatever is in it, and never more of them than can be read.
#include "server/log.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>

namespace culld::server {
namespace {

class FakeClock final : public Clock {
 public:
  std::chrono::nanoseconds now() const noexcept override { return time; }
  std::chrono::nanoseconds time{0};
};

struct LogTest : ::testing::Test {
  std::vector<std::string> lines() {
    std::vector<std::string> found;
    std::istringstream text(out.str());
    for (std::string line; std::getline(text, line);) found.push_back(line);
    out.str("");
    return found;
  }
  /// The only line, without its time.
  std::string line() {
    const auto found = lines();
    EXPECT_EQ(found.size(), 1U);
    return found.empty() ? "" : found[0].substr(found[0].find(' ') + 1);
  }

  std::ostringstream out;
  FakeClock clock;
  Log log{out, clock};
};

TEST_F(LogTest, WritesTimeLevelMessageAndFields) {
  log.info("scene uploaded", {{"scene", "city"}, {"bytes", std::size_t{12}}, {"new", true}});
  const auto found = lines();
  ASSERT_EQ(found.size(), 1U);
  const std::regex wanted(R"(\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}Z info scene uploaded )"
                          R"(scene=city bytes=12 new=true)");
  EXPECT_TRUE(std::regex_match(found[0], wanted)) << found[0];
}

TEST_F(LogTest, QuotesWhatIsNotOneWord) {
  log.info("x", {{"a", ""}, {"b", "two words"}, {"c", "q\"\\"}, {"d", "k=v"}, {"e", "ü"}});
  EXPECT_EQ(line(), "info x a=\"\" b=\"two words\" c=\"q\\\"\\\\\" d=\"k=v\" e=\"ü\"");
}

TEST_F(LogTest, KeepsAnEventOnItsLineWhateverIsInIt) {
  log.info("msg\nfake", {{"name", "a\n2026-01-01T00:00:00Z error fake\r\x1b[31m"}});
  EXPECT_EQ(line(), "info msg\\nfake name=\"a\\n2026-01-01T00:00:00Z error fake\\r\\x1b[31m\"");
  log.set({LogFormat::kJson, LogLevel::kInfo});
  log.info("msg\n\"", {{"name", "a\n\xff\""}});
  const auto found = lines();
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(nlohmann::json::parse(found[0])["msg"], "msg\n\"");
  EXPECT_EQ(nlohmann::json::parse(found[0])["name"], "a\n\xef\xbf\xbd\"");
}

TEST_F(LogTest, WritesJson) {
  log.set({LogFormat::kJson, LogLevel::kInfo});
  log.warning("refused", {{"status", 404U}, {"seconds", 0.5}, {"ok", false}, {"path", "/x"}});
  const auto found = lines();
  ASSERT_EQ(found.size(), 1U);
  const auto json = nlohmann::json::parse(found[0]);
  EXPECT_TRUE(std::regex_match(json["time"].get<std::string>(),
                               std::regex(R"(\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{6}Z)")));
  EXPECT_EQ(json["level"], "warning");
  EXPECT_EQ(json["msg"], "refused");
  EXPECT_EQ(json["status"], 404);
  EXPECT_EQ(json["seconds"], 0.5);
  EXPECT_EQ(json["ok"], false);
  EXPECT_EQ(json["path"], "/x");
}

TEST_F(LogTest, LeavesOutWhatIsBelowItsLevel) {
  const auto say_all = [this] {
    log.debug("d");
    log.info("i");
    log.warning("w");
    log.error("e");
    return lines().size();
  };
  EXPECT_EQ(say_all(), 3U);
  log.set({LogFormat::kText, LogLevel::kDebug});
  EXPECT_EQ(say_all(), 4U);
  log.set({LogFormat::kText, LogLevel::kError});
  EXPECT_EQ(say_all(), 1U);
}

TEST_F(LogTest, BeginsWithThePriorityForSystemd) {
  for (const auto format : {LogFormat::kText, LogFormat::kJson}) {
    Log journal(out, clock, true);
    journal.set({format, LogLevel::kDebug});
    journal.debug("d");
    journal.info("i");
    journal.warning("w");
    journal.error("e");
    std::string priorities;
    for (const std::string& line : lines()) priorities += line.substr(0, 3);
    EXPECT_EQ(priorities, "<7><6><4><3>");
  }
}

TEST_F(LogTest, LimitsLinesThatRepeatAndCountsThem) {
  for (int i = 0; i < 150; ++i) log.info("again", {{"i", i}});
  EXPECT_EQ(lines().size(), 100U);
  log.info("another");
  EXPECT_EQ(line(), "info another");
  clock.time += std::chrono::milliseconds(250);
  for (int i = 0; i < 10; ++i) log.info("again");
  const auto found = lines();
  ASSERT_EQ(found.size(), 2U);
  EXPECT_NE(found[0].find("again left_out=50"), std::string::npos) << found[0];
  EXPECT_EQ(found[1].find("left_out"), std::string::npos) << found[1];
  clock.time += std::chrono::hours(1);
  for (int i = 0; i < 150; ++i) log.info("again");
  EXPECT_EQ(lines().size(), 100U);
}

TEST_F(LogTest, KeepsCountOfFewMessagesOnly) {
  for (int i = 0; i < 1000; ++i) log.info("message " + std::to_string(i));
  EXPECT_EQ(lines().size(), 1000U);
}

TEST(SilentLog, WritesNothing) {
  Log log;
  log.set({LogFormat::kJson, LogLevel::kDebug});
  log.error("unheard", {{"a", 1}});
}

}  // namespace
}  // namespace culld::server
