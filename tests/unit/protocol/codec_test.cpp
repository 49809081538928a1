#include "protocol/codec.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "protocol/version.h"

namespace culld::protocol {
namespace {

using Bytes = std::vector<std::uint8_t>;

Camera matrixCamera() {
  Camera camera;
  Matrices matrices;
  for (std::size_t i = 0; i < 16; ++i) {
    matrices.view[i] = 0.5 * static_cast<double>(i);
    matrices.projection[i] = -1e300 * static_cast<double>(i);
  }
  camera.pose = matrices;
  camera.radius_m = 0.25;
  camera.angle_rad = 0.01;
  return camera;
}

Answer fullAnswer() {
  Answer a;
  a.view = 3;
  a.frame = 17;
  a.baseline = 12;
  a.scene_version = 5;
  a.scene_objects = 1000;
  a.encoding = Encoding::kAddRemove;
  a.payload = {0, 0};
  a.object_count = 9;
  a.set_hash = 0xFEDCBA9876543210ULL;
  a.guarantee = Guarantee::kSampled;
  a.missed_px = 0.5F;
  a.proven = false;
  a.out_of_budget = true;
  a.method = "raster";
  a.note = "time ran out";
  a.superseded = 4;
  a.seen = {0xFF, 0x01};
  a.stats = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10};
  a.seen_count = 7;
  a.kept_count = 2;
  a.made_by = "frustum";
  return a;
}

std::vector<Body> everyBody() {
  LookAt finite;
  finite.zfar_m = 100.0;
  Camera look;
  look.pose = finite;
  CameraUpdate by_matrix{8, matrixCamera(), {Guarantee::kHole, 2.0F, 1.5F, 4000}, 6, 16'667};
  EditItem move{EditKind::kMove, 4, {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}};
  EditItem hide{EditKind::kHide, 5, {}};
  const SceneInfo scene{"city", 7, 0x0123456789ABCDEFULL, 120'000, 10'900'000};
  return {Hello{1, 3, "test", kFeatureCancel | 1ULL << 63U},
          Welcome{1, "culld/0", {1024, 2, 3, 4, 5, 6, 7, 8, 9, 10}, scene, kFeatureDeadlines},
          OpenView{2, "frustum", true},
          ViewOpened{2, "frustum", Guarantee::kApproximate},
          CloseView{2},
          ViewClosed{2},
          CameraUpdate{1, look, {}, 0},
          CameraUpdate{1, Camera{}, {}, 9},
          by_matrix,
          fullAnswer(),
          Edit{3, {move, hide}},
          Edited{4, {100, 101}},
          Ping{77},
          Pong{78},
          SceneChanged{scene, true},
          ErrorReply{WireCode::kInvalidCamera, "view 1: eye.x is not finite"},
          GoAway{"bye"},
          Cancel{1ULL << 40U},
          Pairs{{{{1, 2, 3}, {4, 5, 6}, 0.5}}, {{}, {{-1, 0, 1}, {0, 1, 2}, 0}}, 77},
          PairsAnswer{3, 3, 3, {0xFF, 1}, true, 5, 6}};
}

TEST(Codec, GivesBackEveryMessage) {
  std::uint64_t id = 1;
  for (const Body& body : everyBody()) {
    const Message message{id++, body};
    const auto back = decode(encode(message), kMaxReplyBytes);
    ASSERT_TRUE(back.ok()) << back.error().message;
    EXPECT_EQ(back.value(), message) << "body " << body.index();
  }
}

TEST(Codec, CoversEveryKindOfMessage) {
  std::vector<bool> covered(std::variant_size_v<Body>);
  for (const Body& body : everyBody()) covered[body.index()] = true;
  EXPECT_EQ(std::count(covered.begin(), covered.end(), false), 0);
}

TEST(Codec, ReadsFromAnyAlignment) {
  const Bytes bytes = encode({5, fullAnswer()});
  for (std::size_t shift = 0; shift < 8; ++shift) {
    Bytes shifted(bytes.size() + shift);
    std::copy(bytes.begin(), bytes.end(), shifted.begin() + static_cast<std::ptrdiff_t>(shift));
    const auto back = decode(std::span(shifted).subspan(shift), kMaxReplyBytes);
    ASSERT_TRUE(back.ok());
    EXPECT_EQ(back.value().body, Body(fullAnswer()));
  }
}

TEST(Codec, RefusesEveryTruncation) {
  for (const Body& body : everyBody()) {
    const Bytes bytes = encode({9, body});
    for (std::size_t length = 0; length < bytes.size(); ++length) {
      const auto cut = decode(std::span(bytes).first(length), kMaxReplyBytes);
      // FlatBuffers pads: what only lost padding may still be whole, and then it is equal.
      if (cut.ok()) {
        EXPECT_EQ(cut.value().body, body);
      }
    }
  }
}

TEST(Codec, SurvivesEveryFlippedBit) {
  for (const Body& body : everyBody()) {
    const Bytes bytes = encode({9, body});
    for (std::size_t bit = 0; bit < bytes.size() * 8; ++bit) {
      Bytes flipped = bytes;
      flipped[bit / 8] = static_cast<std::uint8_t>(flipped[bit / 8] ^ (1U << (bit % 8)));
      const auto back = decode(flipped, kMaxReplyBytes);
      if (!back.ok()) {
        EXPECT_FALSE(back.error().message.empty());
      }
    }
  }
}

TEST(Codec, TellsTooLargeFromMalformed) {
  const Bytes bytes = encode({1, Ping{1}});
  const auto large = decode(bytes, bytes.size() - 1);
  ASSERT_FALSE(large.ok());
  EXPECT_EQ(large.error().code, ErrorCode::kLimit);
  const auto garbage = decode(Bytes(100, 0xAB), 1000);
  ASSERT_FALSE(garbage.ok());
  EXPECT_EQ(garbage.error().code, ErrorCode::kInvalidInput);
}

TEST(Codec, SaysWhichRequestABadMessageWas) {
  CameraUpdate update;
  update.demand.guarantee = static_cast<Guarantee>(200);
  std::uint64_t id = 0;
  const auto bad = decode(encode({4711, update}), kMaxRequestBytes, &id);
  ASSERT_FALSE(bad.ok());
  EXPECT_EQ(id, 4711U);
  EXPECT_EQ(bad.error().message, "guarantee: unknown value 200");
}

TEST(Codec, RefusesAnUnknownBody) {
  Bytes bytes = encode({1, Ping{1}});
  // The union's type is the only byte with the value of Ping that a decoder reacts to in this way.
  bool found = false;
  for (std::uint8_t& byte : bytes) {
    if (byte != 11) continue;
    byte = 200;
    const auto back = decode(bytes, kMaxRequestBytes);
    found = found || (!back.ok() && back.error().code == ErrorCode::kUnsupported &&
                      back.error().message == "message body type 200 is not known");
    byte = 11;
  }
  EXPECT_TRUE(found);
}

TEST(Codec, RefusesAnswersThatContradictThemselves) {
  const auto refused = [](auto change) {
    Answer answer = fullAnswer();
    change(answer);
    return !decode(encode({1, answer}), kMaxReplyBytes).ok();
  };
  EXPECT_FALSE(refused([](Answer&) {}));
  EXPECT_TRUE(refused([](Answer& a) { a.frame = 0; }));
  EXPECT_TRUE(refused([](Answer& a) { a.baseline = a.frame; }));
  EXPECT_TRUE(refused([](Answer& a) { a.baseline = 0; }));
  EXPECT_TRUE(refused([](Answer& a) { a.encoding = Encoding::kRawU32; }));
  EXPECT_TRUE(refused([](Answer& a) { a.encoding = static_cast<Encoding>(9); }));
  EXPECT_TRUE(refused([](Answer& a) { a.object_count = 1001; }));
  EXPECT_TRUE(refused([](Answer& a) { a.scene_objects = kMaxObjects + 1; }));
  EXPECT_TRUE(refused([](Answer& a) { a.seen.push_back(0); }));
  EXPECT_FALSE(refused([](Answer& a) { a.seen_count = a.kept_count = 0; })) << "not told";
  EXPECT_TRUE(refused([](Answer& a) { ++a.kept_count; }));
  EXPECT_TRUE(refused([](Answer& a) { a.seen_count = 0xFFFFFFFF; }));
}

TEST(Codec, CutsTextThatNoDecoderWouldTake) {
  const auto back = decode(encode({1, GoAway{std::string(100'000, 'x')}}), kMaxReplyBytes);
  ASSERT_TRUE(back.ok());
  EXPECT_EQ(std::get<GoAway>(back.value().body).reason.size(), kMaxTextBytes);
}

TEST(Codec, RefusesMoreEditsThanTheLimit) {
  Edit edit;
  edit.edits.assign(kMaxEdits, EditItem{EditKind::kHide, 1, {}});
  EXPECT_TRUE(decode(encode({1, edit}), kMaxReplyBytes).ok());
  edit.edits.push_back({EditKind::kHide, 1, {}});
  const auto back = decode(encode({1, edit}), kMaxReplyBytes);
  ASSERT_FALSE(back.ok());
  EXPECT_EQ(back.error().code, ErrorCode::kLimit);
}

TEST(Codec, RefusesMorePairsThanTheLimit) {
  Pairs pairs;
  pairs.viewers.resize(256);
  pairs.targets.resize(256);
  EXPECT_TRUE(decode(encode({1, pairs}), kMaxReplyBytes).ok());
  pairs.targets.emplace_back();
  const auto back = decode(encode({1, pairs}), kMaxReplyBytes);
  ASSERT_FALSE(back.ok());
  EXPECT_EQ(back.error().code, ErrorCode::kLimit);
  EXPECT_EQ(back.error().message, "pairs: 256 viewers x 257 targets > 65536");
}

TEST(Codec, RefusesAnswersWithoutABitForEachPair) {
  for (const std::size_t bytes : {0U, 1U, 3U}) {
    const auto back =
        decode(encode({1, PairsAnswer{1, 3, 3, std::vector<std::uint8_t>(bytes), false, 0, 0}}),
               kMaxReplyBytes);
    ASSERT_FALSE(back.ok()) << bytes;
    EXPECT_EQ(back.error().message, "pairs answer: may_see does not fit the number of pairs");
  }
  EXPECT_FALSE(
      decode(encode({1, PairsAnswer{1, 65536, 65536, {}, false, 0, 0}}), kMaxReplyBytes).ok());
}

TEST(Codec, SurvivesRandomBytesBehindARightHeader) {
  std::mt19937 random(3);
  std::uniform_int_distribution<unsigned> byte(0, 255);
  for (int round = 0; round < 20'000; ++round) {
    Bytes bytes = encode({1, fullAnswer()});
    for (int i = 0; i < 4; ++i) {
      bytes[8 + random() % (bytes.size() - 8)] = static_cast<std::uint8_t>(byte(random));
    }
    const auto back = decode(bytes, kMaxReplyBytes);
    if (back.ok()) {
      EXPECT_LE(back.value().id, std::numeric_limits<std::uint64_t>::max());
    }
  }
}

}  // namespace
}  // namespace culld::protocol
