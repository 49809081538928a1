// XXH3 over bytes in pieces: tells damage by disks, cables and people apart from what was written.
// It is no signature: who can write to the folder can make a matching one.
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

namespace culld::server {

struct Digest {
  std::uint64_t low = 0, high = 0;
  bool operator==(const Digest&) const = default;
};

class Checksum {
 public:
  Checksum();
  Checksum(Checksum&& other) noexcept;
  ~Checksum();
  void add(std::span<const std::byte> bytes);
  Digest digest() const;  ///< of all that was added

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// 64 bits of the same, at once.
std::uint64_t checksumOf(std::span<const std::byte> bytes) noexcept;

}  // namespace culld::server
