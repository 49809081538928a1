#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <optional>
#include <utility>

#include "tests/scenes/random.h"
#include "tests/scenes/random_scene.h"

namespace culld::scenes {
namespace {

glm::dvec3 worldOf(const Instance& instance, const glm::dvec3& p) {
  const auto& m = instance.world_from_mesh;
  return {m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3], m[4] * p.x + m[5] * p.y + m[6] * p.z + m[7],
          m[8] * p.x + m[9] * p.y + m[10] * p.z + m[11]};
}

class CameraMaker {
 public:
  CameraMaker(std::uint64_t seed, const SceneSnapshot& scene) : random_(seed), scene_(scene) {
    for (ObjectId id = 0; id < scene.objectCount(); ++id) {
      const Instance& instance = scene.instance(id);
      if (!instance.active() || instance.always_kept) continue;
      bounded_.push_back(id);
      sizes_.push_back(glm::length(instance.bounds_world.max - instance.bounds_world.min));
    }
    if (bounded_.empty()) return;
    // The middle one's size: a ground that goes on forever must not decide.
    std::vector<double> sorted = sizes_;
    std::nth_element(sorted.begin(),
                     sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2), sorted.end());
    usual_size_ = std::max(sorted[sorted.size() / 2], 1e-9);
  }

  CameraSpec make() {
    for (;;) {
      CameraSpec spec = random_.chance(0.6) ? lookAt() : matrices();
      spec.image = image();
      if (toCamera(spec).ok()) return spec;
    }
  }

 private:
  glm::dvec3 direction() {
    for (;;) {
      const glm::dvec3 d{random_.uniform(-1, 1), random_.uniform(-1, 1), random_.uniform(-1, 1)};
      const double length = glm::length(d);
      if (length > 0.1 && length <= 1.0) return d / length;
    }
  }

  const Instance* anyInstance() {
    if (bounded_.empty()) return nullptr;
    return &scene_.instance(bounded_[random_.below(static_cast<std::uint32_t>(bounded_.size()))]);
  }

  glm::dvec3 inBounds(const Instance& instance) {
    const Box& b = instance.bounds_world;
    return {random_.uniform(b.min.x, b.max.x), random_.uniform(b.min.y, b.max.y),
            random_.uniform(b.min.z, b.max.z)};
  }

  /// On a vertex, an edge or the inside of some triangle.
  std::optional<glm::dvec3> onSurface(const Instance& instance) {
    const Mesh& mesh = scene_.mesh(instance.mesh);
    if (mesh.triangles.empty()) return std::nullopt;
    const auto& t =
        mesh.triangles[random_.below(static_cast<std::uint32_t>(mesh.triangles.size()))];
    double u = random_.unit(), v = random_.unit() * (1 - u);
    if (random_.chance(0.3)) v = 0;
    if (random_.chance(0.3)) u = 0;
    const glm::dvec3 a(mesh.positions[t[0]]), b(mesh.positions[t[1]]), c(mesh.positions[t[2]]);
    return worldOf(instance, a + u * (b - a) + v * (c - a));
  }

  glm::dvec3 eye() {
    const Instance* instance = anyInstance();
    const double kind = random_.unit();
    if (instance == nullptr) return direction() * (10 * kind);
    if (kind < 0.15) return inBounds(*instance);
    if (kind < 0.25) {
      if (const auto point = onSurface(*instance)) return *point;
    }
    if (kind < 0.35) {  // a hair off a surface
      if (const auto point = onSurface(*instance))
        return *point + direction() * (usual_size_ * 1e-6);
    }
    const double far = std::pow(10.0, random_.uniform(-0.5, 1.5));
    return worldOf(*instance, glm::dvec3(0.0)) + direction() * (far * usual_size_);
  }

  glm::dvec3 target(const glm::dvec3& from) {
    const Instance* instance = anyInstance();
    if (instance == nullptr || random_.chance(0.1)) return from + direction();
    if (random_.chance(0.5)) {
      if (const auto point = onSurface(*instance)) return *point;
    }
    return inBounds(*instance);
  }

  double near() { return usual_size_ * std::pow(10.0, random_.uniform(-4, -0.5)); }
  double far() { return usual_size_ * std::pow(10.0, random_.uniform(0, 4)); }

  double yfov() {
    const double kind = random_.unit();
    if (kind < 0.1) return random_.uniform(2e-4, 0.02);
    if (kind < 0.2) return random_.uniform(2.6, 3.12);
    return random_.uniform(0.3, 2.0);
  }

