// OpenGL contexts for any number of threads: a call borrows one, which is current in its thread
// until it is given back. What a context holds on the GPU (programs, scenes) lives and dies with
// it: one that was lost is dropped, and the next one made fills itself again.
#pragma once
#include <condition_variable>
#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "culling/core/result.h"
#include "culling/gpu/gl_table.h"
#include "culling/gpu/platform.h"

namespace culld::gpu {

/// What somebody keeps in a context. Destroyed while the context is current.
class ContextData {
 public:
  virtual ~ContextData() = default;
};

class PooledContext {
 public:
  PooledContext(std::unique_ptr<NativeContext> native, const GlTable& gl)
      : native_(std::move(native)), gl_(gl) {}
  /// REQUIRES: not current in another thread.
  ~PooledContext();
  PooledContext(const PooledContext&) = delete;
  PooledContext& operator=(const PooledContext&) = delete;

  NativeContext& native() noexcept { return *native_; }
  const GlTable& gl() const noexcept { return gl_; }

  /// The data of that type, made from (*this) on first use. REQUIRES: current.
  template <typename T>
  T& data() {
    for (const auto& kept : data_) {
      if (T* mine = dynamic_cast<T*>(kept.get())) return *mine;
    }
    auto fresh = std::make_unique<T>(gl_);
    T& mine = *fresh;
    data_.push_back(std::move(fresh));
    return mine;
  }

 private:
  std::unique_ptr<NativeContext> native_;
  GlTable gl_;
  std::vector<std::unique_ptr<ContextData>> data_;
};

class ContextPool {
 public:
  /// Called with the table of each context made; tests put their own functions in.
  using Adjust = std::function<void(GlTable&)>;

  /// At most `most` contexts at a time.
  ContextPool(std::shared_ptr<Platform> platform, std::size_t most, Adjust adjust = {})
      : platform_(std::move(platform)), most_(most), adjust_(std::move(adjust)) {}

  /// A context, current in this thread while the lease lives. REQUIRES: the same thread throughout;
  /// one lease per thread.
  class Lease {
   public:
    Lease(ContextPool& pool, std::unique_ptr<PooledContext> context)
        : pool_(&pool), context_(std::move(context)) {}
    Lease(Lease&&) = default;
    Lease& operator=(Lease&&) = delete;
    ~Lease();

    const GlTable& gl() const noexcept { return context_->gl(); }
    template <typename T>
    T& data() {
      return context_->data<T>();
    }
    /// Whether all went well since the lease began. ERROR: kUnavailable, the context was lost, ran
    /// out of memory or was misused: it is not used again, and nothing read from it holds.
    Result<void> check();

   private:
    ContextPool* pool_;
    std::unique_ptr<PooledContext> context_;
    bool broken_ = false;
  };

  /// Waits if all contexts are in use. ERROR: kUnavailable: none can be made. After failures in a
  /// row it says so at once for a growing number of calls, so that they cost nothing. THREADS: any.
  Result<Lease> acquire();

 private:
  Result<std::unique_ptr<PooledContext>> make();
  void giveBack(std::unique_ptr<PooledContext> context);

  std::shared_ptr<Platform> platform_;
  std::size_t most_;
  Adjust adjust_;
  std::mutex mutex_;
  std::condition_variable returned_;
  std::vector<std::unique_ptr<PooledContext>> idle_;
  std::size_t alive_ = 0;          ///< idle, in use or being made
  std::size_t failures_ = 0;       ///< in a row
  std::size_t refusals_left_ = 0;  ///< calls that are still told the last failure
  std::string last_failure_;
};

}  // namespace culld::gpu
