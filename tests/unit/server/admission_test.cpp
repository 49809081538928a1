// Who gets in, and with what: every route with every kind of token, origins, hosts, tickets.
#include "server/admission.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include "tests/unit/server/access_fixture.h"

namespace culld::server {
namespace {

using namespace std::chrono_literals;
using Kind = Route::Kind;

class AdmissionTest : public ::testing::Test {
 protected:
  void openWithTokens() {
    options.tokens_file = files.write("tokens.toml", testing::usualTokens());
    open();
  }
  void open() {
    auto opened = Access::open(options);
    ASSERT_TRUE(opened.ok()) << opened.error().message;
    access = std::move(opened).value();
  }
  std::variant<Grant, HttpReply> ask(const std::string& method, const std::string& path,
                                     const std::string& token = "") {
    route = routeOf(path);
    authorization = "Bearer " + token;
    RequestFacts facts{method, route, peer, tls, host, {}, {}, subprotocols};
    if (!origin.empty()) facts.origin = origin;
    if (!token.empty()) facts.authorization = authorization;
    return admit(facts, {*access, metrics, now});
  }
  /// 200 stands for: let in.
  unsigned status(const std::string& method, const std::string& path,
                  const std::string& token = "") {
    const auto asked = ask(method, path, token);
    const auto* reply = std::get_if<HttpReply>(&asked);
    return reply == nullptr ? 200 : reply->status;
  }
  std::string header(const HttpReply& reply, const std::string& name) {
    for (const auto& [key, value] : reply.headers) {
      if (key == name) return value;
    }
    return "";
  }
  bool counted(const std::string& line) { return metrics.text().find(line) != std::string::npos; }

