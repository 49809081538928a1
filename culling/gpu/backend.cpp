#include "culling/gpu/backend.h"

#include <GL/glcorearb.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <functional>
#include <memory>
#include <thread>
#include <utility>

#include "culling/gpu/child_probe.h"
#include "culling/gpu/self_test.h"
#include "culling/gpu/unavailable.h"

namespace culld::gpu {
namespace {

using Kind = BackendChoice::Kind;

struct Attempt {
  std::string name;
  std::function<Result<std::shared_ptr<Platform>>()> open;
};

struct Opened {
  std::unique_ptr<Backend> backend;
  std::string why_not = "no backend was asked for";
};

/// Never destroyed: at the end of the process the driver's own exit handlers may have run.
Opened& opened() {
  static auto& state = *new Opened;
  return state;
}

/// Before Mesa reads it. What the user has set stays.
void setEnvironment() {
  constexpr int kKeep = 0;
  // Requests run beside each other, so a renderer's own threads would only be in the way.
  ::setenv("LP_NUM_THREADS", "0", kKeep);
  if (std::getenv("MESA_SHADER_CACHE_DIR") == nullptr) {
    ::setenv("MESA_SHADER_CACHE_DISABLE", "true", kKeep);  // a daemon writes to no home
  }
  ::setenv("EGL_LOG_LEVEL", "fatal", kKeep);
}

Attempt deviceAttempt(const EglDevice& device) {
  const std::uint32_t index = device.index;
  std::string name = "egl-device:" + std::to_string(index);
  return {std::move(name), [index] { return openEglDevice(index); }};
}

/// Asked in a child first: to list its devices, EGL loads the drivers.
Result<std::vector<EglDevice>> devicesTriedInChild(std::chrono::milliseconds limit) {
  const auto probed = tryInChild(
      [&]() -> Result<void> {
        const auto devices = eglDevices();
        if (!devices) return devices.error();
        return Done{};
      },
      limit);
  if (!probed) return probed.error();
  return eglDevices();
}

/// Hardware first. `refused`: what is not even tried, and why.
std::vector<Attempt> deviceAttempts(const BackendChoice& choice, std::chrono::milliseconds limit,
                                    std::string& refused) {
  const auto devices = devicesTriedInChild(limit);
  if (!devices) {
    refused = "egl-device: " + devices.error().message;
    return {};
  }
  std::vector<EglDevice> sorted = devices.value();
  std::stable_partition(sorted.begin(), sorted.end(),
                        [](const EglDevice& device) { return !device.software; });
  std::vector<Attempt> attempts;
  for (const EglDevice& device : sorted) {
    if (choice.device.has_value() && *choice.device != device.index) continue;
    if (device.software && choice.kind == Kind::kAuto) {
      refused += (refused.empty() ? "" : "; ") + ("egl-device:" + std::to_string(device.index)) +
                 ": renders in software";
      continue;
    }
    attempts.push_back(deviceAttempt(device));
  }
  if (attempts.empty() && refused.empty()) {
    refused = "egl-device: none of the " + std::to_string(sorted.size()) + " EGL devices is meant";
  }
  return attempts;
}

std::vector<Attempt> attemptsFor(const BackendChoice& choice, std::chrono::milliseconds limit,
                                 std::string& refused) {
  switch (choice.kind) {
    case Kind::kAuto:
      if (!anyGpuDeviceFile()) {
        refused = "egl-device: no GPU has a device file in /dev";
        return {};
      }
      return deviceAttempts(choice, limit, refused);
    case Kind::kEglDevice:
      return deviceAttempts(choice, limit, refused);
    case Kind::kEglSurfaceless:
      return {{"egl-surfaceless", openEglSurfaceless}};
    case Kind::kOsMesa:
      return {{"osmesa", openOsMesa}};
    case Kind::kCpu:
      break;
  }
  refused = "the backend is cpu";
  return {};
}

Result<std::unique_ptr<Backend>> backendOf(const Attempt& attempt, ContextPool::Adjust adjust) {
  auto platform = attempt.open();
  if (!platform) return platform.error();
  auto made =
      std::make_unique<Backend>(attempt.name, std::move(platform).value(), std::move(adjust));
  if (auto described = made->describe(); !described) return described.error();
  return made;
}

Result<std::unique_ptr<Backend>> tryOne(const Attempt& attempt, const BackendOptions& options) {
  const auto probed = tryInChild(
      [&]() -> Result<void> {
        const auto made = backendOf(attempt, options.adjust);
        if (!made) return made.error();
        return Done{};
      },
      options.probe_limit);
  if (!probed) return probed.error();
  return backendOf(attempt, options.adjust);
}

}  // namespace

Result<BackendChoice> backendNamed(const std::string& name) {
  if (name == "auto") return BackendChoice{Kind::kAuto, {}};
  if (name == "cpu") return BackendChoice{Kind::kCpu, {}};
  if (name == "egl-device") return BackendChoice{Kind::kEglDevice, {}};
  if (name == "egl-surfaceless") return BackendChoice{Kind::kEglSurfaceless, {}};
  if (name == "osmesa") return BackendChoice{Kind::kOsMesa, {}};
  constexpr std::string_view kDevice = "egl-device:";
  if (name.starts_with(kDevice)) {
    std::uint32_t index = 0;
    const char* end = name.data() + name.size();
    const auto [rest, error] = std::from_chars(name.data() + kDevice.size(), end, index);
    if (error == std::errc{} && rest == end) return BackendChoice{Kind::kEglDevice, index};
  }
  return invalidInput("is none of auto, cpu, egl-device[:n], egl-surfaceless, osmesa");
}

Result<void> openBackend(const BackendChoice& choice, const BackendOptions& options) {
  if (choice.kind == Kind::kCpu) {
    opened().why_not = "the backend is cpu";
    return Done{};
  }
  std::string failures;
  setEnvironment();
  const std::vector<Attempt> attempts = attemptsFor(choice, options.probe_limit, failures);
  for (const Attempt& attempt : attempts) {
    auto made = tryOne(attempt, options);
    if (made) {
      opened() = {std::move(made).value(), {}};
      return Done{};
    }
    failures += (failures.empty() ? "" : "; ") + attempt.name + ": " + made.error().message;
  }
  opened().why_not = "no OpenGL backend: " + failures;
  if (choice.kind == Kind::kAuto) return Done{};
  return unavailable(opened().why_not);
}

Backend::Backend(std::string name, std::shared_ptr<Platform> platform, ContextPool::Adjust adjust)
    : name_(std::move(name)),
      pool_(std::move(platform), std::max(1U, std::thread::hardware_concurrency()),
            std::move(adjust)) {}

Result<void> Backend::describe() {
  auto lease = acquire();
  if (!lease) return lease.error();
  const GlTable& gl = lease.value().gl();
  const unsigned char* renderer = gl.GetString(GL_RENDERER);
  if (renderer != nullptr) renderer_ = reinterpret_cast<const char*>(renderer);
  std::int64_t most = 0;
  gl.GetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &most);
  most_buffer_bytes_ = static_cast<std::size_t>(std::max<std::int64_t>(most, 0));
  if (auto tested = testArithmetic(gl); !tested) return tested;
  if (auto tested = testDepthPass(lease.value().data<DepthPass>()); !tested) return tested;
  return lease.value().check();
}

Backend* backend() noexcept { return opened().backend.get(); }

const std::string& whyNoBackend() noexcept { return opened().why_not; }

}  // namespace culld::gpu
