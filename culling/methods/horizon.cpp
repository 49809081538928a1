#include "culling/methods/horizon.h"

#include <cmath>
#include <memory>
#include <string>
#include <utility>

#include "culling/box_answer.h"
#include "culling/methods/horizon_walk.h"
#include "culling/spatial/prepared_boxes.h"

namespace culld {
namespace {

/// More of the surfaces than this hang over others: storeys, caves.
constexpr double kMostOverhang = 0.15;

constexpr Setting kSettings[] = {
    {"sweep", "occluders join the horizon at their farthest point; off: as soon as they are met"},
    {"tree", "columns lie under a binary tree; off: they are looked at one by one"},
    {"hierarchy", "nodes are compared with the horizon too; off: objects only"},
    {"slice-columns", "columns of an occluder that join together; 0: all of it", 16, 0, 4096},
    {"least-gain", "share of an object's rectangle that must stick out for it to be an occluder",
     0.02, 0.0, 1.0, false},
};

HorizonParts partsOf(const SettingValues& values) {
  return {values.on("sweep"), values.on("tree"), values.on("hierarchy"),
          static_cast<std::uint32_t>(values.number("slice-columns")),
          static_cast<float>(values.number("least-gain"))};
}

class HorizonCuller final : public Culler {
 public:
  HorizonCuller(PreparedBoxes boxes, const HorizonParts& parts, const Clock& clock)
      : boxes_(std::move(boxes)), parts_(parts), clock_(clock) {}

  Answer cull(const Camera& camera, const Demand& demand, ViewState& view) const override {
    const auto run = [&](const Deadline& deadline, Answer& answer) -> std::string_view {
      if (!camera.motion.still()) return "a camera with a motion bound";
      HorizonWalk(*boxes_.scene(), boxes_.bvh(), camera, deadline, demand, parts_,
                  view.memory<HorizonMemory>())
          .run(answer);
      return {};
    };
    return answerBy("horizon", boxes_, clock_, camera, demand, run);
  }

  Result<std::unique_ptr<Culler>> edited(SnapshotPtr next,
                                         std::span<const ObjectId> changed) const override {
    return around(boxes_.edited(std::move(next), changed), parts_, clock_);
  }

  std::size_t preparedBytes() const noexcept override { return boxes_.bytes(); }

  static Result<std::unique_ptr<Culler>> around(Result<PreparedBoxes> boxes,
                                                const HorizonParts& parts, const Clock& clock) {
    if (!boxes) return std::move(boxes).error();
    return std::unique_ptr<Culler>(
        std::make_unique<HorizonCuller>(std::move(boxes).value(), parts, clock));
  }

 private:
  PreparedBoxes boxes_;
  HorizonParts parts_;
  const Clock& clock_;
};

class HorizonMethod final : public Method {
 public:
  explicit HorizonMethod(const HorizonParts& parts) : parts_(parts) {}

  MethodInfo info() const noexcept override {
    return {"horizon", "Downs, M\u00f6ller, S\u00e9quin 2001", Guarantee::kConservative,
            "triangles, a 2.5D scene"};
  }
  Result<void> accepts(const SceneProfile& profile) const override {
    if (!(profile.overhang > kMostOverhang)) return Done{};
    return Error{ErrorCode::kUnsupported,
                 "horizon: not 2.5D: " + std::to_string(std::lround(100.0 * profile.overhang)) +
                     " % of the surfaces hang over others, at most " +
                     std::to_string(std::lround(100.0 * kMostOverhang)) + " % may"};
  }
  Result<std::unique_ptr<Culler>> prepare(SnapshotPtr scene, const Clock& clock) const override {
    return HorizonCuller::around(PreparedBoxes::of(std::move(scene)), parts_, clock);
  }
  Result<std::unique_ptr<Culler>> prepareBeside(const Culler& sibling, SnapshotPtr scene,
                                                const Clock& clock) const override {
    const PreparedBoxes* lent = boxesOf(sibling);
    if (lent == nullptr) return prepare(std::move(scene), clock);
    return HorizonCuller::around(*lent, parts_, clock);
  }
  std::span<const Setting> settings() const noexcept override { return kSettings; }
  std::unique_ptr<const Method> with(const SettingValues& values) const override {
    return std::make_unique<const HorizonMethod>(partsOf(values));
  }

 private:
  HorizonParts parts_;
};

}  // namespace

const Method& horizonMethod() noexcept {
  static const HorizonMethod method(partsOf(SettingValues(kSettings)));
  return method;
}

}  // namespace culld
