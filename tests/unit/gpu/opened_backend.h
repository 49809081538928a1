// The backend that CULLD_TEST_BACKEND names, opened once per test program, with a table into which
// faults can be put. ctest runs such programs once for each way to a context.
#pragma once
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <mutex>
#include <new>
#include <string>

#include "culling/gpu/backend.h"

namespace culld::gpu {

/// Each strikes once.
struct Faults {
  static inline std::atomic<bool> reset{false};          ///< the context says so when asked
  static inline std::atomic<bool> out_of_memory{false};  ///< the same
  static inline std::atomic<bool> no_buffer{false};      ///< the next array is not made
  static inline std::atomic<bool> no_shader{false};      ///< the next one does not compile
  static inline std::atomic<bool> exception{false};      ///< from the next upload
};

/// Since somebody last set it to 0.
struct Seen {
  static inline std::atomic<int> dispatches{0}, most_outlines_drawn{0};
};

/// The driver's own functions: the same for every context.
inline GlTable& realTable() {
  static GlTable table;
  return table;
}

inline void putHealthFaultsIn(GlTable& gl) {
  gl.GetGraphicsResetStatus = []() -> unsigned {
    constexpr unsigned kInnocentContextReset = 0x8254;
    return Faults::reset.exchange(false) ? kInnocentContextReset
                                         : realTable().GetGraphicsResetStatus();
  };
  gl.GetError = []() -> unsigned {
    constexpr unsigned kOutOfMemory = 0x0505;
    return Faults::out_of_memory.exchange(false) ? kOutOfMemory : realTable().GetError();
  };
}

inline void putFaultsIn(GlTable& gl) {
  static std::once_flag once;
  std::call_once(once, [&] { realTable() = gl; });
  putHealthFaultsIn(gl);
  gl.NamedBufferData = [](unsigned buffer, std::ptrdiff_t size, const void* data, unsigned usage) {
    if (Faults::no_buffer.exchange(false)) {
      Faults::out_of_memory = true;
    } else {
      realTable().NamedBufferData(buffer, size, data, usage);
    }
  };
  gl.NamedBufferSubData = [](unsigned buffer, std::ptrdiff_t at, std::ptrdiff_t size,
                             const void* data) {
    if (Faults::exception.exchange(false)) throw std::bad_alloc();
    realTable().NamedBufferSubData(buffer, at, size, data);
  };
  gl.GetShaderiv = [](unsigned shader, unsigned what, int* value) {
    realTable().GetShaderiv(shader, what, value);
    if (Faults::no_shader.exchange(false)) *value = 0;
  };
  gl.DispatchCompute = [](unsigned x, unsigned y, unsigned z) {
    ++Seen::dispatches;
    realTable().DispatchCompute(x, y, z);
  };
  gl.DrawArraysInstanced = [](unsigned mode, int first, int count, int instances) {
    int most = Seen::most_outlines_drawn;
    while (most < instances && !Seen::most_outlines_drawn.compare_exchange_weak(most, instances)) {
    }
    realTable().DrawArraysInstanced(mode, first, count, instances);
  };
}

/// Opens it on first use. Empty if that went well, else why not.
inline const std::string& whyNotOpened() {
  static const std::string why = []() -> std::string {
    const char* name = std::getenv("CULLD_TEST_BACKEND");
    if (name == nullptr) return "CULLD_TEST_BACKEND is not set";
    BackendOptions options;
    options.adjust = putFaultsIn;
    const auto choice = backendNamed(name);
    if (!choice) return choice.error().message;
    const auto opened = openBackend(choice.value(), options);
    return opened ? std::string() : opened.error().message;
  }();
  return why;
}

/// Skips where the library is not installed, and only there.
class WithBackend : public testing::Test {
 protected:
  void SetUp() override {
    const std::string& why = whyNotOpened();
    if (why.find("cannot open shared object") != std::string::npos) GTEST_SKIP() << why;
    ASSERT_EQ(why, "");
    ASSERT_NE(backend(), nullptr);
  }
};

}  // namespace culld::gpu
