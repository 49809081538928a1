// Contexts borrowed, lost, replaced, on a platform that is not there: none of this needs OpenGL.
#include "culling/gpu/context_pool.h"

#include <gtest/gtest.h>

#include <new>

#include "culling/gpu/program.h"
#include "culling/gpu/unavailable.h"

namespace culld::gpu {
namespace {

/// What the platform does, and what was seen of its use.
struct Driver {
  bool creates = true, throws = false, makes_current = true;
  unsigned error = 0, reset = 0;
  int tried = 0, living = 0;
  bool current = false;
  int deleted = 0, deleted_without_context = 0;
};
Driver driver;  ///< functions of OpenGL have no other way to it

class FakeContext final : public NativeContext {
 public:
  FakeContext() { ++driver.living; }
  FakeContext(const FakeContext&) = delete;
  FakeContext& operator=(const FakeContext&) = delete;
  ~FakeContext() override { --driver.living; }
  bool makeCurrent() override { return driver.current = driver.makes_current; }
  void release() override { driver.current = false; }
};

class FakePlatform final : public Platform {
 public:
  Result<std::unique_ptr<NativeContext>> createContext() override {
    ++driver.tried;
    if (driver.throws) throw std::bad_alloc();
    if (!driver.creates) return unavailable("eglCreateContext failed with 0x3003");
    return std::unique_ptr<NativeContext>(std::make_unique<FakeContext>());
  }
  GlProc (*finder() const)(const char*) override {
    return [](const char*) -> GlProc { return [] {}; };
  }
};

void putFakesIn(GlTable& gl) {
  gl.GetGraphicsResetStatus = [] { return driver.reset; };
  gl.GetError = [] { return std::exchange(driver.error, 0U); };
  gl.CreateBuffers = [](int, unsigned* name) { *name = 1; };
  gl.DeleteBuffers = [](int, const unsigned*) {
    ++driver.deleted;
    driver.deleted_without_context += driver.current ? 0 : 1;
  };
}

struct Holds final : ContextData {
  Holds(const GlTable& gl, std::size_t contexts) : buffer(gl), of_contexts(contexts) { ++living; }
  Holds(const Holds&) = delete;
  Holds& operator=(const Holds&) = delete;
  ~Holds() override { --living; }
  Buffer buffer;
  std::size_t of_contexts;
  bool used = false;
  static inline int living = 0;
};

constexpr unsigned kOutOfMemory = 0x0505, kInnocentContextReset = 0x8254;

class ContextPoolAlone : public testing::Test {
 protected:
  ContextPoolAlone() { driver = {}; }

  /// True if a call got the context that an earlier one marked, and gave it back.
  bool calledAgain(ContextPool& pool) {
    auto lease = pool.acquire();
    if (!lease) {
      ADD_FAILURE() << lease.error().message;
      return false;
    }
    const bool used = std::exchange(lease.value().data<Holds>().used, true);
    EXPECT_TRUE(lease.value().check().ok());
    return used;
  }

