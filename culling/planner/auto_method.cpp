#include "culling/planner/auto_method.h"

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <mutex>
#include <optional>
#include <utility>

#include "culling/planner/watch.h"

namespace culld {
namespace {

/// What a view of an `auto` culler keeps. The watch outlives edits of the scene while the plan
/// does; what the stages keep does not.
struct AutoMemory final : ViewState::Memory {
  bool sceneEdited() override {
    base = ViewState();
    occlusion = ViewState();
    return true;
  }
  std::optional<Watch> watch;
  ViewState base, occlusion;
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
  AutoCuller(std::span<const Method* const> stages, SnapshotPtr scene, std::int64_t shown,
             PreparedPlan prepared, const Clock& clock)
      : stages_(stages),
        scene_(std::move(scene)),
        shown_(shown),
        plan_(std::move(prepared.plan)),
        base_(std::move(prepared.base)),
        occlusion_(std::move(prepared.occlusion)),
        occlusion_ready_(occlusion_ != nullptr),
        clock_(clock) {}

  Answer cull(const Camera& camera, const Demand& demand, ViewState& view) const override {
    const auto start = clock_.now();
    auto& memory = view.memory<AutoMemory>();
    Answer answer = cullWith(camera, demand, memory);
    answer.stats.time = clock_.now() - start;
    return answer;
  }

  Result<std::unique_ptr<Culler>> edited(SnapshotPtr next,
                                         std::span<const ObjectId> changed) const override {
    const std::int64_t shown = shown_ - shownOf(*scene_, changed) + shownOf(*next, changed);
    if (outgrown(plan_->profile.objects, shown)) {
      if (auto anew = planned(stages_, next, clock_)) return anew;
    }
    PreparedPlan prepared;
    prepared.plan = plan_;
    auto base = base_->edited(next, changed);
    if (!base) return std::move(base).error();
    prepared.base = std::move(base).value();
    if (occlusion_ready_.load(std::memory_order_acquire)) {
      // A stage that cannot follow is built anew when it is next wanted.
      auto occlusion = occlusion_->edited(next, changed);
      if (occlusion) prepared.occlusion = std::move(occlusion).value();
    }
    return std::unique_ptr<Culler>(
        std::make_unique<AutoCuller>(stages_, std::move(next), shown, std::move(prepared), clock_));
  }

  /// For a scene that nothing is known of.
  static Result<std::unique_ptr<Culler>> planned(std::span<const Method* const> stages,
                                                 SnapshotPtr scene, const Clock& clock) {
    auto prepared = makePlan(scene, stages, clock);
    if (!prepared) return std::move(prepared).error();
    const auto shown = static_cast<std::int64_t>(prepared.value().plan->profile.objects);
    return std::unique_ptr<Culler>(std::make_unique<AutoCuller>(
        stages, std::move(scene), shown, std::move(prepared).value(), clock));
  }

  /// Stages that share what they prepared are each counted in full.
  std::size_t preparedBytes() const noexcept override {
    std::size_t bytes = base_->preparedBytes();
    if (occlusion_ready_.load(std::memory_order_acquire)) bytes += occlusion_->preparedBytes();
    return bytes;
  }

  const Plan& plan() const noexcept { return *plan_; }

 private:
  Answer cullWith(const Camera& camera, const Demand& demand, AutoMemory& memory) const {
    if (plan_->occlusion == nullptr) {
      return baseAnswer(camera, demand, memory, "no occlusion: nothing to gain in this scene");
    }
    if (!memory.watch || !memory.watch->follows(*plan_)) memory.watch.emplace(plan_);
    const Culler* occlusion = memory.watch->wantsOcclusion(camera) ? occlusionCuller() : nullptr;
    if (occlusion == nullptr) {
      Answer answer = baseAnswer(camera, demand, memory, "no occlusion: it does not pay here");
      memory.watch->sawBase(watched(answer));
      return answer;
    }
    Answer answer = occlusion->cull(camera, demand, memory.occlusion);
    answer.made_by = plan_->occlusion->info().name;
    memory.watch->sawOcclusion(watched(answer));
    return answer;
  }

  Answer baseAnswer(const Camera& camera, const Demand& demand, AutoMemory& memory,
                    const char* why) const {
    Answer answer = base_->cull(camera, demand, memory.base);
    answer.made_by = plan_->base->info().name;
    if (answer.note.empty()) answer.note = why;
    return answer;
  }

  static WatchedFrame watched(const Answer& answer) {
    return {answer.stats.work, answer.stats.in_frustum,
            static_cast<std::uint32_t>(answer.visible.size())};
  }

  /// Built when first wanted, from the base's boxes. Who comes meanwhile waits, so that no
  /// view's answer hangs on another's.
  const Culler* occlusionCuller() const {
    if (occlusion_ready_.load(std::memory_order_acquire)) return occlusion_.get();
    const std::scoped_lock lock(building_);
    if (failed_) return nullptr;
    if (occlusion_ == nullptr) {
      auto built = plan_->occlusion->prepareBeside(*base_, scene_, clock_);
      failed_ = !built;
      if (failed_) return nullptr;
      occlusion_ = std::move(built).value();
      occlusion_ready_.store(true, std::memory_order_release);
    }
    return occlusion_.get();
  }

  std::span<const Method* const> stages_;
  SnapshotPtr scene_;
  std::int64_t shown_;
  std::shared_ptr<const Plan> plan_;
  std::unique_ptr<Culler> base_;
  mutable std::mutex building_;
  mutable std::unique_ptr<Culler> occlusion_;  ///< written once, under building_
  mutable std::atomic<bool> occlusion_ready_;  ///< then read without it
  mutable bool failed_ = false;
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
  return AutoCuller::planned(stages_, std::move(scene), clock);
}

const Plan* planOf(const Culler& culler) noexcept {
  const auto* automatic = dynamic_cast<const AutoCuller*>(&culler);
  return automatic == nullptr ? nullptr : &automatic->plan();
}

}  // namespace culld
