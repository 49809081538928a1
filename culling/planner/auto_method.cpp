#include "culling/planner/auto_method.h"

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <mutex>
#include <utility>
#include <vector>

#include "culling/planner/watch.h"

namespace culld {
namespace {

/// What a view of an `auto` culler keeps. Watches outlive edits of the scene while the plan does;
/// what the methods keep does not.
struct AutoMemory final : ViewState::Memory {
  struct Stage {
    Watch watch;
    ViewState view;
  };
  bool sceneEdited() override {
    frustum = ViewState();
    for (Stage& stage : stages) stage.view = ViewState();
    return true;
  }
  void follow(const std::shared_ptr<const Plan>& next) {
    if (plan == next) return;
    plan = next;
    stages.clear();
    for (std::size_t i = 0; i < plan->stages.size(); ++i) stages.push_back({Watch(plan, i), {}});
  }
  std::shared_ptr<const Plan> plan;
  std::vector<Stage> stages;
  ViewState frustum;
};

/// A stage's culler, built at once or when it is first wanted.
struct LazyStage {
  std::mutex building;
  std::unique_ptr<Culler> culler;  ///< written once, under `building`
  std::atomic<bool> ready{false};  ///< then read without it
  bool failed = false;

  const Culler* built() const noexcept {
    return ready.load(std::memory_order_acquire) ? culler.get() : nullptr;
  }
  void set(std::unique_ptr<Culler> made) {
    culler = std::move(made);
    ready.store(culler != nullptr, std::memory_order_release);
  }
};

/// Objects shown of those that an edit touched.
std::int64_t shownOf(const SceneSnapshot& scene, std::span<const ObjectId> changed) {
  return std::count_if(changed.begin(), changed.end(), [&](ObjectId id) {
    return id < scene.objectCount() && scene.instance(id).active();
  });
}

/// Twice or half of what was planned for is another scene; a few objects more or less never are.
bool outgrown(std::uint64_t planned, std::int64_t shown) {
  constexpr std::int64_t kFew = 100;
  const auto before = static_cast<std::int64_t>(planned);
  return std::abs(shown - before) > kFew && (shown > 2 * before || 2 * shown < before);
}

class AutoCuller final : public Culler {
 public:
  /// `shown`: objects of the scene that are shown.
  AutoCuller(SnapshotPtr scene, std::int64_t shown, PreparedPlan prepared, const Clock& clock)
      : scene_(std::move(scene)),
        shown_(shown),
        plan_(std::move(prepared.plan)),
        frustum_(std::move(prepared.frustum)),
        lazy_(plan_->stages.size()),
        clock_(clock) {
    for (std::size_t i = 0; i < prepared.stages.size(); ++i)
      lazy_[i].set(std::move(prepared.stages[i]));
  }

  Answer cull(const Camera& camera, const Demand& demand, ViewState& view) const override {
    const auto start = clock_.now();
    auto& memory = view.memory<AutoMemory>();
    memory.follow(plan_);
    Answer answer = cullWith(camera, demand, memory);
    answer.stats.time = clock_.now() - start;
    return answer;
  }

  Result<std::unique_ptr<Culler>> edited(SnapshotPtr next,
                                         std::span<const ObjectId> changed) const override {
    const std::int64_t shown = shown_ - shownOf(*scene_, changed) + shownOf(*next, changed);
    if (outgrown(plan_->profile.objects, shown)) {
      return Error{ErrorCode::kUnavailable,
                   "auto: the plan was made for another number of objects"};
    }
    PreparedPlan prepared;
    prepared.plan = plan_;
    auto frustum = frustum_->edited(next, changed);
    if (!frustum) return std::move(frustum).error();
    prepared.frustum = std::move(frustum).value();
    for (const LazyStage& stage : lazy_) {
      prepared.stages.emplace_back();
      if (const Culler* built = stage.built()) {
        // One that cannot follow is built anew when it is next wanted.
        if (auto follows = built->edited(next, changed))
          prepared.stages.back() = std::move(follows).value();
      }
    }
    return std::unique_ptr<Culler>(
        std::make_unique<AutoCuller>(std::move(next), shown, std::move(prepared), clock_));
  }

