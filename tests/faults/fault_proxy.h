// A network that misbehaves, between a client and a server on loopback: it delays, splits, cuts and
// half-closes connections, and lets later ones overtake earlier ones. A seed decides what it does.
#pragma once
#include <cstdint>
#include <memory>

namespace culld::testing {

/// Probabilities are per connection and direction.
struct FaultMix {
  double reset = 0.3;        ///< cut within its first bytes, unsent bytes lost
  double half_close = 0.15;  ///< that direction ends, the other goes on
  double split = 0.4;        ///< forwarded in pieces of 1 to 50 bytes
  double delay = 0.4;        ///< each piece waits up to 0.4 ms
  double late_dial = 0.5;    ///< the server sees the connection up to 30 ms later
  std::uint32_t fault_within_bytes = 6'000;
};

struct FaultCounts {
  std::uint64_t connections = 0, resets = 0, half_closes = 0, split = 0, delayed = 0, late = 0;
};

/// Forwards its own port to `target_port`, both on 127.0.0.1. Ends all connections when destroyed.
class FaultProxy {
 public:
  FaultProxy(std::uint16_t target_port, std::uint64_t seed, const FaultMix& mix = {});
  ~FaultProxy();
  FaultProxy(const FaultProxy&) = delete;
  FaultProxy& operator=(const FaultProxy&) = delete;

  std::uint16_t port() const noexcept;
  /// Stops; then the counts are final.
  FaultCounts stop();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace culld::testing
