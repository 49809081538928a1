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
#include <utility>
#include <vector>

#include "culling/core/result.h"
#include "culling/gpu/gl_table.h"
#include "culling/gpu/platform.h"

namespace culld::gpu {

/// What somebody keeps in a context. Destroyed while the context is current; if it can not be any
/// more, with a table whose deleting functions do nothing.
class ContextData {
 public:
  virtual ~ContextData() = default;
};

class PooledContext {
 public:
  /// `contexts`: how many there may be beside each other, this one among them.
  PooledContext(std::unique_ptr<NativeContext> native, const GlTable& gl, std::size_t contexts)
      : native_(std::move(native)), gl_(gl), contexts_(contexts) {}
  /// REQUIRES: not current in another thread.
  ~PooledContext();
  PooledContext(const PooledContext&) = delete;
  PooledContext& operator=(const PooledContext&) = delete;

  NativeContext& native() noexcept { return *native_; }
  const GlTable& gl() const noexcept { return gl_; }

  /// The data of that type, made from the table and the number of contexts on first use. REQUIRES:
  /// current.
  template <typename T>
  T& data() {
    for (const auto& kept : data_) {
      if (T* mine = dynamic_cast<T*>(kept.get())) return *mine;
    }
    auto fresh = std::make_unique<T>(gl_, contexts_);
    T& mine = *fresh;
    data_.push_back(std::move(fresh));
    return mine;
  }

 private:
  std::unique_ptr<NativeContext> native_;
  GlTable gl_;
  std::size_t contexts_;
  std::vector<std::unique_ptr<ContextData>> data_;
};

class ContextPool {
 public:
  /// Called with the table of each context made; tests put their own functions in.
  using Adjust = std::function<void(GlTable&)>;

  /// At most `most` contexts at a time.
  ContextPool(std::shared_ptr<Platform> platform, std::size_t most, Adjust adjust = {})
      : platform_(std::move(platform)), most_(most), adjust_(std::move(adjust)) {
    idle_.reserve(most);
  }

  /// A context, current in this thread while the lease lives. Only one whose last check() went well
  /// is given back: what an exception or a forgotten check leaves behind serves nobody else.
  /// REQUIRES: the same thread throughout; one lease per thread.
  class Lease {
   public:
    Lease(ContextPool& pool, std::unique_ptr<PooledContext> context)
        : pool_(&pool), context_(std::move(context)) {}
    Lease(Lease&& other) noexcept
        : pool_(std::exchange(other.pool_, nullptr)),
          context_(std::move(other.context_)),
          fine_(other.fine_),
          dropped_(other.dropped_),
          failure_(std::move(other.failure_)) {}
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
    /// The context is not used again, whatever it says of itself.
    void drop(std::string why);

   private:
    friend class ContextPool;
    ContextPool* pool_;
    std::unique_ptr<PooledContext> context_;
    bool fine_ = false, dropped_ = false;
    std::string failure_;  ///< why it was dropped, if somebody said
  };

  /// Waits if all contexts are in use. ERROR: kUnavailable: none can be made. If one after the
  /// other cannot be made or is dropped, it says so at once for a growing number of calls, 255 at
  /// most, so that they cost nothing. THREADS: any.
  Result<Lease> acquire();

 private:
  Result<Lease> place();
  Result<std::unique_ptr<PooledContext>> make();
  /// nullptr: it was dropped, or could not be made.
  void giveBack(std::unique_ptr<PooledContext> context, std::string failure);

  std::shared_ptr<Platform> platform_;
  std::size_t most_;
  Adjust adjust_;
  std::mutex mutex_;
  std::condition_variable returned_;
  std::vector<std::unique_ptr<PooledContext>> idle_;
  std::size_t alive_ = 0;          ///< idle, in use or being made
  std::size_t failures_ = 0;       ///< in a row, to make a context or to use it
  std::size_t refusals_left_ = 0;  ///< calls that are still told the last failure
  std::string last_failure_;
};

}  // namespace culld::gpu
