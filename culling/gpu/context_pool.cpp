#include "culling/gpu/context_pool.h"

#include <algorithm>
#include <utility>

namespace culld::gpu {
namespace {

constexpr std::size_t kMostRefusals = 256;  ///< calls between two tries to make a context

Error unavailable(std::string message) { return {ErrorCode::kUnavailable, std::move(message)}; }

}  // namespace

PooledContext::~PooledContext() {
  if (native_->makeCurrent()) data_.clear();
  native_->release();
}

ContextPool::Lease::~Lease() {
  if (context_ == nullptr) return;
  context_->native().release();
  if (broken_) context_.reset();
  pool_->giveBack(std::move(context_));
}

Result<void> ContextPool::Lease::check() {
  if (!broken_) {
    const bool reset = gl().GetGraphicsResetStatus() != 0;
    const std::string error = takeGlError(gl());
    if (!reset && error.empty()) return Done{};
    broken_ = true;
    return unavailable(reset ? "the GPU was reset" : error);
  }
  return unavailable("the context is lost");
}

Result<ContextPool::Lease> ContextPool::acquire() {
  std::unique_ptr<PooledContext> context;
  {
    std::unique_lock lock(mutex_);
    returned_.wait(lock, [this] { return !idle_.empty() || alive_ < most_; });
    if (!idle_.empty()) {
      context = std::move(idle_.back());
      idle_.pop_back();
    } else if (refusals_left_ > 0) {
      --refusals_left_;
      return unavailable(last_failure_);
    } else {
      ++alive_;
    }
  }
  if (context != nullptr && !context->native().makeCurrent()) {
    context.reset();  // its place is kept for the one made now
  }
  if (context == nullptr) {
    auto made = make();
    const std::lock_guard lock(mutex_);
    if (!made) {
      --alive_;
      last_failure_ = made.error().message;
      failures_ = std::min(failures_ + 1, kMostRefusals);
      refusals_left_ = failures_ - 1;
      returned_.notify_one();
      return made.error();
    }
    failures_ = 0;
    context = std::move(made).value();
  }
  return Lease(*this, std::move(context));
}

Result<std::unique_ptr<PooledContext>> ContextPool::make() {
  auto native = platform_->createContext();
  if (!native) return native.error();
  if (!native.value()->makeCurrent()) return unavailable("the context cannot be made current");
  GlTable gl;
  const std::string missing = fillTable(platform_->finder(), gl);
  if (!missing.empty()) {
    native.value()->release();
    return unavailable("there is no " + missing);
  }
  if (adjust_) adjust_(gl);
  return std::make_unique<PooledContext>(std::move(native).value(), gl);
}

void ContextPool::giveBack(std::unique_ptr<PooledContext> context) {
  const std::lock_guard lock(mutex_);
  if (context != nullptr) {
    idle_.push_back(std::move(context));
  } else {
    --alive_;
  }
  returned_.notify_one();
}

}  // namespace culld::gpu
