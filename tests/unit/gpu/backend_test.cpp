#include "culling/gpu/backend.h"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

#include "culling/gpu/program.h"
#include "culling/gpu/self_test.h"
#include "tests/unit/gpu/opened_backend.h"

namespace culld::gpu {
namespace {

class BackendTest : public WithBackend {};
class ContextPoolTest : public WithBackend {};
class SelfTest : public WithBackend {};

struct Marks final : ContextData {
  Marks(const GlTable& gl, std::size_t) : buffer(gl) { ++made; }
  Buffer buffer;
  static inline std::atomic<int> made{0};
};

TEST_F(BackendTest, SaysWhatItIs) {
  EXPECT_EQ(backend()->name(), std::getenv("CULLD_TEST_BACKEND"));
  EXPECT_FALSE(backend()->renderer().empty());
  EXPECT_GE(backend()->mostBufferBytes(), std::size_t{1} << 24U);  // OpenGL 4.5 promises that
}

TEST_F(ContextPoolTest, GivesTheSameContextAgain) {
  const int before = Marks::made;
  for (int i = 0; i < 3; ++i) {
    auto lease = backend()->acquire();
    ASSERT_TRUE(lease.ok());
    const float value = 2.0F;
    lease.value().data<Marks>().buffer.upload<float>({&value, 1});
    EXPECT_TRUE(lease.value().check().ok());
  }
  EXPECT_EQ(Marks::made, before + 1);
}

TEST_F(ContextPoolTest, ServesMoreThreadsThanItHasContexts) {
  std::atomic<int> wrong{0};
  std::vector<std::thread> threads;
  for (unsigned t = 0; t < 8; ++t) {
    threads.emplace_back([t, &wrong] {
      for (unsigned i = 0; i < 50; ++i) {
        auto lease = backend()->acquire();
        if (!lease) {
          ++wrong;
          continue;
        }
        const std::vector<unsigned> sent(100, t * 1000 + i);
        Buffer buffer(lease.value().gl());
        buffer.upload<unsigned>(sent);
        std::vector<unsigned> got(sent.size());
        buffer.read(got.data(), got.size() * sizeof(unsigned));
        if (got != sent || !lease.value().check()) ++wrong;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong, 0);
}

TEST_F(ContextPoolTest, TellsWhenMemoryHasRunOut) {
  auto lease = backend()->acquire();
  ASSERT_TRUE(lease.ok());
  Faults::out_of_memory = true;
  const auto failed = lease.value().check();
  ASSERT_FALSE(failed.ok());
  EXPECT_EQ(failed.error().message, "GL_OUT_OF_MEMORY");
}

TEST_F(SelfTest, RefusesWrongArithmetic) {
  auto lease = backend()->acquire();
  ASSERT_TRUE(lease.ok());
  EXPECT_TRUE(testArithmetic(lease.value().gl()).ok());
  static decltype(GlTable::GetNamedBufferSubData) real = nullptr;
  real = lease.value().gl().GetNamedBufferSubData;
  GlTable wrong = lease.value().gl();
  wrong.GetNamedBufferSubData = [](unsigned buffer, std::ptrdiff_t at, std::ptrdiff_t size,
                                   void* data) {
    real(buffer, at, size, data);
    static_cast<unsigned char*>(data)[size / 2] ^= 1U;
  };
  const auto refused = testArithmetic(wrong);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().message, "its shaders do not round as IEEE 754 does");
  EXPECT_TRUE(lease.value().check().ok());
}

TEST_F(SelfTest, RefusesAGpuThatDrawsOrAsksOtherwise) {
  auto lease = backend()->acquire();
  ASSERT_TRUE(lease.ok());
  EXPECT_TRUE(testDepthPass(lease.value().data<DepthPass>()).ok());
  static decltype(GlTable::DispatchCompute) dispatch = nullptr;
  dispatch = lease.value().gl().DispatchCompute;
  GlTable lazy = lease.value().gl();
  lazy.DrawArraysInstanced = [](unsigned, int, int, int) {};
  DepthPass draws_nothing(lazy, 1);
  const auto drawn = testDepthPass(draws_nothing);
  ASSERT_FALSE(drawn.ok());
  EXPECT_EQ(drawn.error().message, "it draws other depths than the CPU");
  lazy = lease.value().gl();
  static int dispatched = 0;
  dispatched = 0;
  lazy.DispatchCompute = [](unsigned x, unsigned y, unsigned z) {
    constexpr int kLevels = 7;  // of the pyramid; then the boxes
    if (++dispatched <= kLevels) dispatch(x, y, z);
  };
  DepthPass asks_nothing(lazy, 1);
  const auto asked = testDepthPass(asks_nothing);
  ASSERT_FALSE(asked.ok());
  EXPECT_EQ(asked.error().message, "it hides other boxes than the CPU");
  EXPECT_TRUE(lease.value().check().ok());
}

TEST_F(SelfTest, QuotesTheCompiler) {
  auto lease = backend()->acquire();
  ASSERT_TRUE(lease.ok());
  const auto program = Program::compute(lease.value().gl(), "#version 450 core\nno shader\n");
  ASSERT_FALSE(program.ok());
  EXPECT_EQ(program.error().message.find("a shader does not compile: "), 0U);
  EXPECT_TRUE(lease.value().check().ok());
}

}  // namespace
}  // namespace culld::gpu
