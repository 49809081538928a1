// RFC 6455 as a table: what a client sends behind its Hello, byte by byte, and what must come back.
// Lengths, control frames, fragments, reserved bits and opcodes, masks, UTF-8, close codes. Each
// case runs twice: sent at once, and in single bytes. Where the RFC leaves the choice of a close
// code, the table has the one that is sent.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "protocol/codec.h"
#include "tests/integration/server_fixture.h"

namespace culld::testing {
namespace {

namespace wire = protocol;

enum Opcode : unsigned {
  kContinuation = 0,
  kText = 1,
  kBinary = 2,
  kClose = 8,
  kPing = 9,
  kPong = 10
};

/// How the length is written, whatever it is.
enum class Length { kShortest, k16Bits, k64Bits };

struct Shape {
  bool final = true;
  unsigned reserved = 0;  ///< RSV1 is 4, RSV3 is 1
  bool masked = true;
  std::array<unsigned, 4> mask = {0x12, 0x34, 0x56, 0x78};
  Length length = Length::kShortest;
};

std::string header(unsigned opcode, std::uint64_t length, const Shape& shape = {}) {
  std::string out;
  const auto put = [&out](std::uint64_t value) { out += static_cast<char>(value & 0xFFU); };
  put((shape.final ? 0x80U : 0U) | shape.reserved << 4 | opcode);
  const unsigned mask_bit = shape.masked ? 0x80U : 0U;
  const bool wide =
      shape.length == Length::k64Bits || (shape.length == Length::kShortest && length > 0xFFFF);
  const bool small = shape.length == Length::kShortest && length < 126;
  put(mask_bit | (small ? length : wide ? 127U : 126U));
  if (!small) {
    for (int shift = wide ? 56 : 8; shift >= 0; shift -= 8) put(length >> shift);
  }
  if (shape.masked) {
    for (const unsigned byte : shape.mask) put(byte);
  }
  return out;
}

std::string frame(unsigned opcode, std::string_view payload = {}, const Shape& shape = {}) {
  std::string out = header(opcode, payload.size(), shape);
  for (std::size_t i = 0; i < payload.size(); ++i) {
    const auto plain = static_cast<unsigned char>(payload[i]);
    out += static_cast<char>(shape.masked ? plain ^ shape.mask[i % 4] : plain);
  }
  return out;
}

std::string part(unsigned opcode, std::string_view payload, bool final) {
  return frame(opcode, payload, {.final = final});
}

std::string closeWith(unsigned code, std::string_view reason = {}) {
  std::string payload;
  payload += static_cast<char>(code >> 8);
  payload += static_cast<char>(code & 0xFFU);
  return frame(kClose, payload + std::string(reason));
}

std::string message(const wire::Body& body) {
  const auto bytes = wire::encode({7, body});
  return {bytes.begin(), bytes.end()};
}

/// What came back, in words.
std::string described(const Frame& frame) {
  if (frame.opcode == kPong) return "pong " + frame.payload.substr(0, 8);
  if (frame.opcode == kClose) {
    return frame.payload.empty() ? "close" : "close " + std::to_string(frame.closeCode());
  }
  const std::vector<std::uint8_t> bytes(frame.payload.begin(), frame.payload.end());
  const auto reply = wire::decode(bytes, wire::kMaxReplyBytes);
  if (frame.opcode != kBinary || !reply) return "opcode " + std::to_string(frame.opcode);
  if (const auto* error = std::get_if<wire::ErrorReply>(&reply.value().body)) {
    return wire::wireCodeName(error->code);
  }
  if (const auto* pong = std::get_if<wire::Pong>(&reply.value().body)) {
    return "Pong " + std::to_string(pong->time_ns);
  }
  return "message " + std::to_string(reply.value().body.index());
}

struct Case {
  std::string what;
  std::string sent;
  std::vector<std::string> expected;  ///< ends with "close …", or the connection lives on
};
using Cases = std::vector<Case>;

const std::string kCulldPing = message(wire::Ping{42});

Cases lengths() {
  Cases cases;
  for (const std::size_t length : {0U, 1U, 125U, 126U, 127U, 128U, 65535U, 65536U, 262144U}) {
    cases.push_back({"a binary message of " + std::to_string(length) + " bytes",
                     frame(kBinary, std::string(length, 'x')),
                     {"bad-message"}});
  }
  const auto with = [](Length length) { return Shape{.length = length}; };
  const std::string close = "close 1002";
  cases.push_back({"5 bytes with a length of 16 bits",
                   frame(kBinary, "hello", with(Length::k16Bits)),
                   {close}});
  cases.push_back({"5 bytes with a length of 64 bits",
                   frame(kBinary, "hello", with(Length::k64Bits)),
                   {close}});
  cases.push_back({"125 bytes with a length of 16 bits",
                   frame(kBinary, std::string(125, 'x'), with(Length::k16Bits)),
                   {close}});
  cases.push_back({"65535 bytes with a length of 64 bits",
                   frame(kBinary, std::string(65535, 'x'), with(Length::k64Bits)),
                   {close}});
  cases.push_back(
      {"a length whose top bit is set", header(kBinary, std::uint64_t{1} << 63U), {"close 1009"}});
  cases.push_back({"one byte more than a message may have",
                   frame(kBinary, std::string(262145, 'x')),
                   {"close 1009"}});
  cases.push_back({"a length of an exabyte, and nothing behind it",
                   header(kBinary, std::uint64_t{1} << 60U),
                   {"close 1009"}});
  cases.push_back({"parts that add up to too much",
                   part(kBinary, std::string(200'000, 'x'), false) +
                       part(kContinuation, std::string(100'000, 'x'), true),
                   {"close 1009"}});
  return cases;
}

Cases controls() {
  const std::string most(125, 'p');
  return {
      {"a ping without payload", frame(kPing), {"pong "}},
      {"a ping", frame(kPing, "abc"), {"pong abc"}},
      {"a ping with all it may carry", frame(kPing, most), {"pong pppppppp"}},
      {"a ping with one byte more", frame(kPing, most + "p"), {"close 1002"}},
      {"a ping of 65536 bytes", frame(kPing, std::string(65536, 'p')), {"close 1002"}},
      {"a ping with a length of 16 bits",
       frame(kPing, "abc", {.length = Length::k16Bits}),
       {"close 1002"}},
      {"a ping in fragments",
       part(kPing, "a", false) + part(kContinuation, "b", true),
       {"close 1002"}},
      {"a pong in fragments", part(kPong, "a", false), {"close 1002"}},
      {"a close in fragments", frame(kClose, "\x03\xE8", {.final = false}), {"close 1002"}},
      {"a pong that nobody asked for", frame(kPong, "abc"), {}},
      {"a pong with one byte too many", frame(kPong, most + "p"), {"close 1002"}},
      {"a ping and a message in one write",
       frame(kPing, "abc") + frame(kBinary, kCulldPing),
       {"pong abc", "Pong 42"}},
      {"a mask of zeros", frame(kBinary, kCulldPing, {.mask = {0, 0, 0, 0}}), {"Pong 42"}},
      {"a mask of ones",
       frame(kBinary, kCulldPing, {.mask = {0xFF, 0xFF, 0xFF, 0xFF}}),
       {"Pong 42"}},
      {"a message without a mask", frame(kBinary, kCulldPing, {.masked = false}), {"close 1002"}},
      {"a ping without a mask", frame(kPing, "abc", {.masked = false}), {"close 1002"}},
      {"a close without a mask", frame(kClose, "\x03\xE8", {.masked = false}), {"close 1002"}},
  };
}

Cases reserved() {
  Cases cases;
  for (const unsigned bits : {1U, 2U, 4U, 7U}) {
    for (const unsigned opcode : {kText, kBinary, kClose, kPing, kPong}) {
      cases.push_back(
          {"reserved bits " + std::to_string(bits) + " on opcode " + std::to_string(opcode),
           frame(opcode, "", {.reserved = bits}),
           {"close 1002"}});
    }
  }
  for (const unsigned opcode : {3U, 4U, 5U, 6U, 7U, 11U, 12U, 13U, 14U, 15U}) {
    cases.push_back(
        {"reserved opcode " + std::to_string(opcode), frame(opcode, "x"), {"close 1002"}});
    cases.push_back({"reserved opcode " + std::to_string(opcode) + " within a message",
                     part(kBinary, "x", false) + frame(opcode, "x"),
                     {"close 1002"}});
  }
  return cases;
}

Cases fragments() {
  const std::string first = kCulldPing.substr(0, 9);
  const std::string second = kCulldPing.substr(9, 5);
  const std::string third = kCulldPing.substr(14);
  std::string bytewise = part(kBinary, kCulldPing.substr(0, 1), false);
  for (const char byte : kCulldPing.substr(1)) bytewise += part(kContinuation, {&byte, 1}, false);
  std::string empty = part(kBinary, "", false);
  for (int i = 0; i < 200; ++i) empty += part(kContinuation, "", false);
  return {
      {"a message in three parts",
       part(kBinary, first, false) + part(kContinuation, second, false) +
           part(kContinuation, third, true),
       {"Pong 42"}},
      {"pings between the parts",
       part(kBinary, first, false) + frame(kPing, "1") + part(kContinuation, second, false) +
           frame(kPong, "?") + frame(kPing, "2") + part(kContinuation, third, true),
       {"pong 1", "pong 2", "Pong 42"}},
      {"parts of one byte, and an empty last",
       bytewise + part(kContinuation, "", true),
       {"Pong 42"}},
      {"empty parts, and all in the last",
       empty + part(kContinuation, kCulldPing, true),
       {"Pong 42"}},
      {"nothing but empty parts", empty + part(kContinuation, "", true), {"bad-message"}},
      {"two messages in parts",
       part(kBinary, first, false) + part(kContinuation, second + third, true) +
           part(kBinary, first + second, false) + part(kContinuation, third, true),
       {"Pong 42", "Pong 42"}},
      {"a continuation of nothing", part(kContinuation, "x", true), {"close 1002"}},
      {"a first continuation of nothing", part(kContinuation, "x", false), {"close 1002"}},
      {"a continuation after the last part",
       frame(kBinary, kCulldPing) + part(kContinuation, "x", true),
       {"Pong 42", "close 1002"}},
      {"a new message within a message",
       part(kBinary, first, false) + frame(kBinary, kCulldPing),
       {"close 1002"}},
      {"a text within a message", part(kBinary, first, false) + frame(kText, "x"), {"close 1002"}},
      {"a close within a message", part(kBinary, first, false) + closeWith(1000), {"close 1000"}},
  };
}

Cases texts() {
  Cases cases;
  const auto takes = [&cases](const std::string& what, const std::string& sent) {
    cases.push_back({what, sent, {"bad-message"}});  // culld speaks binary, and lives on
  };
  const auto refuses = [&cases](const std::string& what, const std::string& sent) {
    cases.push_back({what, sent, {"close 1007"}});
  };
  const auto text = [](std::string_view bytes) { return frame(kText, bytes); };
  takes("an empty text", text(""));
  takes("a text of every length of character", text("a\xC3\xA9\xE2\x82\xAC\xF0\x9F\x98\x80"));
  takes("the last character there is", text("\xF4\x8F\xBF\xBF"));
  takes("characters around the surrogates", text("\xED\x9F\xBF\xEE\x80\x80"));
  takes("a character split between parts",
        part(kText, "\xE2\x82", false) + part(kContinuation, "\xAC", true));
  takes("a character split by a ping's length of parts",
        part(kText, "\xF0", false) + part(kContinuation, "\x9F\x98", false) +
            part(kContinuation, "\x80", true));
  refuses("a continuation byte alone", text("\x80"));
  refuses("a character cut short by another", text("\xC3\x28"));
  refuses("a character cut short by the end", text("\xE2\x82"));
  refuses("an overlong slash of two bytes", text("\xC0\xAF"));
  refuses("an overlong slash of three bytes", text("\xE0\x80\xAF"));
  refuses("an overlong slash of four bytes", text("\xF0\x80\x80\xAF"));
  refuses("a high surrogate", text("\xED\xA0\x80"));
  refuses("a low surrogate", text("\xED\xBF\xBF"));
  refuses("a character past the last", text("\xF4\x90\x80\x80"));
  refuses("a character of five bytes", text("\xF8\x88\x80\x80\x80"));
  refuses("the bytes FE and FF", text("\xFE\xFF"));
  refuses("a character that its last part leaves open",
          part(kText, "\xE2\x82", false) + part(kContinuation, "x", true));
  refuses("a text that is no text from its second part on",
          part(kText, "fine", false) + part(kContinuation, "\xFF", false));
  return cases;
}

Cases closes() {
  Cases cases = {
      {"a close without a code", frame(kClose), {"close 1000"}},
      {"a close with half a code", frame(kClose, "\x03"), {"close 1002"}},
      {"a close with a reason", closeWith(1000, "bye"), {"close 1000"}},
      {"a close with the longest reason", closeWith(1000, std::string(123, 'b')), {"close 1000"}},
      {"a close with too long a reason", closeWith(1000, std::string(124, 'b')), {"close 1002"}},
      {"a close with a reason of many alphabets",
       closeWith(1000, "\xC3\xA9\xE2\x82\xAC"),
       {"close 1000"}},
      {"a close with a reason that is no text", closeWith(1000, "\xC3\x28"), {"close 1002"}},
      {"a message after a close", closeWith(1000) + frame(kBinary, kCulldPing), {"close 1000"}},
      {"a ping after a close", closeWith(1000) + frame(kPing, "abc"), {"close 1000"}},
      {"a close after a close", closeWith(1000) + closeWith(1001), {"close 1000"}},
  };
  for (const unsigned code : {1000U, 1001U, 1002U, 1003U, 1007U, 1008U, 1009U, 1010U, 1011U, 3000U,
                              3999U, 4000U, 4999U}) {
    cases.push_back({"a close with the code " + std::to_string(code),
                     closeWith(code),
                     {"close " + std::to_string(code)}});
  }
  for (const unsigned code :
       {0U, 1U, 999U, 1004U, 1005U, 1006U, 1015U, 1016U, 1100U, 2000U, 2999U}) {
    cases.push_back(
        {"a close with the code " + std::to_string(code), closeWith(code), {"close 1002"}});
  }
  return cases;
}

class WebSocketCases : public ServerTest {
 protected:
  /// What comes back for the case; a message behind it shows whether the connection lives on.
  std::vector<std::string> outcome(const Case& c, bool bytewise) {
    LiveClient client(socket(), "row");
    EXPECT_TRUE(client.hello());
    if (bytewise) {
      for (const char byte : c.sent) client.socket().send({&byte, 1});
    } else {
      client.socket().send(c.sent);
    }
    std::vector<std::string> came;
    const bool ends = !c.expected.empty() && c.expected.back().rfind("close", 0) == 0;
    if (!ends) client.send(wire::Ping{999});
    while (const auto frame = client.receiveFrame()) {
      const std::string what = described(*frame);
      if (what == "Pong 999") return came;
      came.push_back(what);
      if (frame->opcode == kClose) break;
    }
    // The server's part of the closing handshake is over: it hangs up.
    if (ends && !client.socket().readToEnd()) came.emplace_back("and stays open");
    return came;
  }

  void run(const Cases& cases) {
    startWithRow(3);
    for (const Case& c : cases) {
      for (const bool bytewise : {false, true}) {
        if (bytewise && c.sent.size() > 2000) continue;
        EXPECT_EQ(outcome(c, bytewise), c.expected) << c.what << (bytewise ? ", byte by byte" : "");
      }
    }
    EXPECT_TRUE(awaitNoConnections(std::chrono::seconds(10))) << "every one of them was let go";
  }
};

TEST_F(WebSocketCases, Lengths) { run(lengths()); }
TEST_F(WebSocketCases, ControlFramesAndMasks) { run(controls()); }
TEST_F(WebSocketCases, ReservedBitsAndOpcodes) { run(reserved()); }
TEST_F(WebSocketCases, Fragments) { run(fragments()); }
TEST_F(WebSocketCases, Texts) { run(texts()); }
TEST_F(WebSocketCases, Closes) { run(closes()); }

}  // namespace
}  // namespace culld::testing
