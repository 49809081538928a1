// The backend that CULLD_TEST_BACKEND names, opened once per test program, with a table into which
// faults can be put. ctest runs such programs once for each way to a context.
#pragma once
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <string>

#include "culling/gpu/backend.h"

namespace culld::gpu {

/// What the next question for the context's health is answered.
struct Faults {
  static inline std::atomic<bool> reset{false};
  static inline std::atomic<bool> out_of_memory{false};
};

inline void putFaultsIn(GlTable& gl) {
  static std::atomic<decltype(GlTable::GetGraphicsResetStatus)> real_status;
  static std::atomic<decltype(GlTable::GetError)> real_error;
  real_status = gl.GetGraphicsResetStatus;
  real_error = gl.GetError;
  gl.GetGraphicsResetStatus = []() -> unsigned {
    constexpr unsigned kInnocentContextReset = 0x8254;
    return Faults::reset.exchange(false) ? kInnocentContextReset : real_status.load()();
  };
  gl.GetError = []() -> unsigned {
    constexpr unsigned kOutOfMemory = 0x0505;
    return Faults::out_of_memory.exchange(false) ? kOutOfMemory : real_error.load()();
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
