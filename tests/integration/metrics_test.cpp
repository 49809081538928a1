// What the server says about itself for Prometheus: answers by what they are worth, errors by code.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <regex>

#include "culling/planner/auto_method.h"

#include "tests/integration/server_fixture.h"

namespace culld::testing {
namespace {

namespace wire = protocol;
using nlohmann::json;

class MetricsOf : public ServerTest {
 protected:
  LiveClient connect() {
    LiveClient client(socket(), "row");
    EXPECT_TRUE(client.hello().has_value());
    EXPECT_TRUE(client.openView(1));
    return client;
  }
  json statusOfScene() {
    return json::parse(request(port(), "GET", "/v1/status").body)["scenes"][0];
  }
  std::string metrics() { return request(port(), "GET", "/metrics").body; }
  const Method* stages[1] = {&fake};
  void expectLines(const std::vector<std::string>& lines) {
    const std::string text = "\n" + metrics();
    for (const std::string& line : lines) {
      EXPECT_NE(text.find("\n" + line + "\n"), std::string::npos) << line << text;
    }
  }
};

TEST_F(MetricsOf, ADaemonAtWork) {
  startWithRow();
  LiveClient client = connect();
  client.send(cameraAt(0));
  ASSERT_TRUE(client.await<wire::Answer>());
  expectLines({"culld_sessions 1", "culld_views 1", "culld_scenes 1",
               "culld_http_requests_total{code=\"201\",method=\"PUT\"} 1"});
}

TEST_F(MetricsOf, AnswersByWhatTheyAreWorth) {
  int made = 0;
  fake.on_answer = [&made](Answer& answer) {
    answer.stats.in_frustum = 150;
    if (++made == 1) return;  // conservative, proven, all seen
    answer.made_by = "stage";
    answer.guarantee = Guarantee::kSampled;
    answer.proven = false;
    answer.missed_px = 2.5F;
    answer.out_of_budget = true;
    std::fill(answer.seen.begin() + 40, answer.seen.end(), std::uint8_t{0});
  };
  startWithRow(300);
  LiveClient client = connect();
  for (int i = 0; i < 3; ++i) {
    client.send(cameraAt(0));
    const auto answer = client.await<wire::Answer>();
    ASSERT_TRUE(answer);
    EXPECT_EQ(answer->seen_count, i == 0 ? 100U : 40U);
    EXPECT_EQ(answer->kept_count, i == 0 ? 0U : 60U);
    EXPECT_EQ(answer->method, "fake");
    EXPECT_EQ(answer->made_by, i == 0 ? "" : "stage");
  }
  const std::string sure = "guarantee=\"conservative\",made_by=\"fake\",method=\"fake\"";
  const std::string guess = "guarantee=\"sampled\",made_by=\"stage\",method=\"fake\"";
  const std::string row = "scene=\"row\"";
  expectLines({"culld_answers_total{" + sure + ",proven=\"true\"," + row + "} 1",
               "culld_answers_total{" + guess + ",proven=\"false\"," + row + "} 2",
               "culld_answer_missed_px_sum{" + sure + ",proven=\"true\"," + row + "} 0",
               "culld_answer_missed_px_sum{" + guess + ",proven=\"false\"," + row + "} 5",
               "culld_answers_out_of_budget_total{" + sure + "," + row + "} 0",
               "culld_answers_out_of_budget_total{" + guess + "," + row + "} 2",
               "culld_answer_objects_total{" + guess + "," + row + "} 200",
               "culld_answer_in_frustum_objects_total{" + guess + "," + row + "} 300",
               "culld_answer_seen_objects_total{" + sure + "," + row + "} 100",
               "culld_answer_seen_objects_total{" + guess + "," + row + "} 80",
               "culld_answer_kept_objects_total{" + guess + "," + row + "} 120",
               "culld_cull_duration_seconds_count{" + guess + "," + row + "} 2"});
}

TEST_F(MetricsOf, EachMethodInUseForThePageOfPeople) {
  int made = 0;
  fake.cull_time = std::chrono::milliseconds(2);
  fake.on_answer = [&made](Answer& answer) {
    if (++made == 1) return;
    answer.made_by = "stage";
    answer.out_of_budget = made == 3;
  };
  startWithRow(300);
  EXPECT_EQ(statusOfScene()["uses"], json::array());
  LiveClient client = connect();
  for (int i = 0; i < 3; ++i) {
    client.send(cameraAt(0));
    ASSERT_TRUE(client.await<wire::Answer>());
  }
  const json uses = statusOfScene()["uses"];
  ASSERT_EQ(uses.size(), 2U) << uses;
  EXPECT_EQ(uses[0]["method"], "fake");
  EXPECT_EQ(uses[0]["answers"], 1);
  EXPECT_EQ(uses[0]["objects"], 100);
  EXPECT_EQ(uses[1]["method"], "stage");
  EXPECT_EQ(uses[1]["answers"], 2);
  EXPECT_EQ(uses[1]["objects"], 200);
  EXPECT_EQ(uses[1]["out_of_budget"], 1);
  EXPECT_NEAR(uses[1]["cull_seconds"].get<double>(), 0.004, 1e-9);
}

TEST_F(MetricsOf, ThePlanThatAnswersFollow) {
  const AutoMethod automatic{stages};
  table[0] = &automatic;
  startWithRow(5);
  EXPECT_TRUE(statusOfScene()["plan"].is_null()) << "nobody has asked yet";
  LiveClient client = connect();
  client.send(cameraAt(0));
  ASSERT_TRUE(client.await<wire::Answer>());
  const json plan = statusOfScene()["plan"];
  ASSERT_TRUE(plan.is_object()) << plan;
  EXPECT_EQ(plan["stages"], json({"fake"}));
  EXPECT_EQ(plan["occlusion"], "left out");
  EXPECT_FALSE(plan["why"].get<std::string>().empty());
  server.reset();  // before its method goes
}

TEST_F(MetricsOf, WhateverThePageReadsIsInItsSource) {
  startWithRow();
  const json status = json::parse(request(port(), "GET", "/v1/status").body);
  const std::string page = request(port(), "GET", "/").body;
  const std::pair<const char*, json> read[] = {
      {R"(\bnow\.(\w+))", status},
      {R"(\bs\.(\w+))", status["scenes"][0]},
      {R"(\bt\.(\w+))", status["totals"]},
      {R"(\b(?:gained|rate)\('(\w+)'\))", status["totals"]}};
  for (const auto& [pattern, source] : read) {
    const std::regex names(pattern);
    int found = 0;
    for (std::sregex_iterator at(page.begin(), page.end(), names), end; at != end; ++at, ++found) {
      EXPECT_TRUE(source.contains((*at)[1].str())) << (*at)[0].str();
    }
    EXPECT_GT(found, 3) << pattern;
  }
}

TEST_F(MetricsOf, AMethodThatDoesNotTellWhatItSawHasNoSuchCount) {
  fake.on_answer = [](Answer& answer) { answer.seen.clear(); };
  startWithRow();
  LiveClient client = connect();
  client.send(cameraAt(0));
  const auto answer = client.await<wire::Answer>();
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->seen_count + answer->kept_count, 0U);
  const std::string text = metrics();
  EXPECT_NE(text.find("culld_answer_objects_total{"), std::string::npos);
  EXPECT_EQ(text.find("culld_answer_seen_objects_total{"), std::string::npos);
  EXPECT_EQ(text.find("culld_answer_in_frustum_objects_total{"), std::string::npos);
}

TEST_F(MetricsOf, ARemovedSceneLeavesNoSeries) {
  startWithRow();
  {
    LiveClient client = connect();
    client.send(cameraAt(0));
    ASSERT_TRUE(client.await<wire::Answer>());
  }
  EXPECT_NE(metrics().find("scene=\"row\""), std::string::npos);
  EXPECT_EQ(request(port(), "DELETE", "/v1/scenes/row").status, 204);
  EXPECT_EQ(metrics().find("scene=\"row\""), std::string::npos);
}

TEST_F(MetricsOf, ErrorsByCode) {
  startWithRow();
  LiveClient client = connect();
  client.send(cameraAt(std::numeric_limits<double>::quiet_NaN()));
  ASSERT_TRUE(client.await<wire::ErrorReply>());
  wire::CameraUpdate flat = cameraAt(0);
  flat.camera.width_px = 0;
  client.send(flat);
  ASSERT_TRUE(client.await<wire::ErrorReply>());
  client.send(cameraAt(0, 0, 9));
  ASSERT_TRUE(client.await<wire::ErrorReply>());
  client.send(wire::Edit{7, {{wire::EditKind::kHide, 3, {}}}});
  ASSERT_TRUE(client.await<wire::ErrorReply>());
  fake.on_cull = [] { throw std::runtime_error("out of luck"); };
  client.send(cameraAt(0));
  ASSERT_TRUE(client.await<wire::ErrorReply>());
  expectLines({"culld_errors_total{code=\"invalid-camera\"} 2",
               "culld_errors_total{code=\"unknown-view\"} 1",
               "culld_errors_total{code=\"conflict\"} 1",
               "culld_errors_total{code=\"internal\"} 1"});
  EXPECT_NE(request(port(), "GET", "/v1/status").body.find("\"errors\":5"), std::string::npos);
}

}  // namespace
}  // namespace culld::testing
