#include "culling/gpu/context_pool.h"

#include <algorithm>
#include <utility>

#include "culling/gpu/unavailable.h"

namespace culld::gpu {
namespace {

constexpr std::size_t kMostRefusals = 256;  ///< calls between two tries

/// What is left of a context's objects when it cannot be current any more: their names mean nothing
/// to any other, and the driver frees them with the context.
void deleteNothing(GlTable& gl) {
  const auto nothing = [](int, const unsigned*) {};
  gl.DeleteBuffers = gl.DeleteFramebuffers = gl.DeleteTextures = gl.DeleteVertexArrays = nothing;
  gl.DeleteProgram = gl.DeleteShader = [](unsigned) {};
}

}  // namespace

PooledContext::~PooledContext() {
  if (!native_->makeCurrent()) deleteNothing(gl_);
  data_.clear();
  native_->release();
}

ContextPool::Lease::~Lease() {
  if (pool_ == nullptr) return;
  if (!fine_) context_.reset();
  if (context_ != nullptr) context_->native().release();
  pool_->giveBack(std::move(context_), std::move(failure_));
}

Result<void> ContextPool::Lease::check() {
  if (!dropped_) {
    const bool reset = gl().GetGraphicsResetStatus() != 0;
    const std::string error = takeGlError(gl());
    fine_ = !reset && error.empty();
    if (fine_) return Done{};
    drop(reset ? "the GPU was reset" : error);
  }
  return unavailable(failure_);
}

void ContextPool::Lease::drop(std::string why) {
  fine_ = false;
  dropped_ = true;
  failure_ = std::move(why);
}

Result<ContextPool::Lease> ContextPool::acquire() {
  auto lease = place();
  if (!lease) return lease;
  std::unique_ptr<PooledContext>& context = lease.value().context_;
  if (context != nullptr && !context->native().makeCurrent()) context.reset();
  if (context == nullptr) {
    auto made = make();
    if (!made) {
      lease.value().drop(made.error().message);
      return made.error();
    }
    context = std::move(made).value();
  }
  return lease;
}

/// An idle context, or the right to make one.
Result<ContextPool::Lease> ContextPool::place() {
  std::unique_lock lock(mutex_);
  returned_.wait(lock, [this] { return !idle_.empty() || alive_ < most_; });
  if (!idle_.empty()) {
    Lease lease(*this, std::move(idle_.back()));
    idle_.pop_back();
    return lease;
  }
  if (refusals_left_ > 0) {
    --refusals_left_;
    return unavailable(last_failure_.empty() ? "the last call broke off" : last_failure_);
  }
  ++alive_;
  return Lease(*this, nullptr);
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
  return std::make_unique<PooledContext>(std::move(native).value(), gl, most_);
}

void ContextPool::giveBack(std::unique_ptr<PooledContext> context, std::string failure) {
  const std::lock_guard lock(mutex_);
  if (context != nullptr) {
    idle_.push_back(std::move(context));
    failures_ = refusals_left_ = 0;
  } else {
    --alive_;
    last_failure_ = std::move(failure);
    failures_ = std::min(failures_ + 1, kMostRefusals);
    refusals_left_ = failures_ - 1;
  }
  returned_.notify_one();
}

}  // namespace culld::gpu