  ContextPool pool_{std::make_shared<FakePlatform>(), 1, putFakesIn};
};

TEST_F(ContextPoolAlone, GivesAContextThatWasGivenBackInOrder) {
  EXPECT_FALSE(calledAgain(pool_));
  EXPECT_TRUE(calledAgain(pool_));
  EXPECT_EQ(driver.tried, 1);
}

TEST_F(ContextPoolAlone, ReplacesAContextThatWasLost) {
  calledAgain(pool_);
  {
    auto lease = pool_.acquire();
    ASSERT_TRUE(lease.ok());
    driver.reset = kInnocentContextReset;
    const auto lost = lease.value().check();
    ASSERT_FALSE(lost.ok());
    EXPECT_EQ(lost.error().message, "the GPU was reset");
    driver.reset = 0;
    EXPECT_FALSE(lease.value().check().ok()) << "a lost context stays lost";
  }
  EXPECT_FALSE(calledAgain(pool_));
  EXPECT_EQ(driver.living, 1);
  EXPECT_EQ(Holds::living, 1);
}

TEST_F(ContextPoolAlone, ReplacesAContextThatNobodyChecked) {
  calledAgain(pool_);
  { ASSERT_TRUE(pool_.acquire().ok()); }
  EXPECT_FALSE(calledAgain(pool_));
}

TEST_F(ContextPoolAlone, ReplacesAContextThatAnExceptionLeft) {
  calledAgain(pool_);
  EXPECT_THROW(
      {
        const auto lease = pool_.acquire();
        throw std::bad_alloc();
      },
      std::bad_alloc);
  EXPECT_FALSE(calledAgain(pool_));
}

TEST_F(ContextPoolAlone, ReplacesAContextThatItsUserDropped) {
  calledAgain(pool_);
  {
    auto lease = pool_.acquire();
    ASSERT_TRUE(lease.ok());
    EXPECT_TRUE(lease.value().check().ok());
    lease.value().drop("a shader does not compile");
    EXPECT_EQ(lease.value().check().error().message, "a shader does not compile");
  }
  EXPECT_FALSE(calledAgain(pool_));
}

TEST_F(ContextPoolAlone, ReplacesAContextThatCannotBeCurrentAndDeletesNothingOfIt) {
  calledAgain(pool_);
  driver.makes_current = false;
  {
    const auto lease = pool_.acquire();
    ASSERT_FALSE(lease.ok());
    EXPECT_EQ(lease.error().message, "the context cannot be made current");
  }
  EXPECT_EQ(driver.living, 0);
  EXPECT_EQ(Holds::living, 0);
  EXPECT_EQ(driver.deleted_without_context, 0);
  driver.makes_current = true;
  EXPECT_FALSE(calledAgain(pool_));
}

TEST_F(ContextPoolAlone, DeletesWhatAContextHeldWhileItIsCurrent) {
  {
    ContextPool pool(std::make_shared<FakePlatform>(), 3, putFakesIn);
    auto lease = pool.acquire();
    ASSERT_TRUE(lease.ok());
    EXPECT_EQ(lease.value().data<Holds>().of_contexts, 3U);
  }
  EXPECT_EQ(driver.deleted, 1);
  EXPECT_EQ(driver.deleted_without_context, 0);
}

TEST_F(ContextPoolAlone, KeepsItsPlaceThroughAnExceptionOfTheDriver) {
  driver.throws = true;
  EXPECT_THROW((void)pool_.acquire(), std::bad_alloc);
  driver.throws = false;
  EXPECT_FALSE(calledAgain(pool_));  // it would wait for ever
}

TEST_F(ContextPoolAlone, AsksABrokenDriverLessAndLessOften) {
  driver.creates = false;
  for (int i = 0; i < 1000; ++i) {
    const auto lease = pool_.acquire();
    ASSERT_FALSE(lease.ok());
    EXPECT_EQ(lease.error().message, "eglCreateContext failed with 0x3003");
  }
  EXPECT_LT(driver.tried, 60);
  EXPECT_GT(driver.tried, 5);
}

TEST_F(ContextPoolAlone, MakesFewContextsWhileMemoryIsOutAndRecovers) {
  for (int i = 0; i < 100'000; ++i) {
    auto lease = pool_.acquire();
    driver.error = kOutOfMemory;
    const auto& error = lease ? lease.value().check().error() : lease.error();
    ASSERT_EQ(error.message, "GL_OUT_OF_MEMORY");
  }
  EXPECT_LT(driver.tried, 700);
  driver.error = 0;
  constexpr int kMostRefusals = 256;
  int calls = 1;
  while (calls <= kMostRefusals) {
    auto lease = pool_.acquire();
    if (lease && lease.value().check()) break;
    ++calls;
  }
  EXPECT_LE(calls, kMostRefusals);
  const int before = driver.tried;
  {
    auto lease = pool_.acquire();
    ASSERT_TRUE(lease.ok());
    driver.error = kOutOfMemory;
    EXPECT_FALSE(lease.value().check().ok());
  }
  EXPECT_FALSE(calledAgain(pool_)) << "one failure after a success refuses nobody";
  EXPECT_EQ(driver.tried, before + 1);
}

}  // namespace
}  // namespace culld::gpu
