// The HTTP side over real sockets: probes, scenes, uploads, and everything that is not a request.
#include <gtest/gtest.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <thread>

#include "tests/integration/server_fixture.h"

namespace culld::testing {
namespace {

using nlohmann::json;

class Http : public ServerTest {
 protected:
  HttpAnswer get(const std::string& path) { return request(port(), "GET", path); }
  /// Sends bytes as they are and reads one reply.
  HttpAnswer raw(const std::string& bytes) {
    RawSocket s = socket();
    s.send(bytes);
    return readAnswer(s);
  }
  std::string errorOf(const HttpAnswer& answer) {
    const auto body = json::parse(answer.body, nullptr, false);
    return body.is_object() ? body.value("error", "") : "";
  }
};

TEST_F(Http, AnswersProbes) {
  startWithRow();
  EXPECT_EQ(get("/livez").status, 200);
  EXPECT_EQ(get("/readyz").status, 200);
  EXPECT_EQ(json::parse(get("/version").body)["protocol_max"], 1);
  EXPECT_NE(get("/").body.find("<title>culld</title>"), std::string::npos);
  const auto status = json::parse(get("/v1/status").body);
  EXPECT_EQ(status["ready"], true);
  EXPECT_EQ(status["scenes"][0]["name"], "row");
}

TEST_F(Http, IsNotReadyBeforeScenesAreLoaded) {
  options.listen_port = 0;
  options.methods = table;
  auto started = server::Server::start(options);
  ASSERT_TRUE(started.ok());
  server = std::move(started).value();
  EXPECT_EQ(get("/livez").status, 200);
  EXPECT_EQ(get("/readyz").status, 503);
  // What is still being loaded would overwrite what an upload brought.
  const std::string length = " HTTP/1.1\r\nHost: x\r\nContent-Length: 0\r\n\r\n";
  EXPECT_EQ(raw("PUT /v1/scenes/early" + length).status, 503);
  EXPECT_EQ(raw("DELETE /v1/scenes/early" + length).status, 503);
  // Whoever was here before the daemon was started again comes back later, and does not give up.
  EXPECT_EQ(LiveClient(socket(), "row").upgradeStatus(), 503);
  ASSERT_TRUE(server->loadScenes().ok());
  EXPECT_EQ(get("/readyz").status, 200);
  EXPECT_EQ(LiveClient(socket(), "row").upgradeStatus(), 404);
}

TEST_F(Http, ListsAndDescribesScenes) {
  startWithRow(7);
  EXPECT_EQ(json::parse(get("/v1/scenes").body)["scenes"].size(), 1U);
  const auto scene = json::parse(get("/v1/scenes/row").body);
  EXPECT_EQ(scene["objects"], 7);
  EXPECT_EQ(scene["triangles"], 7);
  EXPECT_EQ(scene["version"], 1);
  EXPECT_EQ(scene["method"], "fake");
  EXPECT_EQ(scene["bytes"], rowGlb(7).size());
  EXPECT_EQ(scene["hash"].get<std::string>().size(), 16U);
  const auto table_json = json::parse(get("/v1/scenes/row/objects").body);
  EXPECT_EQ(table_json["nodes"], json({0, 1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(table_json["instances"].size(), 7U);
}

TEST_F(Http, KeepsUploadsAcrossARestart) {
  startWithRow(7);
  const auto before = json::parse(get("/v1/scenes/row").body);
  server.reset();
  start();
  EXPECT_EQ(json::parse(get("/v1/scenes/row").body), before);
  EXPECT_EQ(request(port(), "DELETE", "/v1/scenes/row").status, 204);
  EXPECT_EQ(get("/v1/scenes/row").status, 404);
  server.reset();
  start();
  EXPECT_EQ(get("/v1/scenes/row").status, 404);
}

TEST_F(Http, TakesAnUploadInChunksOnAConnectionThatGoesOn) {
  start();
  RawSocket s = socket();
  s.send(
      "PUT /v1/scenes/c HTTP/1.1\r\nHost: x\r\nTransfer-Encoding: chunked\r\n"
      "Expect: 100-continue\r\n\r\n");
  EXPECT_EQ(s.readUntil("\r\n\r\n").value_or("").substr(9, 3), "100");
  const std::string glb = rowGlb(3);
  for (std::size_t at = 0; at < glb.size(); at += 100) {
    const std::string part = glb.substr(at, 100);
    char size[16];
    std::snprintf(size, sizeof size, "%zx\r\n", part.size());
    s.send(size + part + "\r\n");
  }
  s.send("0\r\n\r\n");
  EXPECT_EQ(readAnswer(s).status, 201);
  s.send("GET /v1/scenes/c HTTP/1.1\r\nHost: x\r\n\r\n");
  EXPECT_EQ(json::parse(readAnswer(s).body)["objects"], 3);
}

TEST_F(Http, NamesWhatIsWrongWithAnUpload) {
  start();
  const auto bad = request(port(), "PUT", "/v1/scenes/bad", "glTF? no.");
  EXPECT_EQ(bad.status, 422);
  EXPECT_EQ(errorOf(bad).rfind("bad: ", 0), 0U) << bad.body;
  EXPECT_EQ(request(port(), "PUT", "/v1/scenes/bad", "").status, 422);
  EXPECT_EQ(request(port(), "PUT", "/v1/scenes/..", rowGlb(1)).status, 400);
  EXPECT_EQ(request(port(), "PUT", "/v1/scenes/a%20b", rowGlb(1)).status, 400);
  EXPECT_EQ(raw("PUT /v1/scenes/x HTTP/1.1\r\nHost: x\r\n\r\n").status, 411);
  EXPECT_EQ(get("/v1/scenes/bad").status, 404);
}

TEST_F(Http, LimitsUploads) {
  options.limits.max_upload_bytes = 2000;
  options.limits.max_scenes = 1;
  start();
  EXPECT_EQ(request(port(), "PUT", "/v1/scenes/big", std::string(2001, 'x')).status, 413);
  RawSocket s = socket();
  s.send("PUT /v1/scenes/c HTTP/1.1\r\nHost: x\r\nTransfer-Encoding: chunked\r\n\r\n9C4\r\n" +
         std::string(2500, 'x') + "\r\n0\r\n\r\n");
  EXPECT_EQ(readAnswer(s).status, 413);
  EXPECT_EQ(request(port(), "PUT", "/v1/scenes/a", rowGlb(1)).status, 201);
  EXPECT_EQ(request(port(), "PUT", "/v1/scenes/b", rowGlb(1)).status, 503);
  EXPECT_TRUE(std::filesystem::is_empty(folder / "data" / "uploads"));
}

TEST_F(Http, DropsAnUploadThatStops) {
  options.limits.body_timeout = std::chrono::milliseconds(200);
  start();
  RawSocket s = socket();
  s.send("PUT /v1/scenes/slow HTTP/1.1\r\nHost: x\r\nContent-Length: 1000\r\n\r\nabc");
  EXPECT_TRUE(s.readToEnd()) << "the connection is closed";
  RawSocket half = socket();
  half.send("PUT /v1/scenes/half HTTP/1.1\r\nHost: x\r\nContent-Length: 1000\r\n\r\nabc");
  half.shutdownWrite();
  EXPECT_TRUE(half.readToEnd());
  EXPECT_TRUE(std::filesystem::is_empty(folder / "data" / "uploads"));
  EXPECT_EQ(get("/v1/scenes").body.find("slow"), std::string::npos);
}

TEST_F(Http, RefusesAnUploadThatCrawls) {
  options.limits.body_timeout = std::chrono::milliseconds(300);
  options.limits.min_upload_bytes_per_s = 1'000'000;
  start();
  RawSocket s = socket();
  s.send("PUT /v1/scenes/crawl HTTP/1.1\r\nHost: x\r\nContent-Length: 100000\r\n\r\n");
  for (int i = 0; i < 20 && s.send("abc"); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  EXPECT_EQ(readAnswer(s).status, 408);
}

struct BadRequest {
  const char* what;
  std::string bytes;
  int status;
};

const char* const kKey = "dGhlIHNhbXBsZSBub25jZQ==";

std::string upgrade(const std::string& version, const std::string& key,
                    const std::string& more = "", const std::string& scene = "row") {
  return "GET /v1/scenes/" + scene +
         "/live HTTP/1.1\r\nHost: x\r\nUpgrade: websocket\r\n"
         "Connection: Upgrade\r\nSec-WebSocket-Protocol: culld.v1\r\nSec-WebSocket-Version: " +
         version + "\r\n" + (key.empty() ? key : "Sec-WebSocket-Key: " + key + "\r\n") + more +
         "\r\n";
}

TEST_F(Http, UpgradesARequestThatCarriesCookies) {
  startWithRow();
  RawSocket s = socket();
  s.send(upgrade("13", kKey, "Cookie: " + std::string(6000, 'c') + "\r\n"));
  EXPECT_EQ(s.readUntil("\r\n\r\n").value_or("").substr(0, 12), "HTTP/1.1 101");
}

TEST_F(Http, AnswersWhatIsNoProperRequest) {
  startWithRow();
  const std::string host = " HTTP/1.1\r\nHost: x\r\n\r\n";
  const std::vector<BadRequest> table_of_bad = {
      {"unknown path", "GET /nowhere" + host, 404},
      {"unknown scene", "GET /v1/scenes/none" + host, 404},
      {"unknown scene's table", "GET /v1/scenes/none/objects" + host, 404},
      {"name that cannot be", "GET /v1/scenes/.hidden" + host, 400},
      {"removing what is not there", "DELETE /v1/scenes/none" + host, 404},
      {"method not allowed", "POST /v1/scenes/row" + host, 405},
      {"writing to a probe", "PUT /livez" + host, 405},
      {"live without upgrade", "GET /v1/scenes/row/live" + host, 426},
      {"another version of WebSocket", upgrade("12", kKey), 426},
      {"upgrade without a key", upgrade("13", ""), 400},
      {"upgrade with a body", upgrade("13", kKey, "Content-Length: 5\r\n"), 400},
      {"unknown method", "BREW /livez" + host, 405},
      {"no version", "GET /livez\r\n\r\n", 400},
      {"garbage", "\x16\x03\x01 hello tls \r\n\r\n", 400},
      {"header too large", "GET /livez HTTP/1.1\r\nX: " + std::string(9000, 'x') + "\r\n\r\n", 431},
      {"two lengths",
       "PUT /v1/scenes/x HTTP/1.1\r\nHost: x\r\nContent-Length: 3\r\nContent-Length: 4\r\n\r\nabc",
       400},
      {"no number", "PUT /v1/scenes/x HTTP/1.1\r\nContent-Length: many\r\n\r\n", 400},
      {"no host", "GET /livez HTTP/1.1\r\n\r\n", 400},
      {"two hosts", "GET /livez HTTP/1.1\r\nHost: x\r\nHost: y\r\n\r\n", 400},
      {"live path of a name that cannot be", "GET /v1/scenes/.hidden/live" + host, 400},
      {"upgrade for a name that cannot be", upgrade("13", kKey, "", "a%20b"), 400},
  };
  for (const BadRequest& bad : table_of_bad) {
    const auto answer = raw(bad.bytes);
    EXPECT_EQ(answer.status, bad.status) << bad.what;
    EXPECT_FALSE(errorOf(answer).empty()) << bad.what << ": " << answer.body;
  }
  EXPECT_EQ(get("/livez").status, 200);
}

TEST_F(Http, WantsNoHostFromAnOldClient) {
  start();
  EXPECT_EQ(raw("GET /livez HTTP/1.0\r\n\r\n").status, 200);
}

TEST_F(Http, TakesAbsoluteTargets) {
  startWithRow();
  const std::string rest = " HTTP/1.1\r\nHost: x\r\n\r\n";
  EXPECT_EQ(raw("GET http://x/livez" + rest).body, "live\n");
  EXPECT_EQ(raw("GET http://x:7420/v1/scenes/row?a=b" + rest).status, 200);
  EXPECT_EQ(raw("GET http://x/nowhere" + rest).status, 404);
}

TEST_F(Http, AnswersARequestThatIsCutShort) {
  start();
  RawSocket header = socket();
  header.send("GET /livez HTTP/1.1\r\nHost: x\r\n");
  header.shutdownWrite();
  const auto cut = readAnswer(header);
  EXPECT_EQ(cut.status, 400);
  EXPECT_EQ(errorOf(cut), "the request ends within its header");
  EXPECT_TRUE(header.readToEnd());
  RawSocket upload = socket();
  upload.send("PUT /v1/scenes/half HTTP/1.1\r\nHost: x\r\nContent-Length: 1000\r\n\r\nabc");
  upload.shutdownWrite();
  const auto half = readAnswer(upload);
  EXPECT_EQ(half.status, 400);
  EXPECT_EQ(errorOf(half), "scene \"half\": the upload ends before its length");
}

TEST_F(Http, NamesWhatItRefuses) {
  options.limits.max_header_bytes = 1000;
  startWithRow();
  const std::string host = " HTTP/1.1\r\nHost: x\r\n\r\n";
  EXPECT_EQ(errorOf(raw("GET /no/where?x" + host)), "path \"/no/where\" is not known");
  EXPECT_EQ(errorOf(raw("POST /livez" + host)),
            "path \"/livez\": method POST, allowed are GET, HEAD");
  EXPECT_EQ(errorOf(raw("GET /v1/scenes/row/live" + host)),
            "path \"/v1/scenes/row/live\": a WebSocket upgrade is due here");
  EXPECT_EQ(errorOf(raw("PUT /v1/scenes/x" + host)),
            "scene \"x\": an upload needs Content-Length or chunks");
  EXPECT_EQ(errorOf(raw("GET / HTTP/1.1\r\nX: " + std::string(2000, 'x'))),
            "request header larger than 1000 bytes");
}

TEST_F(Http, TakesARequestInSingleBytes) {
  startWithRow();
  RawSocket s = socket();
  for (const char c : std::string("GET /livez HTTP/1.1\r\nHost: x\r\n\r\n")) {
    ASSERT_TRUE(s.send({&c, 1}));
  }
  EXPECT_EQ(readAnswer(s).status, 200);
}

TEST_F(Http, AnswersSeveralRequestsOnOneConnectionAndHeadWithoutABody) {
  startWithRow();
  RawSocket s = socket();
  s.send(
      "GET /livez HTTP/1.1\r\nHost: x\r\n\r\nHEAD /v1/scenes HTTP/1.1\r\nHost: x\r\n\r\n"
      "GET /readyz HTTP/1.1\r\nHost: x\r\n\r\n");
  EXPECT_EQ(readAnswer(s).body, "live\n");
  EXPECT_EQ(readAnswer(s, false).status, 200);
  EXPECT_EQ(readAnswer(s).body, "ready\n");
}

TEST_F(Http, ClosesAConnectionThatSaysNothing) {
  options.limits.header_timeout = std::chrono::milliseconds(200);
  start();
  RawSocket silent = socket();
  EXPECT_TRUE(silent.readToEnd());
  RawSocket drip = socket();
  drip.send("GET /livez HT");
  EXPECT_TRUE(drip.readToEnd());
  RawSocket half = socket();
  half.shutdownWrite();
  EXPECT_TRUE(half.readToEnd());
}

TEST_F(Http, RefusesMoreConnectionsThanTheLimit) {
  options.limits.max_connections = 3;
  startWithRow();
  std::vector<LiveClient> clients;
  for (int i = 0; i < 3; ++i) {
    clients.emplace_back(socket(), "row");
    EXPECT_EQ(clients.back().upgradeStatus(), 101);
  }
  RawSocket fourth = socket();
  const auto refusal = readAnswer(fourth);
  EXPECT_EQ(refusal.status, 503);
  EXPECT_EQ(errorOf(refusal), "too many connections: 3 are open, and no more are taken");
  clients.clear();
  for (int i = 0; i < 200; ++i) {  // closing takes the server a moment
    if (get("/livez").status == 200) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  FAIL() << "the places of gone clients are not free again";
}

TEST_F(Http, SaysWhenItCannotListen) {
  start();
  server::ServerOptions second = options;
  second.listen_port = port();
  second.data_folder.clear();
  const auto taken = server::Server::start(second);
  ASSERT_FALSE(taken.ok());
  EXPECT_EQ(taken.error().code, ErrorCode::kUnavailable);
  second.listen_port = 0;
  second.listen_host = "not-an-address";
  const auto malformed = server::Server::start(second);
  ASSERT_FALSE(malformed.ok());
  EXPECT_EQ(malformed.error().code, ErrorCode::kInvalidInput);
  EXPECT_EQ(malformed.error().message, "not-an-address:0: not-an-address is not an IP address");
}

TEST_F(Http, ReplacesASocketFileThatNobodyAnswersOnOnly) {
  options.unix_path = (folder / "sock").string();
  start();
  server::ServerOptions second = options;
  second.listen_port = 0;
  second.data_folder.clear();
  EXPECT_FALSE(server::Server::start(second).ok()) << "in use";
  EXPECT_TRUE(RawSocket::unixDomain(options.unix_path).connected()) << "and left alone";
  server.reset();
  EXPECT_FALSE(std::filesystem::exists(options.unix_path));
}

TEST_F(Http, BoundsWhatChunksHaveBesidesTheirBytes) {
  startWithRow();
  const std::string head =
      "PUT /v1/scenes/up HTTP/1.1\r\nHost: x\r\nTransfer-Encoding: chunked\r\n\r\n";
  for (const char* start : {"5;", "0000", "1\r\na\r\n0\r\nX-Trailer: "}) {
    RawSocket s = socket();
    s.send(head + start);
    for (int i = 0; i < 40 && s.send(std::string(100'000, '0')); ++i) {
    }
    EXPECT_EQ(readAnswer(s).status, 431) << start;
  }
  EXPECT_EQ(get("/v1/scenes/up").status, 404);
}

TEST_F(Http, RefusesWhatCouldBeReadInTwoWays) {
  startWithRow();
  const std::string get_it = "GET /v1/scenes HTTP/1.1\r\n";
  EXPECT_EQ(raw(get_it + "Host: a\r\nHost: b\r\n\r\n").status, 400);
  EXPECT_EQ(raw(get_it + "Host: a\r\nOrigin: http://a\r\nOrigin: http://b\r\n\r\n").status, 400);
  EXPECT_EQ(
      raw(get_it + "Host: a\r\nAuthorization: Bearer a\r\nAuthorization: Bearer b\r\n\r\n").status,
      400);
  const std::string put = "PUT /v1/scenes/up HTTP/1.1\r\nHost: a\r\n";
  EXPECT_EQ(raw(put + "Transfer-Encoding: gzip, chunked\r\n\r\n0\r\n\r\n").status, 501);
  EXPECT_EQ(raw(put + "Content-Encoding: gzip\r\nContent-Length: 3\r\n\r\nabc").status, 415);
}

TEST_F(Http, TakesSubprotocolsFromSeveralLines) {
  startWithRow();
  RawSocket s = socket();
  s.send(
      "GET /v1/scenes/row/live HTTP/1.1\r\nHost: a\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
      "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n"
      "Sec-WebSocket-Protocol: other\r\nSec-WebSocket-Protocol: culld.v1\r\n\r\n");
  EXPECT_EQ(readAnswer(s, false).status, 101);
}

}  // namespace
}  // namespace culld::testing
