// A second client written from docs/protocol.md: libwebsockets, and what flatc makes of the schema;
// no code of the server's or of the SDK's. Converses, then says that it waits, and expects the
// server to go away politely. usage: lws_client PORT SCENE
#include <libwebsockets.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "culld_generated.h"

namespace {

namespace fbs = culld::fbs;
using Bytes = std::vector<std::uint8_t>;
using Ids = std::set<std::uint32_t>;

void expect(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "lws_client: %s\n", what);
  std::exit(1);
}

/// The socket, as a program without callbacks would like it.
class Socket {
 public:
  Socket(int port, const std::string& path) {
    static const std::array<lws_protocols, 2> kProtocols = {
        {{"culld.v1", &Socket::called, 0, 65536, 0, nullptr, 0},
         {nullptr, nullptr, 0, 0, 0, nullptr, 0}}};
    lws_set_log_level(LLL_ERR, nullptr);
    lws_context_creation_info settings{};
    settings.port = CONTEXT_PORT_NO_LISTEN;
    settings.protocols = kProtocols.data();
    settings.user = this;
    context_ = lws_create_context(&settings);
    lws_client_connect_info to{};
    to.context = context_;
    to.address = to.host = to.origin = "127.0.0.1";
    to.port = port;
    to.path = path.c_str();
    to.protocol = to.local_protocol_name = "culld.v1";
    to.pwsi = &socket_;
    lws_client_connect_via_info(&to);
    while (!open_ && !closed_) lws_service(context_, 0);
    expect(open_, "no connection");
  }
  ~Socket() { lws_context_destroy(context_); }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;

  void send(const std::uint8_t* data, std::size_t size) {
    Bytes framed(LWS_PRE);
    framed.insert(framed.end(), data, data + size);
    outbox_.push_back(std::move(framed));
    lws_callback_on_writable(socket_);
  }
  /// Empty when the connection has ended.
  Bytes receive() {
    while (inbox_.empty() && !closed_) lws_service(context_, 0);
    if (inbox_.empty()) return {};
    Bytes message = std::move(inbox_.front());
    inbox_.pop_front();
    return message;
  }
  unsigned closeCode() const { return close_code_; }

 private:
  static int called(lws* socket, lws_callback_reasons why, void*, void* data, std::size_t size) {
    auto* self = static_cast<Socket*>(lws_context_user(lws_get_context(socket)));
    return self == nullptr ? 0 : self->happened(socket, why, data, size);
  }

  int happened(lws* socket, lws_callback_reasons why, void* data, std::size_t size) {
    const auto* bytes = static_cast<const std::uint8_t*>(data);
    switch (why) {
      case LWS_CALLBACK_CLIENT_ESTABLISHED:
        open_ = true;
        break;
      case LWS_CALLBACK_CLIENT_RECEIVE:
        partial_.insert(partial_.end(), bytes, bytes + size);
        if (lws_is_final_fragment(socket) == 0 || lws_remaining_packet_payload(socket) != 0) break;
        expect(lws_frame_is_binary(socket) != 0, "a message that is not binary");
        inbox_.push_back(std::exchange(partial_, {}));
        break;
      case LWS_CALLBACK_CLIENT_WRITEABLE:
        write(socket);
        break;
      case LWS_CALLBACK_WS_PEER_INITIATED_CLOSE:
        if (size >= 2) close_code_ = static_cast<unsigned>(bytes[0] << 8 | bytes[1]);
        break;
      case LWS_CALLBACK_CLIENT_CONNECTION_ERROR:
      case LWS_CALLBACK_CLIENT_CLOSED:
        closed_ = true;
        break;
      default:
        break;
    }
    return 0;
  }

  void write(lws* socket) {
    if (outbox_.empty()) return;
    Bytes message = std::move(outbox_.front());
    outbox_.pop_front();
    const int size = static_cast<int>(message.size() - LWS_PRE);
    expect(lws_write(socket, message.data() + LWS_PRE, static_cast<std::size_t>(size),
                     LWS_WRITE_BINARY) >= size,
           "cannot write");
    if (!outbox_.empty()) lws_callback_on_writable(socket);
  }

  lws_context* context_ = nullptr;
  lws* socket_ = nullptr;
  bool open_ = false, closed_ = false;
  unsigned close_code_ = 0;
  Bytes partial_;
  std::deque<Bytes> inbox_, outbox_;
};

// --- sets of ids (docs/protocol.md "Sets of ids") ------------------------------------------------

class Payload {
 public:
  explicit Payload(const flatbuffers::Vector<std::uint8_t>* bytes)
      : at_(bytes == nullptr ? nullptr : bytes->data()),
        end_(bytes == nullptr ? nullptr : bytes->data() + bytes->size()) {}

