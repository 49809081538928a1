// culld/client.h through the shared library, as a C program uses it.
#include <gtest/gtest.h>

#include <cstring>
#include <future>
#include <string>
#include <vector>

#include "culld/client.h"
#include "tests/unit/client/scripted_server.h"

namespace culld::client {
namespace {

struct COptions : culld_options {
  COptions() {
    culld_options_init(this, sizeof(culld_options));
    connect_ms = reply_ms = 2000;
    reconnect_first_ms = reconnect_longest_ms = 10;
  }
};

/// One connection with one view.
struct CClient {
  explicit CClient(const Address& address, const culld_options& options = COptions()) {
    EXPECT_EQ(culld_connect(toString(address).c_str(), "town", &options, &connection, &error),
              CULLD_OK)
        << error.message;
    if (connection == nullptr) return;
    EXPECT_EQ(culld_open_view(connection, nullptr, 0, &view, &error), CULLD_OK) << error.message;
  }
  ~CClient() {
    culld_view_free(view);
    culld_connection_free(connection);
  }
  culld_connection* connection = nullptr;
  culld_view* view = nullptr;
  culld_error error{};
};

TEST(CApi, AnswersACamera) {
  Script server([](Peer& peer) {
    peer.greet();
    peer.openView();
    const auto [id, update] = peer.nextCamera();
    EXPECT_EQ(update.camera.width_px, 640U);
    EXPECT_EQ(std::get<protocol::LookAt>(update.camera.pose).eye, (std::array<double, 3>{1, 2, 3}));
    EXPECT_EQ(update.demand.time_us, 50U);
    Answer answer = wholeAnswer(1, {4, 8});
    answer.seen = {2};
    answer.seen_count = answer.kept_count = 1;
    peer.send({id, answer});
    peer.awaitEnd();
  });
  CClient client(server.address());
  ASSERT_NE(client.view, nullptr);
  culld_scene_info scene;
  culld_connection_scene(client.connection, &scene, sizeof scene);
  EXPECT_EQ(scene.objects, 1000U);
  culld_camera camera;
  culld_camera_init(&camera, sizeof camera);
  camera.eye[0] = 1, camera.eye[1] = 2, camera.eye[2] = 3;
  camera.width_px = 640;
  culld_demand demand;
  culld_demand_init(&demand, sizeof demand);
  demand.time_us = 50;
  culld_frame* frame = nullptr;
  ASSERT_EQ(culld_cull(client.view, &camera, &demand, &frame, &client.error), CULLD_OK)
      << client.error.message;
  std::size_t count = 0;
  const std::uint32_t* ids = culld_frame_ids(frame, &count);
  ASSERT_EQ(count, 2U);
  EXPECT_EQ(ids[1], 8U);
  ASSERT_NE(culld_frame_seen(frame), nullptr);
  EXPECT_EQ(culld_frame_seen(frame)[1], 1);
  culld_frame_info info;
  culld_frame_get_info(frame, &info, sizeof info);
  EXPECT_EQ(info.camera, 1U);
  EXPECT_EQ(info.kept_count, 1U);
  EXPECT_EQ(info.proven, 1);
  culld_frame_free(frame);
}

struct Kept {
  std::promise<culld_frame*> frame;
  culld_view* view = nullptr;
  culld_code inner = CULLD_OK;
};

TEST(CApi, CallsBackAndLetsFramesBeKept) {
  Script server([](Peer& peer) {
    peer.greet();
    peer.openView();
    peer.send({peer.nextCamera().first, wholeAnswer(1, {5})});
    peer.awaitEnd();
  });
  CClient client(server.address());
  ASSERT_NE(client.view, nullptr);
  culld_camera camera;
  culld_camera_init(&camera, sizeof camera);
  Kept kept;
  kept.view = client.view;
  const auto number = culld_set_camera(
      client.view, &camera, nullptr,
      [](void* user, const culld_frame* frame, const culld_error* error) {
        auto* to = static_cast<Kept*>(user);
        EXPECT_EQ(error->code, CULLD_OK);
        culld_camera again;
        culld_camera_init(&again, sizeof again);
        culld_frame* none = nullptr;
        to->inner = culld_cull(to->view, &again, nullptr, &none, nullptr);
        to->frame.set_value(culld_frame_keep(frame));
      },
      &kept);
  EXPECT_EQ(number, 1U);
  culld_frame* frame = kept.frame.get_future().get();
  std::size_t count = 0;
  EXPECT_EQ(*culld_frame_ids(frame, &count), 5U);
  culld_frame_free(frame);
  EXPECT_EQ(kept.inner, CULLD_INVALID_INPUT);  // it would have waited for itself
}

TEST(CApi, TellsOfTheConnectionsComingsAndGoings) {
  Script server({[](Peer& peer) {
                   peer.greet();
                   peer.openView();
                   peer.send({peer.nextCamera().first, wholeAnswer(1, {5})});
                   peer.cut();
                 },
                 [](Peer& peer) {
                   peer.greet();
                   peer.awaitEnd();
                 }});
  std::vector<std::int32_t> states;
  std::promise<void> back;
  struct Told {
    std::vector<std::int32_t>& states;
    std::promise<void>& back;
  } told{states, back};
  CClient client(server.address());
  ASSERT_NE(client.view, nullptr);
  culld_connection_on_state(
      client.connection,
      [](void* user, std::int32_t state, const culld_error* reason) {
        auto* to = static_cast<Told*>(user);
        EXPECT_EQ(reason->code, state == CULLD_CONNECTED ? CULLD_OK : CULLD_UNAVAILABLE);
        to->states.push_back(state);
        if (state == CULLD_CONNECTED) to->back.set_value();
      },
      &told);
  culld_camera camera;
  culld_camera_init(&camera, sizeof camera);
  culld_set_camera(client.view, &camera, nullptr, nullptr, nullptr);
  ASSERT_EQ(back.get_future().wait_for(5s), std::future_status::ready);
  EXPECT_EQ(states, (std::vector<std::int32_t>{CULLD_RECONNECTING, CULLD_CONNECTED}));
  culld_connection_on_state(client.connection, nullptr, nullptr);
  culld_connection_close(client.connection);
  EXPECT_EQ(culld_connection_state(client.connection), CULLD_ENDED);
}

TEST(CApi, EditsAndPings) {
  Script server([](Peer& peer) {
    peer.greet();
    peer.openView();
    const Message message = peer.next();
    const auto& edit = std::get<protocol::Edit>(message.body);
    EXPECT_EQ(edit.expected_version, 3U);
    EXPECT_EQ(edit.edits.at(0).kind, protocol::EditKind::kAdd);
    EXPECT_EQ(edit.edits.at(0).world_from_mesh[11], 9.0);
    peer.send({message.id, protocol::Edited{4, {1000, 1001}}});
    peer.send({peer.next().id, protocol::Pong{1}});
    peer.awaitEnd();
  });
  CClient client(server.address());
  ASSERT_NE(client.view, nullptr);
  culld_edit_item items[2]{};
  items[0].kind = items[1].kind = CULLD_ADD;
  items[0].world_from_mesh[11] = 9.0;
  std::uint64_t version = 0;
  std::uint32_t added[1] = {0};
  std::size_t count = 0;
  ASSERT_EQ(culld_edit(client.connection, items, 2, 3, &version, added, 1, &count, nullptr),
            CULLD_OK);
  EXPECT_EQ(version, 4U);
  EXPECT_EQ(added[0], 1000U);
  EXPECT_EQ(count, 2U);
  std::uint64_t ns = 0;
  EXPECT_EQ(culld_ping(client.connection, &ns, nullptr), CULLD_OK);
  EXPECT_GT(ns, 0U);
}

TEST(CApi, AsksAboutPairs) {
  Script server([](Peer& peer) {
    peer.greet();
    peer.openView();
    const Message message = peer.next();
    const auto& pairs = std::get<protocol::Pairs>(message.body);
    EXPECT_EQ(pairs.time_us, 500U);
    EXPECT_EQ(pairs.viewers.at(1), (protocol::Place{{1, 2, 3}, {4, 5, 6}, 0.5}));
    EXPECT_EQ(pairs.targets.size(), 5U);
    peer.send({message.id, protocol::PairsAnswer{7, 2, 5, {0xFE, 0x01}, false, 1, 1}});
    peer.send({peer.next().id, protocol::PairsAnswer{7, 1, 1, {1}, false, 1, 1}});
    peer.awaitEnd();
  });
  CClient client(server.address());
  ASSERT_NE(client.view, nullptr);
  const culld_place viewers[2] = {{}, {{1, 2, 3}, {4, 5, 6}, 0.5}};
  const culld_place targets[5]{};
  std::uint8_t may_see[2] = {0, 0};
  std::uint64_t version = 0;
  ASSERT_EQ(culld_pairs(client.connection, viewers, 2, targets, 5, 500, may_see, &version, nullptr),
            CULLD_OK);
  EXPECT_EQ(may_see[0], 0xFE);
  EXPECT_EQ(may_see[1], 0x01);
  EXPECT_EQ(version, 7U);
  culld_error error;
  EXPECT_EQ(culld_pairs(client.connection, viewers, 2, targets, 5, 0, may_see, nullptr, &error),
            CULLD_UNAVAILABLE);
  EXPECT_NE(std::string(error.message).find("unexpected reply"), std::string::npos);
  EXPECT_EQ(culld_pairs(client.connection, nullptr, 2, targets, 5, 0, may_see, nullptr, &error),
            CULLD_INVALID_INPUT);
  EXPECT_EQ(culld_pairs(client.connection, viewers, 2, targets, 5, 0, nullptr, nullptr, &error),
            CULLD_INVALID_INPUT);
}

TEST(CApi, NamesBadArguments) {
  Script server([](Peer& peer) {
    peer.greet();
    peer.openView();
    peer.awaitEnd();
  });
  CClient client(server.address());
  ASSERT_NE(client.view, nullptr);
  culld_error error;
  culld_connection* none = nullptr;
  EXPECT_EQ(culld_connect("somewhere", "town", nullptr, &none, &error), CULLD_INVALID_INPUT);
  EXPECT_STREQ(error.message, "somewhere: not an address like ws://127.0.0.1:7420 or unix:PATH");
  EXPECT_EQ(none, nullptr);
  EXPECT_EQ(culld_connect(nullptr, nullptr, nullptr, &none, nullptr), CULLD_INVALID_INPUT);
  EXPECT_EQ(culld_connect("ws://127.0.0.1:1", "town", nullptr, nullptr, &error),
            CULLD_INVALID_INPUT);
  EXPECT_EQ(culld_connect("unix:/nonexistent", "town", nullptr, &none, &error), CULLD_UNAVAILABLE);
  culld_frame* frame = nullptr;
  EXPECT_EQ(culld_cull(client.view, nullptr, nullptr, &frame, &error), CULLD_INVALID_INPUT);
  culld_camera camera;
  culld_camera_init(&camera, sizeof camera);
  camera.kind = 7;
  EXPECT_EQ(culld_cull(client.view, &camera, nullptr, &frame, &error), CULLD_INVALID_INPUT);
  EXPECT_STREQ(error.message, "camera.kind: 7");
  EXPECT_EQ(culld_set_camera(client.view, &camera, nullptr, nullptr, nullptr), 0U);
  culld_edit_item item{};
  item.kind = -1;
  EXPECT_EQ(culld_edit(client.connection, &item, 1, 0, nullptr, nullptr, 0, nullptr, &error),
            CULLD_INVALID_INPUT);
  culld_connection_free(nullptr);
  culld_view_free(nullptr);
  culld_frame_free(nullptr);
}

TEST(CApi, TakesStructsOfOlderPrograms) {
  struct OldCamera {  // as if the header had ended after `up`
    std::size_t size;
    std::int32_t kind;
    double eye[3], target[3], up[3];
  } old{};
  std::vector<unsigned char> guard(sizeof(culld_camera), 0xEE);
  culld_camera_init(reinterpret_cast<culld_camera*>(guard.data()), sizeof old);
  for (std::size_t i = sizeof old; i < guard.size(); ++i) ASSERT_EQ(guard[i], 0xEE) << i;
  std::memcpy(&old, guard.data(), sizeof old);
  EXPECT_EQ(old.size, sizeof old);
  EXPECT_EQ(old.up[1], 1.0);
  EXPECT_EQ(culld_client_abi(), std::uint32_t{CULLD_CLIENT_ABI});
  EXPECT_STRNE(culld_client_version(), "");
}

}  // namespace
}  // namespace culld::client