  /// Stages that share what they prepared are each counted in full.
  std::size_t preparedBytes() const noexcept override {
    std::size_t bytes = frustum_->preparedBytes();
    for (const LazyStage& stage : lazy_) {
      if (const Culler* built = stage.built()) bytes += built->preparedBytes();
    }
    return bytes;
  }

  const Plan& plan() const noexcept { return *plan_; }

 private:
  /// By the last stage that pays here; those after it hear what was answered without them.
  Answer cullWith(const Camera& camera, const Demand& demand, AutoMemory& memory) const {
    std::size_t answering = lazy_.size();
    const Culler* culler = nullptr;
    while (culler == nullptr && answering > 0) {
      --answering;
      if (memory.stages[answering].watch.wantsStage(camera)) culler = stageCuller(answering);
    }
    const bool by_stage = culler != nullptr;
    ViewState& view = by_stage ? memory.stages[answering].view : memory.frustum;
    Answer answer = (by_stage ? *culler : *frustum_).cull(camera, demand, view);
    answer.made_by = (by_stage ? plan_->stages[answering].method : plan_->frustum)->info().name;
    const WatchedFrame frame{answer.stats.work, answer.stats.in_frustum,
                             static_cast<std::uint32_t>(answer.visible.size())};
    if (by_stage) memory.stages[answering].watch.sawStage(frame);
    const std::size_t after = by_stage ? answering + 1 : 0;
    for (std::size_t i = after; i < lazy_.size(); ++i) memory.stages[i].watch.sawBase(frame);
    if (answer.note.empty() && after < lazy_.size()) {
      answer.note = by_stage ? "no further occlusion: it does not pay here"
                             : "no occlusion: it does not pay here";
    } else if (answer.note.empty() && lazy_.empty()) {
      answer.note = "no occlusion: nothing to gain in this scene";
    }
    return answer;
  }

  /// Built when first wanted, from the frustum's boxes. Who comes meanwhile waits, so that no
  /// view's answer hangs on another's. nullptr: it cannot be built.
  const Culler* stageCuller(std::size_t index) const {
    LazyStage& stage = lazy_[index];
    if (const Culler* built = stage.built()) return built;
    const std::scoped_lock lock(stage.building);
    if (stage.culler == nullptr && !stage.failed) {
      auto made = plan_->stages[index].method->prepareBeside(*frustum_, scene_, clock_);
      stage.failed = !made;
      if (made) stage.set(std::move(made).value());
    }
    return stage.culler.get();
  }

  SnapshotPtr scene_;
  std::int64_t shown_;
  std::shared_ptr<const Plan> plan_;
  std::unique_ptr<Culler> frustum_;
  mutable std::vector<LazyStage> lazy_;  ///< of plan_->stages
  const Clock& clock_;
};

}  // namespace

MethodInfo AutoMethod::info() const noexcept {
  return {"auto", "culld", Guarantee::kConservative, "boxes; triangles where occlusion pays"};
}

Result<void> AutoMethod::accepts(const SceneProfile& profile) const {
  const auto stages = chooseStages(profile, stages_);
  if (!stages) return stages.error();
  return Done{};
}

Result<std::unique_ptr<Culler>> AutoMethod::prepare(SnapshotPtr scene, const Clock& clock) const {
  auto prepared = makePlan(scene, stages_, clock);
  if (!prepared) return std::move(prepared).error();
  const auto shown = static_cast<std::int64_t>(prepared.value().plan->profile.objects);
  return std::unique_ptr<Culler>(
      std::make_unique<AutoCuller>(std::move(scene), shown, std::move(prepared).value(), clock));
}

const Plan* planOf(const Culler& culler) noexcept {
  const auto* automatic = dynamic_cast<const AutoCuller*>(&culler);
  return automatic == nullptr ? nullptr : &automatic->plan();
}

}  // namespace culld
