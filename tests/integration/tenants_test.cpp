// Tokens, tenants and quotas over real sockets, in a server of this process.
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "tests/integration/server_fixture.h"
#include "tests/unit/server/access_fixture.h"

namespace culld::testing {
namespace {

using nlohmann::json;

class Tenants : public ServerTest {
 protected:
  void startWithTokens(const std::string& quotas = "") {
    options.access.tokens_file = files.write("tokens.toml", usualTokens() + quotas);
    start();
  }
  HttpAnswer ask(const std::string& token, const std::string& method, const std::string& path,
                 const std::string& body = "") {
    RawSocket s = socket();
    std::string head = method + " " + path + " HTTP/1.1\r\nHost: localhost\r\n";
    if (!token.empty()) head += "Authorization: Bearer " + token + "\r\n";
    if (method == "PUT") head += "Content-Length: " + std::to_string(body.size()) + "\r\n";
    s.send(head + "Connection: close\r\n\r\n" + body);
    return readAnswer(s);
  }
  /// As a browser comes in: the token buys a ticket, the ticket opens the socket.
  LiveClient live(const std::string& token, const std::string& scene) {
    const auto bought = ask(token, "POST", "/v1/tickets");
    EXPECT_EQ(bought.status, 201);
    const auto ticket = json::parse(bought.body)["ticket"].get<std::string>();
    LiveClient client(socket(), scene, "culld.v1, culld.ticket." + ticket);
    EXPECT_EQ(client.upgradeStatus(), 101);
    EXPECT_TRUE(client.hello());
    EXPECT_TRUE(client.openView(1));
    return client;
  }
  std::string metrics() { return ask("chief", "GET", "/metrics").body; }

