// The log lines of one live session: opened, what it edited, what was refused, closed.
#pragma once
#include <boost/asio/steady_timer.hpp>
#include <cstdint>
#include <memory>
#include <string>

#include "protocol/messages.h"
#include "server/connections.h"

namespace culld::server {

/// THREADS: the I/O thread.
class SessionLog : public std::enable_shared_from_this<SessionLog> {
 public:
  /// `peer`: see peerName().
  SessionLog(std::string peer, std::string scene, StreamSocket::executor_type executor,
             Context& context);

  void opened();
  void received(std::size_t bytes) { received_bytes_ += bytes; }
  void answered(std::size_t bytes);
  void refused(protocol::WireCode code);
  /// Edits within a second are one line.
  void edited();
  /// The first time only. `why` in words.
  void closed(const std::string& why);

 private:
  void tellEdits();

  Context& context_;
  const std::uint64_t number_;
  const std::string scene_;
  const std::string peer_;
  boost::asio::steady_timer burst_;
  std::chrono::nanoseconds opened_{0};
  std::uint64_t received_bytes_ = 0;
  std::uint64_t answers_ = 0;
  std::uint64_t answer_bytes_ = 0;
  std::uint64_t refusals_ = 0;
  std::uint64_t edits_ = 0;
  std::uint64_t untold_edits_ = 0;
  bool open_ = false;
};

}  // namespace culld::server
