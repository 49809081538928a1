// What a test and the disk_faults library in the daemon share, in a mapped file.
#pragma once
#include <atomic>
#include <cstdint>

namespace culld::testing {

struct DiskFaults {
  std::atomic<std::uint64_t> calls;    ///< counted since the last reset
  std::atomic<std::uint64_t> fail_at;  ///< the call that fails; 0: none
  std::atomic<std::uint32_t> lasting;  ///< 1: all that follow fail too
  std::atomic<std::uint32_t> error;    ///< errno
  std::atomic<std::uint64_t> failed;   ///< so many did
  /// Changes to the folder that no sync has covered yet; the marks of edit stores not counted.
  std::atomic<std::uint64_t> unsynced;
};

}  // namespace culld::testing