  bool done() const { return at_ == end_; }
  template <typename Number>
  Number number() {
    expect(end_ - at_ >= static_cast<std::ptrdiff_t>(sizeof(Number)), "a payload cut short");
    Number value = 0;
    std::memcpy(&value, at_, sizeof value);
    at_ += sizeof value;
    return value;
  }
  std::uint32_t varint() {
    std::uint64_t value = 0;
    for (unsigned shift = 0; shift < 35; shift += 7) {
      const auto byte = number<std::uint8_t>();
      value |= std::uint64_t{byte & 0x7FU} << shift;
      if (byte < 0x80) return static_cast<std::uint32_t>(value);
    }
    expect(false, "a varint of more than five bytes");
    return 0;
  }
  Ids gaps(std::uint64_t count) {
    Ids ids;
    std::uint32_t next = 0;
    for (; count > 0 && !done(); --count) {
      next += varint();
      ids.insert(next++);
    }
    return ids;
  }

 private:
  const std::uint8_t* at_;
  const std::uint8_t* end_;
};

Ids bitset(Payload& in) {
  std::vector<std::uint64_t> masks(in.varint());
  for (auto& mask : masks) mask = in.number<std::uint64_t>();
  Ids ids;
  for (std::uint32_t word = 0; word < masks.size() * 64; ++word) {
    if ((masks[word / 64] >> word % 64 & 1U) == 0) continue;
    const auto bits = in.number<std::uint64_t>();
    for (std::uint32_t bit = 0; bit < 64; ++bit) {
      if ((bits >> bit & 1U) != 0) ids.insert(word * 64 + bit);
    }
  }
  return ids;
}

Ids decoded(const fbs::Answer& answer, Ids baseline) {
  Payload in(answer.payload());
  Ids ids;
  switch (answer.encoding()) {
    case fbs::Encoding::RawU32:
      while (!in.done()) ids.insert(in.number<std::uint32_t>());
      break;
    case fbs::Encoding::DeltaVarint:
      ids = in.gaps(~0ULL);
      break;
    case fbs::Encoding::TwoLevelBitset:
      ids = bitset(in);
      break;
    case fbs::Encoding::AddRemove: {
      const Ids added = in.gaps(in.varint());
      const Ids removed = in.gaps(in.varint());
      ids = std::move(baseline);
      for (const std::uint32_t id : removed) expect(ids.erase(id) == 1, "removed but not there");
      for (const std::uint32_t id : added) expect(ids.insert(id).second, "added but there");
      break;
    }
  }
  expect(in.done(), "bytes left over");
  expect(ids.empty() || *ids.rbegin() < answer.scene_objects(), "an id past the last");
  return ids;
}

std::uint32_t mix(std::uint32_t x) {
  x = (x ^ x >> 16) * 0x85ebca6bU;
  x = (x ^ x >> 13) * 0xc2b2ae35U;
  return x ^ x >> 16;
}

std::uint64_t hashOf(const Ids& ids) {
  std::uint32_t high = 0, low = 0;
  for (const std::uint32_t id : ids) {
    high += mix(id ^ 0x9e3779b9U);
    low += mix(id + 1);
  }
  return std::uint64_t{high} << 32U | low;
}

// --- the conversation ----------------------------------------------------------------------------

class Client {
 public:
  Client(int port, const std::string& scene) : socket_(port, "/v1/scenes/" + scene + "/live") {}

  /// `write` makes the body of a message with the builder.
  template <typename Write>
  const fbs::Message& ask(fbs::Body type, Write write) {
    flatbuffers::FlatBufferBuilder out;
    const flatbuffers::Offset<void> body = write(out);
    fbs::FinishMessageBuffer(out, fbs::CreateMessage(out, ++last_id_, type, body));
    socket_.send(out.GetBufferPointer(), out.GetSize());
    const fbs::Message& reply = next();
    expect(reply.id() == last_id_, "the reply of another request");
    return reply;
  }

  const fbs::Answer& answer(std::uint32_t view, double angle, std::uint32_t ack) {
    const fbs::Message& reply = ask(fbs::Body::CameraUpdate, [&](auto& out) {
      const fbs::Vec3 eye(200.0 * std::cos(angle), 60.0, 200.0 * std::sin(angle));
      const fbs::Vec3 target(0, 0, 0);
      const fbs::Vec3 up(0, 1, 0);
      const auto look = fbs::CreateLookAt(out, &eye, &target, &up, 1.0, 1.5, 0.1, 0.0);
      const auto camera = fbs::CreateCamera(out, look, 0, 0, 900, 600);
      return fbs::CreateCameraUpdate(out, view, camera, 0, ack).Union();
    });
    expect(reply.body_as_Answer() != nullptr, "no answer");
    const fbs::Answer& answer = *reply.body_as_Answer();
    expect(answer.baseline() == 0 || frames_.count(answer.baseline()) == 1, "no such baseline");
    Ids ids = decoded(answer, answer.baseline() != 0 ? frames_[answer.baseline()] : Ids{});
    expect(ids.size() == answer.object_count(), "object_count is of another set");
    expect(hashOf(ids) == answer.set_hash(), "set_hash is of another set");
    changes_ += answer.baseline() != 0 ? 1 : 0;
    frames_[answer.frame()] = std::move(ids);
    return answer;
  }

