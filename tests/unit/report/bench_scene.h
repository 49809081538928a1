// A scene whose truth can be read off, and methods whose answers are the test's to say.
#pragma once
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "culling/report/bench.h"
#include "culling/scene/scene_builder.h"

namespace culld::report {

inline RawSurface unitSquare() {
  return {{{-0.5F, -0.5F, 0}, {0.5F, -0.5F, 0}, {0.5F, 0.5F, 0}, {-0.5F, 0.5F, 0}},
          {0, 1, 2, 0, 2, 3},
          true,
          true};
}

/// Seen from the origin along -z: a wall (0) over the left half of the view, a square hidden behind
/// it (1), a square that is seen (2), a tiny one that is seen (3), one behind the camera (4).
inline SnapshotPtr halfWall() {
  SceneBuilder builder;
  const MeshId mesh = builder.addMesh(makeMesh({unitSquare()}));
  const auto put = [&](double x, double z, double side, std::uint32_t node) {
    builder.addInstance(mesh, {side, 0, 0, x, 0, side, 0, 0, 0, 0, 1, z}, node);
  };
  put(-50, -5, 100, 0);
  put(-2, -10, 1, 1);
  put(2, -10, 1, 2);
  put(4, -10, 0.02, 3);
  put(0, 10, 1, 4);
  return builder.finish();
}

class ScriptedMethod final : public Method {
 public:
  using Script = std::function<Answer(const Camera&, const Demand&)>;
  ScriptedMethod(std::string name, Guarantee guarantee, Script script)
      : name_(std::move(name)), guarantee_(guarantee), script_(std::move(script)) {}
  /// Always the same.
  ScriptedMethod(std::string name, Guarantee guarantee, const std::vector<ObjectId>& ids)
      : ScriptedMethod(std::move(name), guarantee, [ids, guarantee](const Camera&, const Demand&) {
          Answer answer;
          answer.visible = ids;
          answer.guarantee = guarantee;
          return answer;
        }) {}

  MethodInfo info() const noexcept override { return {name_, "test", guarantee_, "boxes"}; }
  Result<void> accepts(const SceneProfile&) const override { return Done{}; }
  Result<std::unique_ptr<Culler>> prepare(SnapshotPtr, const Clock&) const override {
    if (fails_to_prepare) return Error{ErrorCode::kUnsupported, "too round"};
    return std::unique_ptr<Culler>(std::make_unique<ScriptedCuller>(script_));
  }
  bool fails_to_prepare = false;

 private:
  class ScriptedCuller final : public Culler {
   public:
    explicit ScriptedCuller(Script script) : script_(std::move(script)) {}
    Answer cull(const Camera& camera, const Demand& demand, ViewState&) const override {
      return script_(camera, demand);
    }
    Result<std::unique_ptr<Culler>> edited(SnapshotPtr, std::span<const ObjectId>) const override {
      return std::unique_ptr<Culler>(std::make_unique<ScriptedCuller>(script_));
    }
    std::size_t preparedBytes() const noexcept override { return 1234; }

   private:
    Script script_;
  };
  std::string name_;
  Guarantee guarantee_;
  Script script_;
};

}  // namespace culld::report
