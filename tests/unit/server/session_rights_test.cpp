// What a session refuses because of who its client is; no sockets, no files.
#include <gtest/gtest.h>

#include "protocol/codec.h"
#include "server/session.h"
#include "tests/unit/server/fake_method.h"

namespace culld::server {
namespace {

namespace wire = protocol;
using namespace std::chrono_literals;

class SessionRightsTest : public ::testing::Test {
 protected:
  void begin(SessionRights rights, const std::string& scene_name = "row") {
    scene = std::make_shared<Scene>(scene_name, Methods(table), rowOfObjects(30));
    session.emplace(scene, SessionLimits{}, "culld/test", now, std::move(rights));
    say(wire::Hello{1, 1, "test"});
    say(wire::OpenView{1, "", false});
  }
  void say(wire::Body body) { actions = session->receive(wire::encode({9, std::move(body)}), now); }
  void camera() {
    wire::LookAt look;
    look.eye = {0, 0, 5};
    wire::CameraUpdate update;
    update.view = 1;
    update.camera.pose = look;
    say(std::move(update));
  }
  void edit() {
    wire::Edit edit;
    edit.edits.emplace_back();
    say(std::move(edit));
  }
  const Send* sent() const {
    return actions.empty() ? nullptr : std::get_if<Send>(&actions.front());
  }
  template <typename T>
  std::optional<T> reply() const {
    if (sent() == nullptr) return std::nullopt;
    auto message = wire::decode(sent()->bytes, wire::kMaxReplyBytes);
    const T* body = std::get_if<T>(&message.value().body);
    return body == nullptr ? std::nullopt : std::optional<T>(*body);
  }

  FakeMethod fake;
  const Method* table[1] = {&fake};
  Time now{0};
  std::shared_ptr<Scene> scene;
  std::optional<Session> session;
  Actions actions;
};

TEST_F(SessionRightsTest, RefusesEditsOfAReaderInWords) {
  begin({nullptr, "the token has not the scope edit"});
  edit();
  const auto error = reply<wire::ErrorReply>();
  ASSERT_TRUE(error);
  EXPECT_EQ(error->code, wire::WireCode::kForbidden);
  EXPECT_EQ(error->message, "edit: the token has not the scope edit");
  camera();
  ASSERT_EQ(actions.size(), 1U);
  EXPECT_TRUE(std::holds_alternative<StartCull>(actions[0])) << "it may look";
}

TEST_F(SessionRightsTest, TakesEditsOfWhomMay) {
  begin({});
  edit();
  ASSERT_EQ(actions.size(), 1U);
  EXPECT_TRUE(std::holds_alternative<StartEdit>(actions[0]));
}

TEST_F(SessionRightsTest, RefusesCamerasOfATenantInDebtAndGoesOnLater) {
  const auto tenant = std::make_shared<Tenant>("acme", Quotas{100, 0, 0});
  begin({tenant, ""});
  tenant->culled(300ms, now);
  camera();
  const auto error = reply<wire::ErrorReply>();
  ASSERT_TRUE(error);
  EXPECT_EQ(error->code, wire::WireCode::kQuotaExceeded);
  EXPECT_EQ(error->message, "view 1: tenant acme: 100 ms of culling per second are used up");
  EXPECT_EQ(sent()->quota, QuotaReason::kCull);
  EXPECT_TRUE(session->drained() || session->viewCount() == 1U) << "the view is still there";
  now += 2001ms;
  camera();
  ASSERT_EQ(actions.size(), 1U);
  EXPECT_TRUE(std::holds_alternative<StartCull>(actions[0]));
}

TEST_F(SessionRightsTest, RefusesPairsOfATenantInDebtAndGoesOnLater) {
  const auto tenant = std::make_shared<Tenant>("acme", Quotas{100, 0, 0});
  begin({tenant, ""});
  tenant->culled(300ms, now);
  const wire::Pairs question{{wire::Place{}}, {wire::Place{}}, 0};
  say(question);
  const auto error = reply<wire::ErrorReply>();
  ASSERT_TRUE(error);
  EXPECT_EQ(error->code, wire::WireCode::kQuotaExceeded);
  EXPECT_EQ(error->message, "pairs: tenant acme: 100 ms of culling per second are used up");
  EXPECT_EQ(sent()->quota, QuotaReason::kCull);
  now += 2001ms;
  say(question);
  ASSERT_EQ(actions.size(), 1U);
  EXPECT_TRUE(std::holds_alternative<StartPairs>(actions[0]));
}

TEST_F(SessionRightsTest, CallsASceneByTheNameThatItsTenantKnows) {
  begin({std::make_shared<Tenant>("acme"), ""}, "acme:row");
  session.emplace(scene, SessionLimits{}, "culld/test", now, SessionRights{});
  say(wire::Hello{1, 1, "test"});
  const auto welcome = reply<wire::Welcome>();
  ASSERT_TRUE(welcome);
  EXPECT_EQ(welcome->scene.name, "row");
}

}  // namespace
}  // namespace culld::server
