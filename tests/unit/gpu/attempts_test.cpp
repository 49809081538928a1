// What happens on the way to a backend that is not there. None of this needs OpenGL.
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <chrono>

#include "culling/gpu/backend.h"
#include "culling/gpu/child_probe.h"

namespace culld::gpu {
namespace {

using std::chrono::milliseconds;

TEST(BackendNamed, KnowsEachNameOfTheCommandLine) {
  for (const char* name : {"auto", "cpu", "egl-device", "egl-surfaceless", "osmesa"}) {
    EXPECT_TRUE(backendNamed(name).ok()) << name;
  }
  EXPECT_EQ(backendNamed("egl-device:12").value().device, 12U);
  EXPECT_FALSE(backendNamed("egl-device").value().device.has_value());
  for (const char* name : {"", "gpu", "egl-device:", "egl-device:-1", "egl-device:1x", "OSMESA"}) {
    EXPECT_FALSE(backendNamed(name).ok()) << name;
  }
}

TEST(ChildProbe, PassesOnWhatTheChildFound) {
  EXPECT_TRUE(tryInChild([]() -> Result<void> { return Done{}; }, milliseconds(20'000)).ok());
  const auto failed = tryInChild(
      []() -> Result<void> {
        return Error{ErrorCode::kUnavailable, "eglInitialize failed with 0x3001"};
      },
      milliseconds(20'000));
  ASSERT_FALSE(failed.ok());
  EXPECT_EQ(failed.error().message, "eglInitialize failed with 0x3001");
}

TEST(ChildProbe, SurvivesACrash) {
  const auto crashed = tryInChild(
      []() -> Result<void> {
        ::signal(SIGSEGV, SIG_DFL);  // sanitizers would catch it
        ::raise(SIGSEGV);
        return Done{};
      },
      milliseconds(20'000));
  ASSERT_FALSE(crashed.ok());
  EXPECT_EQ(crashed.error().message, "its probe crashed with signal 11");
}

TEST(ChildProbe, KillsWhatHangs) {
  const auto hung = tryInChild(
      []() -> Result<void> {
        ::pause();
        return Done{};
      },
      milliseconds(100));
  ASSERT_FALSE(hung.ok());
  EXPECT_EQ(hung.error().message, "not done within 100 ms");
}

TEST(ChildProbe, KillsWhatHangsOnItsWayOut) {
  const auto hung = tryInChild(
      []() -> Result<void> {
        constexpr unsigned kFirstFile = 3;
        ::close_range(kFirstFile, ~0U, 0);  // nothing more will be said
        ::pause();
        return Done{};
      },
      milliseconds(100));
  ASSERT_FALSE(hung.ok());
  EXPECT_EQ(hung.error().message, "not done within 100 ms");
}

TEST(ChildProbe, NoticesAnEndWithoutAWord) {
  const auto silent = tryInChild([]() -> Result<void> { ::_exit(3); }, milliseconds(20'000));
  ASSERT_FALSE(silent.ok());
  EXPECT_EQ(silent.error().message, "its probe ended without a word");
}

TEST(OpenBackend, SaysForEachAttemptWhyItFailed) {
  const auto none = openBackend(backendNamed("egl-device:4000").value());
  ASSERT_FALSE(none.ok());
  EXPECT_EQ(none.error().message.find("no OpenGL backend: egl-device: "), 0U)
      << none.error().message;
  EXPECT_EQ(backend(), nullptr);
  EXPECT_EQ(whyNoBackend(), none.error().message);
}

TEST(OpenBackend, OfAutoNeedsNoGpuAndThatOfCpuNothing) {
  EXPECT_TRUE(openBackend(backendNamed("cpu").value()).ok());
  EXPECT_EQ(backend(), nullptr);
  EXPECT_EQ(whyNoBackend(), "the backend is cpu");
  if (anyGpuDeviceFile()) GTEST_SKIP() << "this machine has a GPU";
  EXPECT_TRUE(openBackend(backendNamed("auto").value()).ok());
  EXPECT_EQ(backend(), nullptr);
  EXPECT_EQ(whyNoBackend(), "no OpenGL backend: egl-device: no GPU has a device file in /dev");
}

}  // namespace
}  // namespace culld::gpu
