#include "tests/cases/runner.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <memory>
#include <utility>

#include "culling/core/simd.h"
#include "culling/oracle/oracle.h"

namespace culld::cases {
namespace {

constexpr std::string_view kBoxesOnly = "frustum";  // leaves out what is not in the frustum, only

struct Prepared {
  std::string name;
  std::unique_ptr<Culler> culler;
  ViewState view;
};

Result<std::unique_ptr<Culler>> prepare(std::string_view name, const SnapshotPtr& scene) {
  return findMethod(name)->prepare(scene);
}

std::vector<ObjectId> without(const std::vector<ObjectId>& these,
                              const std::vector<ObjectId>& those) {
  std::vector<ObjectId> rest;
  std::set_difference(these.begin(), these.end(), those.begin(), those.end(),
                      std::back_inserter(rest));
  return rest;
}

std::size_t countAlwaysKept(const SceneSnapshot& scene) {
  std::size_t count = 0;
  for (ObjectId id = 0; id < scene.objectCount(); ++id) {
    const Instance& instance = scene.instance(id);
    if (instance.active() && instance.always_kept) ++count;
  }
  return count;
}

class Runner {
 public:
  Runner(const Case& of, const RunOptions& options) : case_(of), options_(options) {
    run_.objects = of.scene->objectCount();
    always_kept_ = countAlwaysKept(*of.scene);
  }

  CaseRun run() {
    refuseBadCameras();
    prepareAll();
    auto oracle = Oracle::build(case_.scene);
    if (!oracle) {
      fault("oracle", oracle.error().message);
      return std::move(run_);
    }
    for (const scenes::CameraSpec& spec : case_.cameras) {
      camera_ = spec.what;
      judge(spec, *oracle.value());
    }
    return std::move(run_);
  }

 private:
  void fault(const std::string& who, const std::string& what) {
    run_.faults.push_back(who + (camera_.empty() ? "" : ", camera " + camera_) + ": " + what);
  }

  void refuseBadCameras() {
    for (const scenes::CameraSpec& spec : case_.refused) {
      const auto camera = scenes::toCamera(spec);
      if (camera.ok()) {
        fault("camera", spec.what + " was taken");
      } else if (!camera.error().message.starts_with("camera: ")) {
        fault("camera", "the message names no camera: " + camera.error().message);
      }
    }
  }

  void prepareAll() {
    for (const std::string& name : methodNames()) {
      auto culler = prepare(name, case_.scene);
      if (!culler) {
        fault(name, culler.error().message);
        continue;
      }
      methods_.push_back({name, std::move(culler).value(), {}});
      run_.methods.emplace_back().method = name;
    }
  }

  void judge(const scenes::CameraSpec& spec, const Oracle& oracle) {
    const auto camera = scenes::toCamera(spec);
    if (!camera) return fault("camera", camera.error().message);
    OracleOptions how;
    how.lattice = 1;
    how.max_samples = options_.samples;
    how.rays_per_object = options_.rays_per_object;
    const auto truth = oracle.look(camera.value(), how);
    if (!truth) return fault("oracle", truth.error().message);
    ++run_.looks;
    run_.visible += truth.value().visible.size();
    run_.ties += truth.value().ties.size();
    for (std::size_t m = 0; m < methods_.size(); ++m) {
      const Answer answer = answered(methods_[m], camera.value(), run_.methods[m]);
      judge(answer, truth.value(), run_.methods[m]);
    }
  }

  /// On every target, with equal bytes; timed on the best one.
  Answer answered(Prepared& method, const Camera& camera, MethodRun& run) {
    const std::vector<std::string> targets = simdTargets();
    Answer first;
    for (const std::string& target : targets) {
      if (auto forced = forceSimdTarget(target); !forced) {
        fault(method.name, forced.error().message);
      }
      ViewState fresh;  // what `auto` answers may hang on what a view has seen before
      Answer answer = method.culler->cull(camera, {}, fresh);
      if (target == targets.front()) {
        first = std::move(answer);
      } else if (answer.visible != first.visible || answer.seen != first.seen) {
        fault(method.name, target + " answers other bytes than " + targets.front());
      }
    }
    if (auto back = forceSimdTarget("auto"); !back) fault(method.name, back.error().message);
    auto least = first.stats.time;
    for (std::uint32_t i = 1; i < options_.repeats; ++i) {
      least = std::min(least, method.culler->cull(camera, {}, method.view).stats.time);
    }
    run.time_us += std::chrono::duration<double, std::micro>(least).count();
    if (least > options_.time_limit) fault(method.name, "an answer took too long");
    return first;
  }

