// A method for tests of the server: its answer is easy to foretell and its time is the test's to
// say.
#pragma once
#include <atomic>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "culling/culler.h"
#include "server/scene.h"
#include "tests/scenes/row_of_objects.h"

namespace culld::server {

/// The objects that the fake answers: active, and id + floor(eye.x) divisible by three.
inline std::vector<ObjectId> fakeVisible(const SceneSnapshot& scene, double eye_x) {
  const auto shift = static_cast<std::uint32_t>(static_cast<std::int64_t>(std::floor(eye_x)));
  std::vector<ObjectId> visible;
  for (std::size_t i = 0; i < scene.objectCount(); ++i) {
    const auto id = static_cast<ObjectId>(i);
    if (scene.instance(id).active() && (id + shift) % 3 == 0) visible.push_back(id);
  }
  return visible;
}

class FakeMethod : public Method {
 public:
  explicit FakeMethod(std::string name = "fake") : name_(std::move(name)) {}

  // Set before use.
  std::function<void()> on_cull;  ///< called in the middle of each cull
  std::function<void(const Demand&)> on_demand;
  std::function<void()> on_prepare;
  std::function<void(Answer&)> on_answer;  ///< may change each answer
  std::string refusal;                     ///< not empty: no scene is accepted
  bool fails_to_prepare = false;
  std::chrono::nanoseconds cull_time{1000};
  // Counted.
  mutable std::atomic<int> prepared{0};
  mutable std::atomic<int> refitted{0};

  MethodInfo info() const noexcept override {
    return {name_, "test", Guarantee::kConservative, "boxes"};
  }
  Result<void> accepts(const SceneProfile&) const override {
    if (!refusal.empty()) return Error{ErrorCode::kUnsupported, refusal};
    return Done{};
  }
  Result<std::unique_ptr<Culler>> prepare(SnapshotPtr scene, const Clock&) const override {
    ++prepared;
    if (on_prepare) on_prepare();
    if (fails_to_prepare) return Error{ErrorCode::kUnavailable, "no memory"};
    return std::unique_ptr<Culler>(std::make_unique<FakeCuller>(*this, std::move(scene)));
  }

 private:
  /// Told in the stats: nodes_visited counts the culls that it knows of, occluders_drawn the edits.
  struct FakeMemory : ViewState::Memory {
    bool sceneEdited() override {
      ++edits;
      return true;
    }
    std::uint32_t culls = 0, edits = 0;
  };
  class FakeCuller : public Culler {
   public:
    FakeCuller(const FakeMethod& method, SnapshotPtr scene)
        : method_(method), scene_(std::move(scene)) {}

    Answer cull(const Camera& camera, const Demand& demand, ViewState& view) const override {
      if (method_.on_demand) method_.on_demand(demand);
      if (method_.on_cull) method_.on_cull();
      Answer answer;
      answer.visible = fakeVisible(*scene_, camera.origin_world.x);
      answer.seen.assign(answer.visible.size(), 1);
      answer.stats.time = method_.cull_time;
      answer.stats.tested = static_cast<std::uint32_t>(scene_->objectCount());
      auto& memory = view.memory<FakeMemory>();
      answer.stats.nodes_visited = ++memory.culls;
      answer.stats.occluders_drawn = memory.edits;
      if (method_.on_answer) method_.on_answer(answer);
      return answer;
    }
    Result<std::unique_ptr<Culler>> edited(SnapshotPtr next,
                                           std::span<const ObjectId>) const override {
      ++method_.refitted;
      return std::unique_ptr<Culler>(std::make_unique<FakeCuller>(method_, std::move(next)));
    }
    std::size_t preparedBytes() const noexcept override { return 0; }

   private:
    const FakeMethod& method_;
    SnapshotPtr scene_;
  };

  std::string name_;
};

using scenes::rowOfObjects;

/// One request by itself.
inline Result<EditOutcome> editScene(Scene& scene, std::vector<Edit> edits,
                                     std::uint64_t expected_version = 0) {
  const EditRequest request{std::move(edits), expected_version};
  return scene.edit({&request, 1}).front();
}

}  // namespace culld::server
