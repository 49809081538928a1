// The one OpenGL backend of this process, or why there is none. Programs choose it when they
// start; methods that need a GPU ask for it here (docs/gpu.md).
#pragma once
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "culling/core/result.h"
#include "culling/gpu/context_pool.h"

namespace culld::gpu {

struct BackendChoice {
  enum class Kind : std::uint8_t { kAuto, kCpu, kEglDevice, kEglSurfaceless, kOsMesa };
  Kind kind = Kind::kAuto;
  std::optional<std::uint32_t> device;  ///< with kEglDevice: only that one
};

/// "auto", "cpu", "egl-device", "egl-device:1", "egl-surfaceless", "osmesa".
/// ERROR: kInvalidInput: none of these.
Result<BackendChoice> backendNamed(const std::string& name);

struct BackendOptions {
  std::chrono::milliseconds probe_limit{20'000};
  ContextPool::Adjust adjust;  ///< of tests
};

/// Opens what was chosen, tried in a child process first, and keeps it for the process. `auto`
/// takes the first hardware device that works and is content without; kCpu touches nothing.
/// GUARANTEES: without GPU device files `auto` costs microseconds and loads nothing.
/// ERROR: kUnavailable, one line: every attempt and why it failed. REQUIRES: no other threads yet,
/// as it sets the environment and forks.
Result<void> openBackend(const BackendChoice& choice, const BackendOptions& options = {});

class Backend {
 public:
  Backend(std::string name, std::shared_ptr<Platform> platform, ContextPool::Adjust adjust);
  const std::string& name() const noexcept { return name_; }  ///< "egl-device:0"
  /// What OpenGL calls itself. Empty until describe().
  const std::string& renderer() const noexcept { return renderer_; }
  /// Largest array that a shader may see, bytes.
  std::size_t mostBufferBytes() const noexcept { return most_buffer_bytes_; }
  Result<ContextPool::Lease> acquire() { return pool_.acquire(); }

  /// Makes a first context, asks what it is and whether it computes as culling needs it
  /// (self_test.h). ERROR: kUnavailable.
  Result<void> describe();

 private:
  std::string name_, renderer_;
  std::size_t most_buffer_bytes_ = 0;
  ContextPool pool_;
};

/// nullptr if there is none. Lives as long as the process. THREADS: any, after openBackend().
Backend* backend() noexcept;
/// One line: why backend() is nullptr.
const std::string& whyNoBackend() noexcept;

}  // namespace culld::gpu