  void judge(const Answer& answer, const OracleAnswer& truth, MethodRun& run) {
    const std::vector<ObjectId> lost = without(truth.visible, answer.visible);
    const std::vector<ObjectId> more = without(answer.visible, truth.visible);
    run.answered += answer.visible.size();
    run.missed += lost.size();
    run.excess += without(more, truth.ties).size();
    if (!lost.empty()) {
      fault(run.method, "lacks object " + std::to_string(lost.front()) + " and " +
                            std::to_string(lost.size() - 1) + " more that can be seen");
    }
    if (answer.guarantee != Guarantee::kConservative || !answer.proven || answer.missed_px != 0) {
      fault(run.method, "promises less than was asked for");
    }
    checkForm(answer, run.method);
    checkWork(answer.stats, run);
  }

  void checkForm(const Answer& answer, const std::string& who) {
    const auto& ids = answer.visible;
    const bool ascending =
        std::adjacent_find(ids.begin(), ids.end(), std::greater_equal<>()) == ids.end();
    if (!ascending || (!ids.empty() && ids.back() >= run_.objects)) {
      fault(who, "the answer is no set of objects");
    }
    for (const ObjectId id : ids) {
      if (id < run_.objects && !case_.scene->instance(id).active()) {
        fault(who, "answers object " + std::to_string(id) + ", which is not there");
      }
    }
    if (answer.stats.always_kept != always_kept_) {
      fault(who, "counts " + std::to_string(answer.stats.always_kept) +
                     " objects without a bound of " + std::to_string(always_kept_));
    }
  }

  /// What is looked at and drawn is bounded by the scene, however odd it is.
  void checkWork(const CullStats& work, MethodRun& run) {
    const std::uint64_t objects = run_.objects, triangles = case_.scene->triangleCount();
    if (work.nodes_visited > 4 * objects + 16 || work.tested > 4 * objects ||
        work.occluders_drawn > 4 * objects || work.triangles_drawn > 4 * triangles) {
      fault(run.method, "the work has no bound");
    }
    run.work.nodes_visited += work.nodes_visited;
    run.work.tested += work.tested;
    run.work.occluders_drawn += work.occluders_drawn;
    run.work.triangles_drawn += work.triangles_drawn;
    run.work.always_kept += work.always_kept;
  }

  const Case& case_;
  const RunOptions& options_;
  std::string camera_;
  std::size_t always_kept_ = 0;
  std::vector<Prepared> methods_;
  CaseRun run_;
};

/// Is the thing behind the wall left out?
bool leftOut(const Probe& probe, std::string_view method) {
  auto culler = prepare(method, probe.scene);
  const auto camera = scenes::toCamera(probe.camera);
  if (!culler || !camera) return false;
  ViewState view;
  const Answer answer = culler.value()->cull(camera.value(), {}, view);
  return !std::binary_search(answer.visible.begin(), answer.visible.end(), probe.occludee);
}

}  // namespace

void CaseRun::add(const CaseRun& more) {
  looks += more.looks;
  objects += more.objects;
  visible += more.visible;
  ties += more.ties;
  faults.insert(faults.end(), more.faults.begin(), more.faults.end());
  if (methods.empty()) {
    methods = more.methods;
    return;
  }
  for (std::size_t m = 0; m < std::min(methods.size(), more.methods.size()); ++m) {
    methods[m].answered += more.methods[m].answered;
    methods[m].missed += more.methods[m].missed;
    methods[m].excess += more.methods[m].excess;
    methods[m].time_us += more.methods[m].time_us;
  }
}

CaseRun runCase(const Case& of, const RunOptions& options) { return Runner(of, options).run(); }

double depthSlackUlps(const Family& family, double value, std::uint64_t seed,
                      std::string_view method) {
  const auto out = [&](double power, std::string_view by) {
    return leftOut(*makeProbe(family, value, seed, std::pow(10.0, power)), by);
  };
  const double distance = makeProbe(family, value, seed, 0.0)->distance_m;
  const auto depth = static_cast<float>(distance);
  if (!std::isnormal(depth)) return std::numeric_limits<double>::quiet_NaN();
  double near = -17.0, far = 3.0;                          // powers of ten of the gap / distance
  while (far > near && out(far, kBoxesOnly)) far -= 0.25;  // beyond the far plane
  if (!out(far, method)) return std::numeric_limits<double>::infinity();
  for (int step = 0; step < 24; ++step) {
    const double middle = 0.5 * (near + far);
    (out(middle, method) ? far : near) = middle;
  }
  const float next = std::nextafter(depth, std::numeric_limits<float>::infinity());
  return std::pow(10.0, far) * distance / (static_cast<double>(next) - static_cast<double>(depth));
}

std::vector<std::string> methodNames() {
  std::vector<std::string> names;
  for (const Method* method : allMethods()) names.emplace_back(method->info().name);
  return names;
}

}  // namespace culld::cases
