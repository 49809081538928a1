// Bounds on everything that a client controls (docs/protocol.md "Limits"). Each has a test that
// goes past it.
#pragma once
#include <chrono>
#include <cstddef>
#include <cstdint>

#include "protocol/limits.h"

namespace culld::server {

struct SessionLimits {
  std::size_t max_message_bytes = protocol::kMaxRequestBytes;
  std::uint32_t max_views = protocol::kMaxViews;
  std::uint32_t max_edits_per_request = protocol::kMaxEdits;
  std::uint32_t max_waiting_edits = 16;  ///< Edit messages of one client not yet answered
  /// Cameras that wait or are culled, those of closed views too, and edits.
  std::uint32_t max_requests_in_flight = 192;
  std::uint32_t max_messages_per_s = 20'000;  ///< 0: any; past it a session is read from later
  std::size_t kept_frames = 16;               ///< baselines per view
  std::size_t kept_ids = 4'000'000;  ///< over the baselines of a view; the newest always stays
  std::chrono::milliseconds hello_timeout{5000};
  std::chrono::milliseconds idle_timeout{60'000};
};

struct ServerLimits {
  SessionLimits session;
  std::size_t max_connections = 1024;
  /// TCP: an IPv4 address, or the first 64 bits of an IPv6 one; 0: any number.
  std::size_t max_connections_per_address = 256;
  std::size_t max_scenes = 1024;
  std::uint64_t max_upload_bytes = std::uint64_t{4} << 30;
  std::uint32_t max_header_bytes = 8192;
  std::uint64_t min_upload_bytes_per_s = 10'000;
  std::chrono::milliseconds header_timeout{5000};   ///< also between requests of a connection
  std::chrono::milliseconds body_timeout{10'000};   ///< for each part of a body
  std::chrono::milliseconds write_timeout{30'000};  ///< for one HTTP reply, or live message
  std::chrono::milliseconds drain_timeout{5000};
  std::size_t queued_bytes = std::size_t{1} << 20;  ///< past it a session is not read from
  std::size_t queued_messages = 256;                ///< the same
  /// Over all sessions: past it those that have messages queued are not read from.
  std::size_t total_queued_bytes = std::size_t{256} << 20;
};

}  // namespace culld::server
