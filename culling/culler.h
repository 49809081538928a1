// A culling method answers one question: which objects of a scene must this camera receive?
// Method is the stateless recipe; Culler is that recipe prepared for one immutable snapshot.
#pragma once
#include <chrono>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "culling/core/camera.h"
#include "culling/core/clock.h"
#include "culling/core/ids.h"
#include "culling/core/result.h"
#include "culling/core/settings.h"
#include "culling/scene/scene_snapshot.h"

namespace culld {

/// What an answer promises about the exact visible set E (docs/error-model.md §1).
enum class Guarantee : std::uint8_t { kConservative, kHole, kSampled, kApproximate };

/// "conservative", "hole", "sampled", "approximate".
std::string_view guaranteeName(Guarantee guarantee) noexcept;

/// What the client asks for.
struct Demand {
  Guarantee guarantee = Guarantee::kConservative;
  float hole_px = 0.0F;              ///< with kHole: the side of the hole accepted
  float accepted_missed_px = 0.0F;   ///< loss accepted; 0 demands a superset of E
  std::chrono::nanoseconds time{0};  ///< 0: no limit; past it the answer is cut short, a superset
  /// As `time`, but of counted work (CullStats::work): the same answer on every machine. Methods
  /// whose work grows with the boxes alone need not look at it.
  std::chrono::nanoseconds work{0};
  /// Ask objects that their bounding boxes could not hide by their own triangles too: fewer are
  /// answered, for more time. Methods that never do so need not look at it.
  bool own_triangles = true;
};

/// Counted work, so that claims can be checked without a clock.
struct CullStats {
  std::chrono::nanoseconds time{0};
  std::uint32_t nodes_visited = 0;  ///< hierarchy nodes looked at
  std::uint32_t tested = 0;         ///< objects tested one by one
  std::uint32_t outside = 0;   ///< objects proven outside the frustum, as far as they were counted
  std::uint32_t occluded = 0;  ///< objects proven hidden one by one, not those below a hidden node
  /// Objects not proven outside; 0 if the method does not count them, or had no time to.
  std::uint32_t in_frustum = 0;
  std::uint32_t occluders_drawn = 0;
  std::uint32_t triangles_drawn = 0;
  std::uint32_t always_kept = 0;        ///< objects without a bound (skins, morphs, non-finite)
  std::uint64_t depth_comparisons = 0;  ///< of methods that count what they ask a pyramid
  std::uint64_t plane_tests = 0;        ///< boxes, spheres against planes; clusters against eyes
  /// The work as the method counts it, priced with constants measured once (docs/planner.md): the
  /// same number on every machine. 0 if the method does not price its work.
  std::chrono::nanoseconds work{0};
};

/// Pixels that an answer may lose: what the demand accepts, or `by_setting_px` where it names no
/// number. 0 unless approximate answers are demanded of a camera that stands still: what is lost
/// from one eye is not what is lost from another.
double acceptedLossPx(const Camera& camera, const Demand& demand, double by_setting_px) noexcept;

struct Answer {
  std::vector<ObjectId> visible;  ///< ascending, unique: equal answers are equal bytes
  std::vector<std::uint8_t>
      seen;  ///< per visible object: 1 certainly in E, 0 kept for safety; may be empty
  /// Per visible object: how many of the image's pixels show it, as far as samples tell; 0 if it
  /// was not looked for. Empty if the method does not count them.
  std::vector<float> pixels;
  Guarantee guarantee = Guarantee::kConservative;
  float missed_px = 0.0F;  ///< bound (proven) or estimate of the pixels of E lost
  bool proven = true;
  bool out_of_budget = false;  ///< stopped early: everything undecided was kept
  std::string note;            ///< what was left out of the work and why, empty if nothing
  /// Name of the method that made it, where the one asked has a choice; else empty. A literal.
  std::string_view made_by;
  CullStats stats;
};

/// A method's memory between frames and its scratch space. One per view; dropping it costs time,
/// never correctness. THREADS: one user at a time.
class ViewState {
 public:
  class Memory {
   public:
    virtual ~Memory() = default;
    /// The scene goes on in a version made by edits: forgets what held for the old one only. False:
    /// nothing is left.
    virtual bool sceneEdited() { return false; }
  };
  /// The memory of the culler that asks, made on first use and when another method comes by.
  template <typename T>
  T& memory() {
    T* mine = dynamic_cast<T*>(memory_.get());
    if (mine == nullptr) {
      auto fresh = std::make_unique<T>();
      mine = fresh.get();
      memory_ = std::move(fresh);
    }
    return *mine;
  }