  testing::Files files;
  AccessOptions options;
  std::unique_ptr<Access> access;
  Metrics metrics;
  Time now{0};
  Route route;
  Peer peer;
  bool tls = false;
  std::string host = "127.0.0.1:7420";
  std::string origin;
  std::string authorization;
  std::string subprotocols;
};

TEST_F(AdmissionTest, AsksEachRouteForItsScope) {
  openWithTokens();
  struct Case {
    const char* method;
    const char* path;
    unsigned nobody, reader, editor, keeper, chief;
  };
  const Case cases[] = {
      {"GET", "/", 200, 200, 200, 200, 200},
      {"GET", "/livez", 200, 200, 200, 200, 200},
      {"GET", "/readyz", 200, 200, 200, 200, 200},
      {"GET", "/version", 200, 200, 200, 200, 200},
      {"GET", "/nowhere", 200, 200, 200, 200, 200},  // a 404 tells nothing
      {"GET", "/metrics", 401, 403, 403, 403, 200},
      {"GET", "/v1/status", 401, 200, 200, 200, 200},
      {"GET", "/v1/scenes", 401, 200, 200, 200, 200},
      {"GET", "/v1/scenes/a", 401, 200, 200, 200, 200},
      {"HEAD", "/v1/scenes/a", 401, 200, 200, 200, 200},
      {"PUT", "/v1/scenes/a", 401, 403, 403, 200, 200},
      {"DELETE", "/v1/scenes/a", 401, 403, 403, 200, 200},
      {"PATCH", "/v1/scenes/a", 401, 403, 403, 200, 200},
      {"GET", "/v1/scenes/a/objects", 401, 200, 200, 200, 200},
      {"GET", "/v1/scenes/a/live", 401, 200, 200, 200, 200},
      {"POST", "/v1/tickets", 401, 200, 200, 200, 200},
      {"POST", "/v1/scenes", 401, 200, 200, 200, 200},  // 405 comes later
  };
  for (const Case& c : cases) {
    const std::string what = std::string(c.method) + " " + c.path;
    EXPECT_EQ(status(c.method, c.path), c.nobody) << what;
    EXPECT_EQ(status(c.method, c.path, "reader"), c.reader) << what;
    EXPECT_EQ(status(c.method, c.path, "editor"), c.editor) << what;
    EXPECT_EQ(status(c.method, c.path, "keeper"), c.keeper) << what;
    EXPECT_EQ(status(c.method, c.path, "chief"), c.chief) << what;
    const unsigned wrong = c.nobody == 200 ? 200 : 401;
    EXPECT_EQ(status(c.method, c.path, "wrong"), wrong) << what;
  }
  EXPECT_TRUE(counted("culld_auth_failures_total{reason=\"missing\"} "));
  EXPECT_TRUE(counted("culld_auth_failures_total{reason=\"token\"} "));
  EXPECT_TRUE(counted("culld_auth_failures_total{reason=\"scope\"} "));
}

TEST_F(AdmissionTest, EveryRouteIsInTheTableAbove) {
  // A new kind of route must be given a scope, and a line above.
  EXPECT_EQ(static_cast<int>(Kind::kTickets), 11);
}

TEST_F(AdmissionTest, SaysHowToAskForATokenButNeverRepeatsOne) {
  openWithTokens();
  const auto missing = std::get<HttpReply>(ask("GET", "/v1/scenes"));
  EXPECT_EQ(header(missing, "WWW-Authenticate"), "Bearer realm=\"culld\"");
  const auto wrong = std::get<HttpReply>(ask("GET", "/v1/scenes", "my-secret"));
  EXPECT_NE(header(wrong, "WWW-Authenticate").find("invalid_token"), std::string::npos);
  EXPECT_EQ(wrong.body.find("my-secret"), std::string::npos);
}

TEST_F(AdmissionTest, TakesBearerTokensOnly) {
  openWithTokens();
  const auto with = [this](const std::string& text) {
    route = routeOf("/v1/scenes");
    const auto asked =
        admit({"GET", route, peer, tls, host, {}, text, ""}, {*access, metrics, now});
    return std::holds_alternative<Grant>(asked) ? 200 : std::get<HttpReply>(asked).status;
  };
  EXPECT_EQ(with("Bearer reader"), 200U);
  EXPECT_EQ(with("bearer  reader"), 200U);
  for (const char* wrong : {"", "Bearer", "Bearer ", "Bearer   ", "reader", "Basic reader",
                            "Bearer reader,", "Bearer reader reader"}) {
    EXPECT_EQ(with(wrong), 401U) << wrong;
  }
}

TEST_F(AdmissionTest, LetsEverybodyInWithoutTokens) {
  open();
  EXPECT_EQ(status("DELETE", "/v1/scenes/a"), 200U);
  EXPECT_EQ(status("GET", "/metrics", "any"), 200U);
}

TEST_F(AdmissionTest, TurnsPagesOfStrangersAway) {
  open();
  const std::pair<const char*, unsigned> cases[] = {
      {"http://127.0.0.1:7420", 200},   {"HTTP://127.0.0.1:7420", 200},
      {"http://127.0.0.1:7421", 403},   {"http://127.0.0.1", 403},
      {"https://evil.example", 403},    {"null", 403},
      {"127.0.0.1:7420", 403},          {"http://127.0.0.1:7420.evil.example", 403},
      {"http://x@127.0.0.1:7420", 403}, {"://", 403},
  };
  for (const auto& [text, expected] : cases) {
    origin = text;
    EXPECT_EQ(status("PUT", "/v1/scenes/a"), expected) << text;
    EXPECT_EQ(status("GET", "/v1/scenes/a/live"), expected) << text;
    EXPECT_EQ(status("GET", "/livez"), expected) << text;
  }
  EXPECT_TRUE(counted("culld_auth_failures_total{reason=\"origin\"} "));
  origin = "https://app.example";
  EXPECT_EQ(status("GET", "/v1/scenes"), 403U);
  options.origins = {"https://app.example"};
  open();
  EXPECT_EQ(status("GET", "/v1/scenes"), 200U);
  const auto preflight = std::get<HttpReply>(ask("OPTIONS", "/v1/tickets"));
  EXPECT_EQ(preflight.status, 204U);
  EXPECT_NE(header(preflight, "Access-Control-Allow-Headers").find("Authorization"),
            std::string::npos);
}

TEST_F(AdmissionTest, TurnsAwayNamesThatAStrangerMayHavePointedHere) {
  open();
  const std::pair<const char*, bool> cases[] = {
      {"127.0.0.1:7420", true},
      {"[::1]:7420", true},
      {"localhost:7420", true},
      {"culld", true},
      {"evil.example:7420", false},
      {"127.0.0.1.evil.example", false},
      {"", true},
      {"1.2.3.4.", true},
  };
  for (const auto& [name, fine] : cases) {
    host = name;
    EXPECT_EQ(status("GET", "/v1/scenes"), fine ? 200U : 403U) << name;
    origin = std::string("http://") + name;
    EXPECT_EQ(status("PUT", "/v1/scenes/a"), fine ? 200U : 403U) << name;
    origin = "";
    EXPECT_EQ(status("GET", "/livez"), 200U) << name;
  }
  host = "evil.example";
  tls = true;
  EXPECT_EQ(status("GET", "/v1/scenes"), 200U) << "no certificate speaks for it";
  tls = false;
  peer = {true, ::geteuid()};
  EXPECT_EQ(status("GET", "/v1/scenes"), 200U) << "no browser speaks there";
  peer = {};
  options.origins = {"http://evil.example"};
  open();
  EXPECT_EQ(status("GET", "/v1/scenes"), 200U) << "the operator named it";
  options.origins = {};
  openWithTokens();
  EXPECT_EQ(status("GET", "/v1/scenes"), 401U) << "a page of a stranger has no token";
  EXPECT_EQ(status("GET", "/v1/scenes", "reader"), 200U);
}

TEST_F(AdmissionTest, TakesTicketsAtTheLivePathOnce) {
  openWithTokens();
  const auto issue = [this] {
    return std::get<std::string>(*access->tickets().issue(*access->ofToken("editor"), now));
  };
  subprotocols = "culld.v1, culld.ticket." + issue();
  EXPECT_EQ(status("GET", "/v1/scenes/a"), 401U) << "nowhere else, and it is not used up there";
  const auto asked = ask("GET", "/v1/scenes/a/live");
  ASSERT_TRUE(std::holds_alternative<Grant>(asked));
  EXPECT_EQ(std::get<Grant>(asked).scope, Scope::kEdit);
  EXPECT_EQ(status("GET", "/v1/scenes/a/live"), 401U) << "it was used";
  subprotocols = "culld.ticket." + issue() + ",culld.v1";
  EXPECT_EQ(status("GET", "/v1/scenes/a/live"), 200U);
  subprotocols = " culld.v1 ,\tculld.ticket." + issue() + " ,";
  now += 31s;
  EXPECT_EQ(status("GET", "/v1/scenes/a/live"), 401U) << "it is stale";
  for (const char* none : {"culld.ticket.", "culld.ticket.x", ",,", "culld.v1,culld.ticket"}) {
    subprotocols = none;
    EXPECT_EQ(status("GET", "/v1/scenes/a/live"), 401U) << none;
  }
  EXPECT_TRUE(counted("culld_auth_failures_total{reason=\"ticket\"} "));
}

TEST_F(AdmissionTest, TellsATenantInDebtWhenToComeAgain) {
  openWithTokens();
  const auto acme = access->ofToken("reader")->tenant;
  acme->setQuotas({0, 1000, 0});
  acme->sent(3500, now);
  const auto refused = std::get<HttpReply>(ask("GET", "/v1/scenes", "reader"));
  EXPECT_EQ(refused.status, 429U);
  EXPECT_EQ(header(refused, "Retry-After"), "3");
  EXPECT_TRUE(counted("culld_quota_rejected_total{reason=\"bytes\"} 1"));
  EXPECT_EQ(status("GET", "/v1/scenes/a/live", "keeper"), 429U) << "they pay together";
  EXPECT_EQ(status("GET", "/v1/scenes", "other"), 200U) << "another tenant";
  EXPECT_EQ(status("GET", "/livez"), 200U);
  now += 3s;
  EXPECT_EQ(status("GET", "/v1/scenes", "reader"), 200U);
}

}  // namespace
}  // namespace culld::server
