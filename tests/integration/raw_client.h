// HTTP and WebSocket written byte by byte on a blocking socket: the server is judged by a client
// that shares no code with it, and can be as rude as a test needs. Every wait ends after ten
// seconds.
#pragma once
#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/messages.h"

namespace culld::testing {

class RawSocket {
 public:
  static RawSocket tcp(std::uint16_t port);
  static RawSocket unixDomain(const std::string& path);
  RawSocket(RawSocket&& other) noexcept;
  RawSocket& operator=(RawSocket&&) = delete;
  ~RawSocket();

  bool connected() const noexcept { return fd_ >= 0; }
  /// False when the peer is gone.
  bool send(std::string_view bytes);
  /// Exactly that many bytes; none when the peer closed or time ran out.
  std::optional<std::string> readExactly(std::size_t count);
  /// Up to and with `mark`.
  std::optional<std::string> readUntil(std::string_view mark);
  /// All until the peer closes; none when it did not in time.
  std::optional<std::string> readToEnd();
  void shutdownWrite();
  /// Waits are over after this long instead.
  void setPatience(std::chrono::milliseconds limit);
  /// From now on every byte is sent by itself.
  void sendBytewise() noexcept { bytewise_ = true; }

 private:
  explicit RawSocket(int fd) : fd_(fd) {}
  bool fill();

  int fd_ = -1;
  bool ended_ = false;
  bool bytewise_ = false;
  std::string buffer_;
};

struct HttpAnswer {
  int status = 0;  ///< 0: none came
  std::string header;
  std::string body;
};

/// Reads one reply with Content-Length, or none (204, HEAD).
HttpAnswer readAnswer(RawSocket& socket, bool has_body = true);
/// One request on a connection of its own.
HttpAnswer request(std::uint16_t port, const std::string& method, const std::string& path,
                   std::string_view body = {});

struct Frame {
  unsigned opcode = 0;  ///< RFC 6455 §5.2: 1 text, 2 binary, 8 close, 9 ping, 10 pong
  std::string payload;
  /// Of a close frame.
  unsigned closeCode() const;
};

/// A WebSocket that speaks culld's messages, and anything else when told.
class LiveClient {
 public:
  /// Upgrades; see upgradeStatus() when it was refused.
  LiveClient(RawSocket socket, const std::string& scene,
             const std::string& subprotocol = "culld.v1");

  int upgradeStatus() const noexcept { return status_; }
  const std::string& upgradeHeader() const noexcept { return header_; }

  bool send(protocol::Body body, std::uint64_t id = 1);
  bool sendFrame(unsigned opcode, std::string_view payload, bool final = true, bool masked = true);
  /// The next frame, pings answered and skipped; none when the connection ended.
  std::optional<Frame> receiveFrame();
  /// The next message; fails the test when what comes is none.
  std::optional<protocol::Message> receive();
  /// Skips what is not a T.
  template <typename T>
  std::optional<T> await(std::uint64_t* id = nullptr) {
    while (auto message = receive()) {
      if (id != nullptr) *id = message->id;
      if (T* body = std::get_if<T>(&message->body)) return std::move(*body);
    }
    return std::nullopt;
  }
  /// Hello and Welcome.
  std::optional<protocol::Welcome> hello();
  /// Opens a view and waits until it is open.
  bool openView(std::uint32_t view, const std::string& method = "");
  RawSocket& socket() noexcept { return socket_; }

 private:
  RawSocket socket_;
  int status_ = 0;
  std::string header_;
};

}  // namespace culld::testing
