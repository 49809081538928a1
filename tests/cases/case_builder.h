// Puts one case together, as seen by an eye at the origin that looks along -z: then turns and moves
// all of it, so that no number is a round one by luck.
#pragma once
#include <cstdint>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <string>
#include <utility>
#include <vector>

#include "culling/core/ids.h"
#include "culling/scene/scene_snapshot.h"
#include "tests/scenes/camera_spec.h"
#include "tests/scenes/model.h"
#include "tests/scenes/random.h"
#include "tests/scenes/shapes.h"

namespace culld::cases {

struct Case {
  SnapshotPtr scene;
  std::vector<scenes::CameraSpec> cameras;  ///< valid ones
  std::vector<scenes::CameraSpec> refused;  ///< no camera may come of these, but a message
};

inline constexpr ImageSize kCaseImage{320, 180};

/// Where the camera of a case looks, and how its things are made. Lengths across the image are in
/// halves of its height at that distance.
struct Sight {
  double distance_m = 10.0;  ///< of the wall
  double tan_half = 0.5;     ///< half the image's height, per metre ahead
  bool parallel = false;     ///< orthographic: tan_half is the half height itself
  glm::dvec2 slope{0.0};     ///< of the ray through the image's middle, per metre ahead
  /// Within [-1,1]^2 at z = 0, front to +z.
  scenes::Triangles wall = scenes::quad({-1, -1, 0}, {2, 0, 0}, {0, 2, 0});
  scenes::Rows oddity = scenes::kIdentity;  ///< applied to every mesh before it is placed
  float mesh_scale = 1.0F;                  ///< of the meshes' numbers; the nodes scale back
  double thing_scale = 1.0;                 ///< of the things, not of the wall

  double half(double depth_m) const { return parallel ? tan_half : tan_half * depth_m; }
};

class CaseBuilder {
 public:
  explicit CaseBuilder(std::uint64_t seed);

  scenes::Random& random() { return random_; }
  scenes::Model& model() { return model_; }
  std::uint64_t seed() const { return seed_; }

  /// Everything moves there; what was added stays.
  void moveTo(const glm::dvec3& offset);
  /// Of the objects that follow.
  void made(scenes::Alpha alpha, bool double_sided);
  ObjectId add(scenes::Triangles shape, const scenes::Rows& rows = scenes::kIdentity);
  /// One more object of the last mesh.
  ObjectId again(const scenes::Rows& rows);
  /// Takes the place of the model: a scene from elsewhere. The frame is not applied to it.
  void use(SnapshotPtr scene) { scene_ = std::move(scene); }

  /// Poses and matrices as if nothing had been turned or moved.
  LookAt placed(LookAt look) const;
  void look(LookAt look, ImageSize image = kCaseImage, std::string what = "look-at");
  void matrices(const glm::dmat4& view, const glm::dmat4& projection, ImageSize image = kCaseImage,
                std::string what = "matrices");
  /// A camera that is not turned and moved, for a scene from elsewhere.
  void absolute(const LookAt& look, std::string what) {
    case_.cameras.push_back({look, kCaseImage, std::move(what)});
  }
  void refuses(const scenes::CameraSpec& spec) { case_.refused.push_back(spec); }

  Case done();

 private:
  std::uint64_t seed_;
  scenes::Random random_;
  scenes::Rows frame_ = scenes::kIdentity;  // rigid
  std::uint32_t material_ = 0;
  scenes::Model model_;
  SnapshotPtr scene_;
  Case case_;
};

/// A box of that size (half side, in half images) at a place of the image.
scenes::Rows placed(const Sight& sight, double depth_m, const glm::dvec2& at, double size);

void addWall(CaseBuilder& builder, const Sight& sight);
/// One small square at the image's middle.
ObjectId addThing(CaseBuilder& builder, const Sight& sight, double depth_m);
/// Things behind a wall of 0.6 half images, at its rim, before it and beside it.
void addThings(CaseBuilder& builder, const Sight& sight);
/// Boxes and walls all around the origin.
void addClutter(CaseBuilder& builder, std::uint32_t count, double radius_m);

}  // namespace culld::cases
