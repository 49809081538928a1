// A method for tests of the planner: what it answers and what its work counts is the test's to say.
#pragma once
#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "culling/culler.h"

namespace culld::testing {

/// What a camera at some place costs and shows.
struct CountedFrame {
  std::chrono::nanoseconds work{0};
  std::uint32_t in_frustum = 0;
  std::uint32_t visible = 0;  ///< objects 0 ... visible - 1 are answered
};

class CountedMethod final : public Method {
 public:
  using Frame = std::function<CountedFrame(const Camera&)>;
  CountedMethod(std::string name, std::string needs, Frame frame)
      : name_(std::move(name)), needs_(std::move(needs)), frame_(std::move(frame)) {}

  // Set before use.
  Guarantee guarantee = Guarantee::kConservative;
  std::string refusal;  ///< not empty: no scene is accepted
  bool fails_to_prepare = false;
  std::size_t bytes = 1000;  ///< of a culler
  std::function<void()> on_prepare = [] {};
  // Counted.
  mutable std::atomic<int> prepared{0}, refitted{0}, culled{0}, alive{0};

  MethodInfo info() const noexcept override { return {name_, "test", guarantee, needs_}; }
  Result<void> accepts(const SceneProfile&) const override {
    if (!refusal.empty()) return Error{ErrorCode::kUnsupported, refusal};
    return Done{};
  }
  Result<std::unique_ptr<Culler>> prepare(SnapshotPtr, const Clock&) const override {
    ++prepared;
    on_prepare();
    if (fails_to_prepare) return Error{ErrorCode::kUnavailable, "no memory"};
    return std::unique_ptr<Culler>(std::make_unique<CountedCuller>(*this));
  }

 private:
  class CountedCuller final : public Culler {
   public:
    explicit CountedCuller(const CountedMethod& method) : method_(method) { ++method_.alive; }
    ~CountedCuller() override { --method_.alive; }
    Answer cull(const Camera& camera, const Demand&, ViewState&) const override {
      ++method_.culled;
      const CountedFrame frame = method_.frame_(camera);
      Answer answer;
      for (std::uint32_t id = 0; id < frame.visible; ++id) answer.visible.push_back(id);
      answer.stats.work = frame.work;
      answer.stats.in_frustum = frame.in_frustum;
      return answer;
    }
    Result<std::unique_ptr<Culler>> edited(SnapshotPtr, std::span<const ObjectId>) const override {
      ++method_.refitted;
      return std::unique_ptr<Culler>(std::make_unique<CountedCuller>(method_));
    }
    std::size_t preparedBytes() const noexcept override { return method_.bytes; }

   private:
    const CountedMethod& method_;
  };

  std::string name_, needs_;
  Frame frame_;
};

}  // namespace culld::testing
