#include "tests/integration/raw_client.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cstring>
#include <utility>

#include "protocol/codec.h"

namespace culld::testing {
namespace {

constexpr timeval kPatience{10, 0};

int connectedOrClosed(int fd, const sockaddr* address, socklen_t size) {
  ::setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &kPatience, sizeof kPatience);
  ::setsockopt(fd, SOL_SOCKET, SO_SNDTIMEO, &kPatience, sizeof kPatience);
  if (::connect(fd, address, size) == 0) return fd;
  ::close(fd);
  return -1;
}

std::string bytes(const std::vector<std::uint8_t>& v) { return {v.begin(), v.end()}; }

unsigned byteAt(const std::string& s, std::size_t i) { return static_cast<unsigned char>(s[i]); }

}  // namespace

RawSocket RawSocket::tcp(std::uint16_t port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const int fd = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const int on = 1;
  ::setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  return RawSocket(
      connectedOrClosed(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address));
}

RawSocket RawSocket::unixDomain(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path.copy(address.sun_path, sizeof address.sun_path - 1);
  const int fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  return RawSocket(
      connectedOrClosed(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address));
}

RawSocket::RawSocket(RawSocket&& other) noexcept
    : fd_(std::exchange(other.fd_, -1)),
      ended_(other.ended_),
      bytewise_(other.bytewise_),
      buffer_(std::move(other.buffer_)) {}

RawSocket::~RawSocket() {
  if (fd_ >= 0) ::close(fd_);
}

bool RawSocket::send(std::string_view data) {
  while (!data.empty()) {
    const ssize_t n = ::send(fd_, data.data(), bytewise_ ? 1 : data.size(), MSG_NOSIGNAL);
    if (n <= 0) return false;
    data.remove_prefix(static_cast<std::size_t>(n));
  }
  return true;
}

bool RawSocket::fill() {
  std::array<char, 65536> part{};
  ssize_t n = 0;
  do {
    n = ::recv(fd_, part.data(), part.size(), 0);
  } while (n < 0 && errno == EINTR);  // a fuzzer's clock, say
  if (n <= 0) {
    ended_ = n == 0 || errno == ECONNRESET;
    return false;
  }
  buffer_.append(part.data(), static_cast<std::size_t>(n));
  return true;
}

std::optional<std::string> RawSocket::readExactly(std::size_t count) {
  while (buffer_.size() < count) {
    if (!fill()) return std::nullopt;
  }
  std::string out = buffer_.substr(0, count);
  buffer_.erase(0, count);
  return out;
}

std::optional<std::string> RawSocket::readUntil(std::string_view mark) {
  std::size_t at = 0;
  while ((at = buffer_.find(mark)) == std::string::npos) {
    if (!fill()) return std::nullopt;
  }
  return readExactly(at + mark.size());
}

std::optional<std::string> RawSocket::readToEnd() {
  while (fill()) {
  }
  if (!ended_) return std::nullopt;
  return std::exchange(buffer_, {});
}