  Files files;
};

TEST_F(Tenants, AreAskedForTokens) {
  startWithTokens();
  EXPECT_EQ(ask("", "GET", "/livez").status, 200);
  EXPECT_EQ(ask("", "GET", "/v1/scenes").status, 401);
  EXPECT_EQ(ask("wrong", "GET", "/v1/scenes").status, 401);
  EXPECT_EQ(ask("reader", "GET", "/v1/scenes").status, 200);
  EXPECT_EQ(ask("editor", "PUT", "/v1/scenes/a", rowGlb(3)).status, 403);
  EXPECT_EQ(ask("", "PUT", "/v1/scenes/a", rowGlb(3)).status, 401);
  EXPECT_EQ(ask("keeper", "PUT", "/v1/scenes/a", rowGlb(3)).status, 201);
  EXPECT_EQ(LiveClient(socket(), "a").upgradeStatus(), 401);
  EXPECT_NE(metrics().find("culld_auth_failures_total{reason=\"missing\"} 3"), std::string::npos)
      << metrics();
}

TEST_F(Tenants, SeeTheirOwnScenesAndTheOperators) {
  startWithTokens();
  EXPECT_EQ(ask("chief", "PUT", "/v1/scenes/shared", rowGlb(1)).status, 201);
  EXPECT_EQ(ask("chief", "PUT", "/v1/scenes/a", rowGlb(2)).status, 201);
  EXPECT_EQ(ask("keeper", "PUT", "/v1/scenes/a", rowGlb(3)).status, 201);
  EXPECT_EQ(ask("other", "PUT", "/v1/scenes/a", rowGlb(4)).status, 201);
  EXPECT_EQ(ask("keeper", "PUT", "/v1/scenes/mine", rowGlb(5)).status, 201);
  const auto objects = [this](const std::string& token, const std::string& name) {
    const auto answer = ask(token, "GET", "/v1/scenes/" + name);
    return answer.status == 200 ? json::parse(answer.body)["objects"].get<int>() : -answer.status;
  };
  EXPECT_EQ(objects("reader", "a"), 3);
  EXPECT_EQ(objects("other", "a"), 4);
  EXPECT_EQ(objects("chief", "a"), 2);
  EXPECT_EQ(objects("other", "shared"), 1);
  EXPECT_EQ(objects("other", "mine"), -404);
  EXPECT_EQ(objects("chief", "mine"), -404);
  EXPECT_EQ(objects("chief", "acme:mine"), -400);
  EXPECT_EQ(json::parse(ask("other", "GET", "/v1/scenes").body)["scenes"].size(), 2U);
  EXPECT_EQ(json::parse(ask("reader", "GET", "/v1/status").body)["scenes"].size(), 3U);
  EXPECT_FALSE(json::parse(ask("reader", "GET", "/v1/status").body).contains("totals"));
  EXPECT_TRUE(json::parse(ask("chief", "GET", "/v1/status").body).contains("totals"));
  EXPECT_EQ(ask("keeper", "DELETE", "/v1/scenes/shared").status, 403);
  EXPECT_EQ(ask("other", "DELETE", "/v1/scenes/mine").status, 404);
  EXPECT_EQ(ask("keeper", "DELETE", "/v1/scenes/a").status, 204);
  EXPECT_EQ(objects("reader", "a"), 2) << "the operator's shows again";
  EXPECT_EQ(objects("other", "a"), 4);
  EXPECT_EQ(live("reader", "mine").upgradeStatus(), 101);
}

TEST_F(Tenants, FindTheirScenesAfterARestart) {
  startWithTokens();
  EXPECT_EQ(ask("keeper", "PUT", "/v1/scenes/mine", rowGlb(5)).status, 201);
  auto client = live("editor", "mine");
  protocol::Edit edit;
  edit.edits.emplace_back();
  EXPECT_TRUE(client.send(edit, 7));
  EXPECT_TRUE(client.await<protocol::Edited>());
  server.reset();
  start();
  const auto mine = ask("reader", "GET", "/v1/scenes/mine");
  EXPECT_EQ(mine.status, 200);
  EXPECT_EQ(json::parse(mine.body)["version"], 2) << "with its edits";
  EXPECT_EQ(ask("other", "GET", "/v1/scenes/mine").status, 404);
}

TEST_F(Tenants, EditOnlyWithTheScopeAndTheirOwnScenes) {
  startWithTokens();
  EXPECT_EQ(ask("keeper", "PUT", "/v1/scenes/a", rowGlb(3)).status, 201);
  EXPECT_EQ(ask("chief", "PUT", "/v1/scenes/shared", rowGlb(3)).status, 201);
  protocol::Edit edit;
  edit.edits.emplace_back();
  const auto refusal = [&edit](LiveClient client) {
    EXPECT_TRUE(client.send(edit, 7));
    const auto reply = client.receive();
    const auto* error = reply ? std::get_if<protocol::ErrorReply>(&reply->body) : nullptr;
    if (error == nullptr) return std::string("none");
    EXPECT_EQ(error->code, protocol::WireCode::kForbidden);
    EXPECT_TRUE(client.send(protocol::Ping{1}));
    EXPECT_TRUE(client.await<protocol::Pong>()) << "the connection lives on";
    return error->message;
  };
  EXPECT_EQ(refusal(live("reader", "a")), "edit: the token has not the scope edit");
  EXPECT_EQ(refusal(live("editor", "a")), "none");
  EXPECT_EQ(refusal(live("keeper", "shared")),
            "edit: the scene is the operator's, not this tenant's");
  EXPECT_EQ(refusal(live("chief", "shared")), "none");
}

TEST_F(Tenants, WaitWhenTheirCullingTimeIsUsedUp) {
  fake.cull_time = std::chrono::milliseconds(500);  // told, not spent
  startWithTokens("[tenant.acme]\ncull_ms_per_s = 10\n");
  EXPECT_EQ(ask("keeper", "PUT", "/v1/scenes/a", rowGlb(30)).status, 201);
  EXPECT_EQ(ask("other", "PUT", "/v1/scenes/a", rowGlb(30)).status, 201);
  auto mine = live("reader", "a");
  EXPECT_TRUE(mine.send(cameraAt(1), 10));
  EXPECT_TRUE(mine.await<protocol::Answer>());
  EXPECT_TRUE(mine.send(cameraAt(2), 11));
  std::uint64_t id = 0;
  const auto error = mine.await<protocol::ErrorReply>(&id);
  ASSERT_TRUE(error);
  EXPECT_EQ(error->code, protocol::WireCode::kQuotaExceeded);
  EXPECT_EQ(error->message, "view 1: tenant acme: 10 ms of culling per second are used up");
  EXPECT_EQ(id, 11U);
  EXPECT_TRUE(mine.send(protocol::Ping{1}));
  EXPECT_TRUE(mine.await<protocol::Pong>());
  auto sibling = live("keeper", "a");
  EXPECT_TRUE(sibling.send(cameraAt(2), 11));
  EXPECT_TRUE(sibling.await<protocol::ErrorReply>()) << "they pay together";
  auto theirs = live("other", "a");
  for (int i = 0; i < 3; ++i) {
    EXPECT_TRUE(theirs.send(cameraAt(i), 12));
    EXPECT_TRUE(theirs.await<protocol::Answer>());
  }
  EXPECT_EQ(ask("reader", "GET", "/v1/scenes/a").status, 200) << "a GET costs no culling";
  EXPECT_NE(metrics().find("culld_quota_rejected_total{reason=\"cull\"} 2"), std::string::npos);
}

TEST_F(Tenants, WaitWhenTheirBytesAreUsedUp) {
  startWithTokens("[tenant.acme]\nbytes_per_s = 100\n");
  EXPECT_EQ(ask("keeper", "PUT", "/v1/scenes/a", rowGlb(300)).status, 201);
  const auto refused = ask("reader", "GET", "/v1/scenes/a/objects");
  EXPECT_EQ(refused.status, 429) << "the reply to the upload was more than that";
  EXPECT_NE(refused.header.find("Retry-After: "), std::string::npos) << refused.header;
  EXPECT_EQ(ask("keeper", "PUT", "/v1/scenes/b", rowGlb(3)).status, 429);
  EXPECT_EQ(ask("other", "GET", "/v1/scenes").status, 200);
}

TEST_F(Tenants, HaveAShareOfScenes) {
  startWithTokens("[tenant.acme]\nscenes = 2\n");
  EXPECT_EQ(ask("keeper", "PUT", "/v1/scenes/a", rowGlb(3)).status, 201);
  EXPECT_EQ(ask("keeper", "PUT", "/v1/scenes/b", rowGlb(3)).status, 201);
  const auto refused = ask("keeper", "PUT", "/v1/scenes/c", rowGlb(3));
  EXPECT_EQ(refused.status, 429);
  EXPECT_NE(refused.header.find("Retry-After: 60"), std::string::npos);
  EXPECT_EQ(ask("keeper", "PUT", "/v1/scenes/a", rowGlb(4)).status, 200) << "a replacement";
  EXPECT_EQ(ask("other", "PUT", "/v1/scenes/c", rowGlb(3)).status, 201);
  EXPECT_EQ(ask("keeper", "DELETE", "/v1/scenes/b").status, 204);
  EXPECT_EQ(ask("keeper", "PUT", "/v1/scenes/c", rowGlb(3)).status, 201);
}

TEST_F(Tenants, LoseTheirSessionsWithTheirTokens) {
  startWithTokens();
  EXPECT_EQ(ask("chief", "PUT", "/v1/scenes/a", rowGlb(3)).status, 201);
  auto reader = live("reader", "a");
  auto other = live("other", "a");
  files.write("tokens.toml", tokenEntry("other", "globex", "admin"));
  ASSERT_TRUE(server->reloadAccess(options.access, {}).ok());
  const auto farewell = reader.await<protocol::GoAway>();
  ASSERT_TRUE(farewell);
  EXPECT_EQ(farewell->reason, "the token was withdrawn");
  EXPECT_EQ(reader.receiveFrame()->closeCode(), 1001U);
  EXPECT_TRUE(other.send(protocol::Ping{1}));
  EXPECT_TRUE(other.await<protocol::Pong>());
  EXPECT_EQ(ask("reader", "GET", "/v1/scenes").status, 401);
  files.write("tokens.toml", "nonsense");
  EXPECT_FALSE(server->reloadAccess(options.access, {}).ok());
  EXPECT_EQ(ask("other", "GET", "/v1/scenes").status, 200) << "the old tokens hold";
}

TEST_F(Tenants, LoseAnUploadUnderWayWithTheirToken) {
  startWithTokens();
  const std::string body = rowGlb(300);
  RawSocket slow = socket();
  slow.send(
      "PUT /v1/scenes/late HTTP/1.1\r\nHost: x\r\nAuthorization: Bearer keeper\r\nExpect: "
      "100-continue\r\nContent-Length: " +
      std::to_string(body.size()) + "\r\n\r\n");
  ASSERT_TRUE(slow.readUntil("100 Continue\r\n\r\n"));  // it was let in
  slow.send(body.substr(0, 100));
  files.write("tokens.toml", tokenEntry("chief", "", "admin"));
  ASSERT_TRUE(server->reloadAccess(options.access, {}).ok());
  slow.send(body.substr(100));
  EXPECT_EQ(readAnswer(slow).status, 401);
  EXPECT_EQ(ask("chief", "GET", "/v1/scenes/late").status, 404);
}

TEST_F(Tenants, AreNotToldHowBusyOthersAre) {
  startWithTokens();
  EXPECT_EQ(ask("chief", "PUT", "/v1/scenes/shared", rowGlb(3)).status, 201);
  EXPECT_EQ(ask("keeper", "PUT", "/v1/scenes/mine", rowGlb(3)).status, 201);
  const auto told = json::parse(ask("keeper", "GET", "/v1/status").body);
  ASSERT_EQ(told["scenes"].size(), 2U);
  EXPECT_TRUE(told["scenes"][0].contains("sessions")) << "its own";
  for (const char* key : {"sessions", "views", "uses"}) {
    EXPECT_FALSE(told["scenes"][1].contains(key)) << key;
  }
  EXPECT_FALSE(told.contains("totals"));
  const auto all = json::parse(ask("chief", "GET", "/v1/status").body);
  EXPECT_TRUE(all["scenes"][0].contains("uses"));
}

TEST_F(Tenants, HearTheirOwnNamesOnly) {
  startWithTokens();
  for (const auto& reply : {ask("keeper", "DELETE", "/v1/scenes/x"),
                            ask("keeper", "PUT", "/v1/scenes/x", "no scene")}) {
    EXPECT_GE(reply.status, 400);
    EXPECT_EQ(reply.body.find("acme"), std::string::npos) << reply.body;
  }
}

TEST_F(Tenants, PayForWhatIsSent) {
  startWithTokens("[tenant.acme]\nbytes_per_s = 1000\n");
  EXPECT_EQ(ask("chief", "PUT", "/v1/scenes/a", rowGlb(1'000)).status, 201);
  for (int i = 0; i < 20; ++i) {
    RawSocket s = socket();
    s.send("HEAD /v1/scenes/a/objects HTTP/1.1\r\nHost: x\r\nAuthorization: Bearer reader\r\n\r\n");
    EXPECT_EQ(readAnswer(s, false).status, 200);
  }
}

TEST_F(Tenants, CanReplaceAndRemoveTheirDamagedScene) {
  startWithTokens("[tenant.acme]\nscenes = 1\n");
  EXPECT_EQ(ask("chief", "PUT", "/v1/scenes/x", rowGlb(3)).status, 201);
  EXPECT_EQ(ask("keeper", "PUT", "/v1/scenes/x", rowGlb(5)).status, 201);
  server.reset();
  for (const auto& entry : std::filesystem::directory_iterator(folder / "data" / "scenes")) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with("acme:x~")) std::filesystem::resize_file(entry.path(), 100);
  }
  server = std::move(server::Server::start(options)).value();
  EXPECT_EQ(server->loadScenes().value().size(), 1U);
  EXPECT_EQ(ask("keeper", "GET", "/v1/scenes/x").status, 404) << "not the operator's";
  EXPECT_EQ(json::parse(ask("other", "GET", "/v1/scenes/x").body)["objects"], 3);
  EXPECT_EQ(ask("keeper", "PUT", "/v1/scenes/y", rowGlb(5)).status, 429) << "it is still held";
  EXPECT_EQ(ask("keeper", "PUT", "/v1/scenes/x", rowGlb(6)).status, 201) << "and can be replaced";
  EXPECT_EQ(ask("keeper", "DELETE", "/v1/scenes/x").status, 204);
  EXPECT_EQ(json::parse(ask("keeper", "GET", "/v1/scenes/x").body)["objects"], 3);
}

TEST_F(Tenants, LoseTheirTicketsAtAReload) {
  startWithTokens();
  EXPECT_EQ(ask("chief", "PUT", "/v1/scenes/a", rowGlb(3)).status, 201);
  const auto bought = json::parse(ask("reader", "POST", "/v1/tickets").body)["ticket"];
  ASSERT_TRUE(server->reloadAccess(options.access, {}).ok());
  EXPECT_EQ(ask("reader", "GET", "/v1/scenes").status, 200) << "the token holds";
  LiveClient late(socket(), "a", "culld.v1, culld.ticket." + bought.get<std::string>());
  EXPECT_EQ(late.upgradeStatus(), 401);
}

TEST_F(Tenants, KeepTheSessionsOfTicketsFromTheUnixSocket) {
  options.unix_path = (folder / "sock").string();
  startWithTokens();
  EXPECT_EQ(ask("chief", "PUT", "/v1/scenes/a", rowGlb(3)).status, 201);
  RawSocket backend = RawSocket::unixDomain(options.unix_path);
  backend.send("POST /v1/tickets HTTP/1.1\r\nHost: x\r\nContent-Length: 0\r\n\r\n");
  const auto bought = json::parse(readAnswer(backend).body)["ticket"].get<std::string>();
  LiveClient browser(socket(), "a", "culld.v1, culld.ticket." + bought);
  ASSERT_TRUE(browser.hello());
  ASSERT_TRUE(server->reloadAccess(options.access, {}).ok());
  EXPECT_EQ(ask("reader", "GET", "/v1/scenes").status, 200);
  browser.send(protocol::Ping{1});
  EXPECT_TRUE(browser.await<protocol::Pong>()) << "nothing of it was withdrawn";
}

}  // namespace
}  // namespace culld::testing
