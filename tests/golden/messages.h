// One message of every kind, with every field set, and some with none: what tests/golden holds as
// bytes and as JSON. Append only: a message that was golden once must be read for ever.
#pragma once
#include <string>
#include <utility>
#include <vector>

#include "protocol/messages.h"

namespace culld::testing {

struct GoldenMessage {
  std::string name;  ///< of its files
  protocol::Message message;
};

inline protocol::Camera goldenMatrixCamera() {
  protocol::Matrices matrices;
  for (std::size_t i = 0; i < 16; ++i) {
    matrices.view[i] = 0.5 * static_cast<double>(i);
    matrices.projection[i] = -1000.25 * static_cast<double>(i);
  }
  protocol::Camera camera;
  camera.pose = matrices;
  camera.width_px = 640;
  camera.height_px = 480;
  camera.radius_m = 0.25;
  camera.angle_rad = 0.125;
  return camera;
}

inline protocol::Camera goldenLookAtCamera() {
  protocol::LookAt look;
  look.eye = {1.0, -2.5, 3.0};
  look.target = {4.0, 5.0, -6.0};
  look.up = {0.0, 0.0, 1.0};
  look.yfov_rad = 0.75;
  look.aspect = 1.5;
  look.znear_m = 0.0625;
  look.zfar_m = 1000.0;
  protocol::Camera camera;
  camera.pose = look;
  return camera;
}

inline protocol::Answer goldenChange() {
  protocol::Answer a;
  a.view = 3;
  a.frame = 17;
  a.baseline = 12;
  a.scene_version = 5;
  a.scene_objects = 1000;
  a.encoding = protocol::Encoding::kAddRemove;
  a.payload = {0x02, 0x01, 0xAA, 0x02, 0x01, 0x07};  // {2, 7} becomes {1, 2, 300}
  a.object_count = 3;
  a.set_hash = 0x0F7E2E44E0EFEB6FULL;
  a.guarantee = protocol::Guarantee::kSampled;
  a.missed_px = 0.5F;
  a.proven = false;
  a.out_of_budget = true;
  a.method = "auto";
  a.note = "time ran out";
  a.superseded = 4;
  a.seen = {0x05};
  a.stats = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10};
  a.seen_count = 2;
  a.kept_count = 1;
  a.made_by = "raster";
  return a;
}

inline protocol::Answer goldenWhole(protocol::Encoding encoding,
                                    std::vector<std::uint8_t> payload) {
  protocol::Answer a;
  a.view = 1;
  a.frame = 1;
  a.scene_version = 1;
  a.scene_objects = 301;
  a.encoding = encoding;
  a.payload = std::move(payload);
  a.object_count = 3;
  a.set_hash = 0x0F7E2E44E0EFEB6FULL;
  a.method = "frustum";
  return a;
}

inline std::vector<GoldenMessage> goldenMessages() {
  using namespace protocol;
  const SceneInfo city{"city", 7, 0x0123456789ABCDEFULL, 120'000, 10'900'000};
  const Limits limits{262'144, 64, 1024, 60'000, 192, 16, 20'000, 4096, 65'536, 16};
  CameraUpdate look{1, goldenLookAtCamera(), {}, 0, 0};
  CameraUpdate matrices{8, goldenMatrixCamera(), {Guarantee::kHole, 2.0F, 1.5F, 4000}, 6, 16'667};
  const EditItem move{EditKind::kMove, 4, {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}};
  const EditItem add{EditKind::kAdd, 7, {1, 0, 0, 0.5, 0, 1, 0, -0.5, 0, 0, 1, 0.25}};
  const Edit edit{
      3,
      {move, {EditKind::kHide, 5, {}}, {EditKind::kShow, 5, {}}, {EditKind::kRemove, 6, {}}, add}};
  return {
      {"hello", {1, Hello{1, 1, "golden", kFeatureCancel | kFeatureDeadlines}}},
      {"welcome", {1, Welcome{1, "culld/0.1.0", limits, city, kFeatureCancel | kFeatureDeadlines}}},
      {"open_view", {2, OpenView{2, "frustum", true}}},
      {"view_opened", {2, ViewOpened{2, "frustum", Guarantee::kApproximate}}},
      {"close_view", {3, CloseView{2}}},
      {"view_closed", {3, ViewClosed{2}}},
      {"camera_look_at", {4, look}},
      {"camera_matrices", {5, matrices}},
      {"answer_change", {5, goldenChange()}},
      {"answer_raw", {6, goldenWhole(Encoding::kRawU32, {1, 0, 0, 0, 2, 0, 0, 0, 0x2C, 1, 0, 0})}},
      {"answer_varint", {7, goldenWhole(Encoding::kDeltaVarint, {0x01, 0x00, 0xA9, 0x02})}},
      {"answer_bitset",
       {8, goldenWhole(Encoding::kTwoLevelBitset,
                       {1,                             // one mask
                        0x11, 0, 0, 0, 0, 0,    0, 0,  // words 0 and 4
                        0x06, 0, 0, 0, 0, 0,    0, 0,  // bits 1 and 2
                        0,    0, 0, 0, 0, 0x10, 0, 0})}},
      {"edit", {9, edit}},
      {"edited", {9, Edited{4, {100, 101}}}},
      {"ping", {10, Ping{77}}},
      {"pong", {10, Pong{77}}},
      {"scene_changed", {0, SceneChanged{city, true}}},
      {"error_reply", {11, ErrorReply{WireCode::kCancelled, "view 1: cancelled while it waited"}}},
      {"go_away", {0, GoAway{"the server is shutting down"}}},
      {"cancel", {12, Cancel{1ULL << 40U}}},
      {"pairs",
       {13, Pairs{{{{1, 2, 3}, {1, 2, 3}, 0.5}}, {{{-4, 0, 4}, {-3.5, 1.75, 4.5}, 0}}, 2000}}},
      {"pairs_answer", {13, PairsAnswer{7, 3, 3, {0x5D, 0x01}, true, 1500, 250}}},
  };
}

}  // namespace culld::testing