void RawSocket::setPatience(std::chrono::milliseconds limit) {
  const timeval patience{limit.count() / 1000, limit.count() % 1000 * 1000};
  ::setsockopt(fd_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  ::setsockopt(fd_, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
}

void RawSocket::shutdownWrite() { ::shutdown(fd_, SHUT_WR); }

HttpAnswer readAnswer(RawSocket& socket, bool has_body) {
  const auto header = socket.readUntil("\r\n\r\n");
  if (!header || header->size() < 12) return {};
  HttpAnswer answer{std::stoi(header->substr(9, 3)), *header, ""};
  const auto length = header->find("Content-Length: ");
  if (has_body && length != std::string::npos) {
    answer.body = socket.readExactly(std::stoul(header->substr(length + 16))).value_or("");
  }
  return answer;
}

HttpAnswer request(std::uint16_t port, const std::string& method, const std::string& path,
                   std::string_view body) {
  RawSocket socket = RawSocket::tcp(port);
  std::string head = method + " " + path + " HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n";
  if (method == "PUT") head += "Content-Length: " + std::to_string(body.size()) + "\r\n";
  if (!socket.send(head + "\r\n")) return {};
  socket.send(body);
  return readAnswer(socket, method != "HEAD");
}

unsigned Frame::closeCode() const {
  return payload.size() < 2 ? 0 : byteAt(payload, 0) << 8 | byteAt(payload, 1);
}

LiveClient::LiveClient(RawSocket socket, const std::string& scene, const std::string& subprotocol)
    : socket_(std::move(socket)) {
  std::string head = "GET /v1/scenes/" + scene +
                     "/live HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\n"
                     "Connection: Upgrade\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
                     "Sec-WebSocket-Version: 13\r\n";
  if (!subprotocol.empty()) head += "Sec-WebSocket-Protocol: " + subprotocol + "\r\n";
  if (!socket_.send(head + "\r\n")) return;
  header_ = socket_.readUntil("\r\n\r\n").value_or("");
  if (header_.size() >= 12) status_ = std::stoi(header_.substr(9, 3));
}

bool LiveClient::send(protocol::Body body, std::uint64_t id) {
  return sendFrame(2, bytes(protocol::encode({id, std::move(body)})));
}

bool LiveClient::sendFrame(unsigned opcode, std::string_view payload, bool final, bool masked) {
  std::string frame;
  frame += static_cast<char>((final ? 0x80U : 0U) | opcode);
  const unsigned mask_bit = masked ? 0x80U : 0U;
  if (payload.size() < 126) {
    frame += static_cast<char>(mask_bit | static_cast<unsigned>(payload.size()));
  } else {
    const bool wide = payload.size() > 0xFFFF;
    frame += static_cast<char>(mask_bit | (wide ? 127U : 126U));
    for (int shift = wide ? 56 : 8; shift >= 0; shift -= 8) {
      frame += static_cast<char>(payload.size() >> shift & 0xFFU);
    }
  }
  constexpr std::array<unsigned, 4> kMask = {0x12, 0x34, 0x56, 0x78};
  if (masked) {
    for (const unsigned m : kMask) frame += static_cast<char>(m);
  }
  for (std::size_t i = 0; i < payload.size(); ++i) {
    const auto plain = static_cast<unsigned char>(payload[i]);
    frame += static_cast<char>(masked ? plain ^ kMask[i % 4] : plain);
  }
  return socket_.send(frame);
}

std::optional<Frame> LiveClient::receiveFrame() {
  for (;;) {
    const auto start = socket_.readExactly(2);
    if (!start) return std::nullopt;
    std::size_t length = byteAt(*start, 1);
    EXPECT_LT(length, 128U) << "a server does not mask";
    if (length >= 126) {
      const auto more = socket_.readExactly(length == 126 ? 2 : 8);
      if (!more) return std::nullopt;
      length = 0;
      for (std::size_t i = 0; i < more->size(); ++i) length = length << 8 | byteAt(*more, i);
    }
    const auto payload = socket_.readExactly(length);
    if (!payload) return std::nullopt;
    EXPECT_EQ(byteAt(*start, 0) & 0xF0U, 0x80U) << "one frame per message, no reserved bits";
    Frame frame{byteAt(*start, 0) & 0x0FU, *payload};
    if (frame.opcode != 9) return frame;
    sendFrame(10, frame.payload);
  }
}

std::optional<protocol::Message> LiveClient::receive() {
  const auto frame = receiveFrame();
  if (!frame || frame->opcode != 2) return std::nullopt;
  const std::vector<std::uint8_t> data(frame->payload.begin(), frame->payload.end());
  auto message = protocol::decode(data, protocol::kMaxReplyBytes);
  EXPECT_TRUE(message.ok());
  if (!message) return std::nullopt;
  return std::move(message).value();
}

std::optional<protocol::Welcome> LiveClient::hello() {
  send(protocol::Hello{1, 1, "raw"});
  return await<protocol::Welcome>();
}

bool LiveClient::openView(std::uint32_t view, const std::string& method) {
  send(protocol::OpenView{view, method, false});
  return await<protocol::ViewOpened>().has_value();
}

}  // namespace culld::testing
