// Any bytes are a small scene and a camera, or none: every method, on every SIMD target, answers
// all that the oracle sees. Numbers are grid points, powers of two, neighbours of earlier numbers
// or raw bits, so that ties, cracks and overflows are a byte away.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "culling/core/simd.h"
#include "culling/culler.h"
#include "culling/oracle/oracle.h"
#include "culling/scene/scene_builder.h"

namespace {

using namespace culld;

void require(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "fuzz_methods_vs_oracle: %s\n", what);
  std::abort();
}

/// Reads numbers off the input; zeros past its end.
class Script {
 public:
  explicit Script(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  std::uint8_t byte() {
    if (bytes_.empty()) return 0;
    const std::uint8_t value = bytes_.front();
    bytes_ = bytes_.subspan(1);
    return value;
  }
  std::uint32_t below(std::uint32_t count) { return byte() % count; }

  double number() {
    const std::uint8_t kind = byte();
    const auto value = static_cast<std::int8_t>(byte());
    switch (kind % 8) {
      case 0:
        last_ = std::copysign(std::ldexp(1.0, value / 2), value % 2 == 0 ? 1.0 : -1.0);
        break;
      case 1:
        last_ = raw<float>();
        break;
      case 2:
        last_ = last_ * (1.0 + value * 0x1p-24);
        break;
      case 3:
        last_ = -last_;
        break;
      case 4:
        last_ += value * 0x1p-20;
        break;
      default:
        last_ = value / 8.0;
    }
    last_ = judgeable(last_);
    return last_;
  }
  double rawDouble() { return judgeable(raw<double>()); }
  glm::dvec3 point() {
    const double x = number(), y = number();
    return {x, y, number()};
  }

 private:
  /// NaN, infinite, or of a size that the oracle can judge: with larger ratios between the things
  /// in view its doubles prove nothing (docs/oracle.md, Limits). The families of tests/cases go
  /// further, each in one direction.
  static double judgeable(double value) {
    const double size = std::abs(value);
    return std::isfinite(value) && (size > 1e5 || size < 1e-5) ? 0.0 : value;
  }
  template <typename T>
  double raw() {
    std::uint8_t bytes[sizeof(T)];
    for (std::uint8_t& b : bytes) b = byte();
    T value;
    std::memcpy(&value, bytes, sizeof(T));
    return static_cast<double>(value);
  }

  std::span<const std::uint8_t> bytes_;
  double last_ = 1.0;
};

/// A wall, a box or any triangles.
RawSurface surfaceFrom(Script& script) {
  RawSurface surface;
  const std::uint8_t kind = script.byte();
  surface.blocks = kind % 8 != 7;
  surface.double_sided = kind / 8 % 2 != 0;
  switch (kind / 16 % 4) {
    case 0:
      surface.positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
      surface.indices = {0, 1, 2, 0, 2, 3};
      break;
    case 1:
      for (int i = 0; i < 8; ++i) surface.positions.emplace_back(i & 1, i >> 1 & 1, i >> 2);
      surface.indices = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                         2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
      break;
    default: {
      const std::uint32_t vertices = 3 + script.below(10);
      for (std::uint32_t v = 0; v < vertices; ++v) surface.positions.emplace_back(script.point());
      for (std::uint32_t t = 1 + script.below(16); t > 0; --t) {
        for (int corner = 0; corner < 3; ++corner) {
          surface.indices.push_back(script.below(vertices));
        }
      }
    }
  }
  for (std::uint32_t moved = script.below(4); moved > 0; --moved) {  // a vertex goes elsewhere
    const auto count = static_cast<std::uint32_t>(surface.positions.size());
    const std::uint32_t which = script.below(count);
    surface.positions[which] = glm::vec3(script.point());
  }
  return surface;
}

std::array<double, 12> transformFrom(Script& script) {
  const std::uint8_t kind = script.byte();
  std::array<double, 12> rows{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  if (kind % 4 == 3) {
    for (double& entry : rows) entry = script.number();
  } else {
    const glm::dvec3 at = script.point();
    const glm::dvec3 scale = kind % 4 == 0 ? glm::dvec3(1.0) : script.point();
    for (std::size_t r = 0; r < 3; ++r) {
      rows[5 * r] = scale[static_cast<int>(r)];
      rows[4 * r + 3] = at[static_cast<int>(r)];
    }
  }
  if (kind / 4 % 8 == 7) rows[script.below(12)] = script.rawDouble();
  return rows;
}

SnapshotPtr sceneFrom(Script& script) {
  SceneBuilder builder;
  std::uint32_t node = 0;
  for (std::uint32_t mesh = 1 + script.below(4); mesh > 0; --mesh) {
    std::vector<RawSurface> surfaces{surfaceFrom(script)};
    if (script.below(4) == 3) surfaces.push_back(surfaceFrom(script));
    const MeshId id = builder.addMesh(makeMesh(surfaces));
    for (std::uint32_t object = 1 + script.below(3); object > 0; --object) {
      builder.addInstance(id, transformFrom(script), node++);
    }
  }
  return builder.finish();
}

Result<Camera> cameraFrom(Script& script) {
  const std::uint8_t kind = script.byte();
  const ImageSize image{1U << (kind / 4 % 8), 1U << (kind / 32 % 8)};
  if (kind % 4 == 3) {
    glm::dmat4 view(1.0), projection(0.0);
    view[3] = glm::dvec4(script.point(), 1.0);
    projection[0][0] = projection[1][1] = 1.0;
    projection[2] = {0.0, 0.0, -1.0, -1.0};
    projection[3][2] = -0.1;
    for (std::uint32_t changed = script.below(6); changed > 0; --changed) {
      glm::dmat4& matrix = script.below(2) == 0 ? view : projection;
      const std::uint32_t which = script.below(16);
      matrix[static_cast<int>(which / 4)][static_cast<int>(which % 4)] = script.number();
    }
    return cameraFromMatrices(view, projection, image);
  }
  LookAt look;
  look.eye = script.point();
  look.target = kind % 4 == 2 ? script.point() : look.eye + glm::dvec3(0.0, 0.0, -1.0);
  look.znear_m = kind % 4 == 1 ? std::abs(script.number()) : 0.01;
  look.yfov_rad = script.below(4) == 3 ? std::abs(script.number()) : 1.0;
  if (script.below(4) == 3) look.zfar_m = look.znear_m + std::abs(script.number());
  return cameraFromLookAt(look, image);
}

void judge(const Method& method, const SnapshotPtr& scene, const Camera& camera,
           const std::vector<ObjectId>& visible) {
  const auto culler = method.prepare(scene);
  require(culler.ok(), "a method refuses the scene");
  std::vector<ObjectId> first;
  ViewState view;
  const std::vector<std::string> targets = simdTargets();
  for (const std::string& target : targets) {
    require(forceSimdTarget(target).ok(), "a target cannot be forced");
    const Answer answer = culler.value()->cull(camera, {}, view);
    if (target == targets.front()) first = answer.visible;
    require(answer.visible == first, "two targets answer other bytes");
    require(answer.proven && answer.guarantee == Guarantee::kConservative, "a weak promise");
  }
  require(std::adjacent_find(first.begin(), first.end(), std::greater_equal<>()) == first.end(),
          "the answer is no set");
  for (const ObjectId id : visible) {
    if (std::binary_search(first.begin(), first.end(), id)) continue;
    std::fprintf(stderr, "%s lacks object %u of %zu\n", std::string(method.info().name).c_str(), id,
                 scene->objectCount());
    require(false, "an object that can be seen is missing");
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Script script({data, size});
  const Result<Camera> camera = cameraFrom(script);
  if (!camera.ok()) {
    require(camera.error().message.starts_with("camera: "), "the message names no camera");
    return 0;
  }
  const SnapshotPtr scene = sceneFrom(script);
  const auto oracle = Oracle::build(scene);
  require(oracle.ok(), "the oracle does not start");
  OracleOptions options;
  options.lattice = 1;
  options.max_samples = 256;
  options.rays_per_object = 8;
  options.threads = 1;
  const auto truth = oracle.value()->look(camera.value(), options);
  require(truth.ok(), "the oracle does not look");
  // `auto` looks through sampled views before it answers as one of the others: now and then only.
  const bool patient = script.below(64) == 63;
  for (const Method* method : allMethods()) {
    if (method->info().name == "auto" && !patient) continue;
    judge(*method, scene, camera.value(), truth.value().visible);
  }
  return 0;
}