  CameraSpec lookAt() {
    LookAt look;
    look.eye = eye();
    look.target = target(look.eye);
    look.up = random_.chance(0.6) ? glm::dvec3(0, 1, 0) : direction();
    look.yfov_rad = yfov();
    look.aspect = random_.chance(0.8) ? 16.0 / 9.0 : std::pow(10.0, random_.uniform(-1, 1));
    look.znear_m = near();
    if (random_.chance(0.6)) look.zfar_m = look.znear_m + far();
    return {look, {}, "look-at"};
  }

  glm::dmat4 viewMatrix(bool mirrored) {
    const glm::dvec3 from = eye();
    glm::dvec3 back = from - target(from);
    back = glm::length(back) > 0 ? glm::normalize(back) : direction();
    glm::dvec3 right = glm::cross(direction(), back);
    while (!(glm::length(right) > 0.01)) right = glm::cross(direction(), back);
    right = glm::normalize(right);
    const glm::dvec3 up = glm::cross(back, right);
    if (mirrored) right = -right;
    glm::dmat4 view(1.0);
    for (int i = 0; i < 3; ++i) {
      view[i] = {right[i], up[i], back[i], 0.0};
    }
    view[3] = {-glm::dot(right, from), -glm::dot(up, from), -glm::dot(back, from), 1.0};
    return view;
  }

  glm::dmat4 orthographic() {
    const double half_height = usual_size_ * std::pow(10.0, random_.uniform(-1, 1.5));
    const double depth = far();
    glm::dmat4 p(1.0);
    p[0][0] = 9.0 / 16.0 / half_height;
    p[1][1] = 1.0 / half_height;
    p[2][2] = -2.0 / depth;
    p[3][0] = random_.uniform(-0.5, 0.5);
    p[3][2] = random_.uniform(-1, 0);
    return p;
  }

  glm::dmat4 perspective(bool infinite, bool reversed) {
    const double n = near(), f = n + far(), top = std::tan(random_.uniform(0.2, 1.2));
    glm::dmat4 p(0.0);
    p[0][0] = 1.0 / (top * 16.0 / 9.0);
    p[1][1] = 1.0 / top;
    p[2][3] = -1.0;
    p[2][2] = infinite ? -1.0 : -(f + n) / (f - n);
    p[3][2] = infinite ? -2.0 * n : -2.0 * f * n / (f - n);
    if (reversed) {
      p[2][2] = -p[2][2];
      p[3][2] = -p[3][2];
    }
    return p;
  }

  /// Lengyel's oblique near plane, a modest tilt of the usual one.
  void makeOblique(glm::dmat4& p, double n) {
    const glm::dvec4 plane{random_.uniform(-0.3, 0.3), random_.uniform(-0.3, 0.3), -1.0, -n};
    const glm::dvec4 corner((std::copysign(1.0, plane.x) + p[2][0]) / p[0][0],
                            (std::copysign(1.0, plane.y) + p[2][1]) / p[1][1], -1.0,
                            (1.0 + p[2][2]) / p[3][2]);
    const double scale = 2.0 / glm::dot(plane, corner);
    for (int column = 0; column < 4; ++column) {
      p[column][2] = plane[column] * scale - p[column][3];
    }
  }

  CameraSpec matrices() {
    const bool mirrored = random_.chance(0.1);
    const glm::dmat4 view = viewMatrix(mirrored);
    const std::uint32_t kind = random_.below(4);
    if (kind == 0) return {ViewProjection{view, orthographic()}, {}, "orthographic"};
    const bool infinite = random_.chance(0.4), reversed = random_.chance(0.3);
    glm::dmat4 projection = perspective(infinite, reversed);
    if (kind == 1) {
      projection[2][0] = random_.uniform(-1.5, 1.5);
      projection[2][1] = random_.uniform(-1.5, 1.5);
      return {ViewProjection{view, projection}, {}, "off-centre"};
    }
    if (kind == 2) {
      projection = perspective(false, false);
      makeOblique(projection, near());
      return {ViewProjection{view, projection}, {}, "oblique"};
    }
    return {ViewProjection{view, projection}, {}, mirrored ? "mirrored" : "perspective"};
  }

  ImageSize image() {
    switch (random_.below(6)) {
      case 0:
        return {1 + random_.below(64), 1 + random_.below(64)};
      case 1:
        return {333, 217};
      case 2:
        return {1920, 1080};
      default:
        return {320, 180};
    }
  }

  Random random_;
  const SceneSnapshot& scene_;
  std::vector<ObjectId> bounded_;
  std::vector<double> sizes_;
  double usual_size_ = 1.0;
};

}  // namespace

std::vector<CameraSpec> randomCameras(std::uint64_t seed, const SceneSnapshot& scene,
                                      std::size_t count) {
  CameraMaker maker(seed, scene);
  std::vector<CameraSpec> cameras;
  while (cameras.size() < count) cameras.push_back(maker.make());
  return cameras;
}

}  // namespace culld::scenes