  /// To be called before a view goes on with Culler::edited()'s culler.
  void sceneEdited() {
    if (memory_ != nullptr && !memory_->sceneEdited()) memory_.reset();
  }

 private:
  std::unique_ptr<Memory> memory_;
};

/// A method prepared for one immutable snapshot.
class Culler {
 public:
  virtual ~Culler() = default;
  /// REQUIRES: a camera made by cameraFrom...(). GUARANTEES: the method's, also when time runs out.
  /// THREADS: any number of callers, each with its own ViewState.
  virtual Answer cull(const Camera& camera, const Demand& demand, ViewState& view) const = 0;
  /// The same method for the next version of the scene, refitted rather than rebuilt.
  /// REQUIRES: `next` came from this culler's snapshot by edits of the objects in `changed`.
  /// ERROR: kUnavailable: it cannot follow, and the method is to be prepared anew.
  virtual Result<std::unique_ptr<Culler>> edited(SnapshotPtr next,
                                                 std::span<const ObjectId> changed) const = 0;
  /// Bytes that this culler holds beyond the snapshot.
  virtual std::size_t preparedBytes() const noexcept = 0;
};

/// What a scene is like, as far as methods and planner need it (culling/planner).
struct SceneProfile {
  std::uint64_t objects = 0;
  std::uint64_t triangles = 0;
  std::uint64_t blocking_triangles = 0;
  double overhang = 0.0;  ///< 0 for streets of houses, toward 1/2 in caves (planner/overhang.h)
};

struct MethodInfo {
  std::string_view name;
  std::string_view source;  ///< author, year
  Guarantee guarantee = Guarantee::kConservative;
  std::string_view needs;  ///< "boxes", "triangles", ...
};

/// A published method, ready to be prepared for any scene. Stateless. THREADS: any.
class Method {
 public:
  virtual ~Method() = default;
  virtual MethodInfo info() const noexcept = 0;
  /// ERROR: kUnsupported, saying why this method is not for such a scene.
  virtual Result<void> accepts(const SceneProfile& profile) const = 0;
  /// Time limits in a Demand are measured with `clock`, which must outlive the culler.
  virtual Result<std::unique_ptr<Culler>> prepare(SnapshotPtr scene,
                                                  const Clock& clock = steadyClock()) const = 0;
  /// The same, sharing what `sibling`, any method's culler of that snapshot, has prepared.
  virtual Result<std::unique_ptr<Culler>> prepareBeside(const Culler& /*sibling*/,
                                                        SnapshotPtr scene,
                                                        const Clock& clock) const {
    return prepare(std::move(scene), clock);
  }
  /// What can be turned about it; the method itself has the standard values.
  virtual std::span<const Setting> settings() const noexcept { return {}; }
  /// The same method with other values. REQUIRES: values of the table that settings() gives.
  virtual std::unique_ptr<const Method> with(const SettingValues& /*values*/) const {
    return nullptr;  // not asked of a method without settings
  }
};

/// Every method, an explicit table (methods/all.cpp).
std::span<const Method* const> allMethods() noexcept;
/// nullptr if there is none of that name.
const Method* findMethod(std::span<const Method* const> methods, std::string_view name) noexcept;
const Method* findMethod(std::string_view name) noexcept;  ///< of allMethods()

/// Methods by name, also with settings other than the standard ones: "raster",
/// "z-pyramid:coherence=off:levels=6". THREADS: one at a time.
class ConfiguredMethods {
 public:
  /// `table` must outlive this.
  explicit ConfiguredMethods(std::span<const Method* const> table)
      : methods_(table.begin(), table.end()) {}

  /// Its info().name is `name` as given; the same object for the same name. Lives as long as this.
  /// ERROR: kInvalidInput: no method or no setting of that name, no value of it; names it.
  Result<const Method*> find(const std::string& name);

  /// The table's methods and all that were found since. Good until the next find().
  std::span<const Method* const> all() const noexcept { return methods_; }

 private:
  std::vector<const Method*> methods_;
  std::vector<std::unique_ptr<const Method>> own_;
};

}  // namespace culld