  fbs::WireCode errorOf(const fbs::Message& reply) const {
    return reply.body_as_ErrorReply() != nullptr ? reply.body_as_ErrorReply()->code()
                                                 : fbs::WireCode::None;
  }

  void greet(const std::string& scene) {
    const auto hello = [](auto& out) {
      return fbs::CreateHelloDirect(out, 1, 1, "libwebsockets").Union();
    };
    const fbs::Welcome* welcome = ask(fbs::Body::Hello, hello).body_as_Welcome();
    expect(welcome != nullptr && welcome->protocol() == 1, "not welcome");
    expect(welcome->scene()->name()->str() == scene, "another scene");
    const auto open = [](auto& out) { return fbs::CreateOpenViewDirect(out, 7).Union(); };
    const fbs::ViewOpened* opened = ask(fbs::Body::OpenView, open).body_as_ViewOpened();
    expect(opened != nullptr && opened->view() == 7, "no view");
  }

  /// Round the scene; each set as a change and whole.
  void fly() {
    std::uint32_t ack = 0;
    std::size_t most = 0;
    for (int i = 0; i < 40; ++i) {
      const std::uint32_t changed = answer(7, 0.05 * i, ack).frame();
      const std::uint32_t whole = answer(7, 0.05 * i, 0).frame();
      expect(frames_[changed] == frames_[whole], "the change is of another set than the whole");
      most = std::max(most, frames_[whole].size());
      ack = whole;
    }
    expect(changes_ >= 20, "hardly any change was sent as one");
    expect(most > 0, "nothing was ever seen");
  }

  void edit() {
    const std::uint32_t before = answer(7, 0.5, 0).frame();
    expect(!frames_[before].empty(), "nothing to hide");
    const std::uint32_t hidden = *frames_[before].begin();
    const auto hide = [hidden](auto& out) {
      const std::vector items = {fbs::CreateEditItem(out, fbs::EditKind::Hide, hidden)};
      return fbs::CreateEditDirect(out, 0, &items).Union();
    };
    const fbs::Edited* edited = ask(fbs::Body::Edit, hide).body_as_Edited();
    expect(edited != nullptr, "not edited");
    const std::uint64_t version = edited->scene_version();
    const fbs::Answer& after = answer(7, 0.5, before);
    expect(after.scene_version() >= version, "an answer of the scene before the edit");
    Ids without = frames_[before];
    without.erase(hidden);
    expect(frames_[after.frame()] == without, "hidden, and more or less than that");
  }

  void errors() {
    const auto close = [](auto& out) { return fbs::CreateCloseView(out, 3).Union(); };
    expect(errorOf(ask(fbs::Body::CloseView, close)) == fbs::WireCode::UnknownView,
           "no UnknownView");
    const auto nothing = [](auto& out) { return fbs::CreateEdit(out).Union(); };
    expect(errorOf(ask(fbs::Body::Edit, nothing)) == fbs::WireCode::InvalidEdit, "no InvalidEdit");
    const auto open = [](auto& out) { return fbs::CreateOpenViewDirect(out, 8, "magic").Union(); };
    expect(errorOf(ask(fbs::Body::OpenView, open)) == fbs::WireCode::UnknownMethod,
           "no UnknownMethod");
    const auto ping = [](auto& out) { return fbs::CreatePing(out, 99).Union(); };
    const fbs::Pong* pong = ask(fbs::Body::Ping, ping).body_as_Pong();
    expect(pong != nullptr && pong->time_ns() == 99, "no Pong");
  }

  /// Until the server has gone.
  void leave() {
    bool told = false;
    for (Bytes bytes = socket_.receive(); !bytes.empty(); bytes = socket_.receive()) {
      told = told || fbs::GetMessage(bytes.data())->body_as_GoAway() != nullptr;
    }
    expect(told, "the server went without a word");
    expect(socket_.closeCode() == 1001, "closed with another code than 1001");
  }

 private:
  /// Skips what comes unasked.
  const fbs::Message& next() {
    do {
      reply_ = socket_.receive();
      flatbuffers::Verifier verifier(reply_.data(), reply_.size());
      expect(!reply_.empty() && fbs::VerifyMessageBuffer(verifier),
             "no message, or a malformed one");
    } while (fbs::GetMessage(reply_.data())->id() == 0);
    return *fbs::GetMessage(reply_.data());
  }

  Socket socket_;
  Bytes reply_;
  std::uint64_t last_id_ = 0;
  int changes_ = 0;
  std::map<std::uint32_t, Ids> frames_;
};

}  // namespace

int main(int count, char** arguments) {
  expect(count == 3, "usage: lws_client PORT SCENE");
  ::alarm(120);  // whatever hangs ends here
  Client client(std::atoi(arguments[1]), arguments[2]);
  client.greet(arguments[2]);
  client.fly();
  client.edit();
  client.errors();
  std::puts("waits");
  std::fflush(stdout);
  client.leave();
  std::puts("fine");
  return 0;
}
