#include "tests/bench/checked_frame.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <glm/ext/matrix_transform.hpp>
#include <glm/geometric.hpp>
#include <random>

#include "culling/report/frame_picture.h"

namespace culld::bench {
namespace {

constexpr std::size_t kMaxExamples = 8;

glm::dvec3 randomDirection(std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  const glm::dvec3 v(normal(random), normal(random), normal(random));
  return v / glm::length(v);
}

/// The same camera elsewhere on the rim of its motion bound.
Camera poseWithin(const Camera& camera, std::mt19937_64& random) {
  Camera moved = camera;
  moved.origin_world += camera.motion.radius_m * randomDirection(random);
  const glm::dmat3 turn(
      glm::rotate(glm::dmat4(1.0), camera.motion.angle_rad, randomDirection(random)));
  for (glm::dvec4* row : {&moved.x_row, &moved.y_row, &moved.z_row, &moved.w_row, &moved.near_row,
                          &moved.near_cut_row, &moved.far_cut_row}) {
    *row = glm::dvec4(turn * glm::dvec3(*row), row->w);
  }
  return moved;
}

std::uint64_t trianglesOf(const SceneSnapshot& scene, const std::vector<ObjectId>& objects) {
  std::uint64_t sum = 0;
  for (const ObjectId id : objects) sum += scene.mesh(scene.instance(id).mesh).triangles.size();
  return sum;
}

/// Adds what `truth` sees and `answered` lacks; each object counts once over all poses.
void addMissed(const SceneSnapshot& scene, const OracleAnswer& truth,
               const std::vector<ObjectId>& answered, std::vector<ObjectId>& known,
               CheckedFrame& frame) {
  for (std::size_t i = 0; i < truth.visible.size(); ++i) {
    const ObjectId id = truth.visible[i];
    if (std::binary_search(answered.begin(), answered.end(), id)) continue;
    if (std::find(known.begin(), known.end(), id) != known.end()) continue;
    known.push_back(id);
    (truth.subpixel[i] != 0 ? frame.missed_subpixel : frame.missed) += 1;
    frame.missed_px += static_cast<double>(truth.pixels[i]);
    const Instance& instance = scene.instance(id);
    if (frame.examples.size() < kMaxExamples) {
      frame.examples.push_back({instance.node, instance.instance_number, truth.pixels[i]});
    }
  }
}

}  // namespace

Result<CheckedFrame> checkFrame(const Inputs& inputs, const AnsweredFrame& answered,
                                const Oracle& oracle, const OracleOptions& options,
                                std::uint32_t poses) {
  const Camera& camera = inputs.cameras[answered.camera];
  const auto start = std::chrono::steady_clock::now();
  auto truth = oracle.look(camera, options);
  if (!truth) return std::move(truth).error();
  CheckedFrame frame;
  frame.camera = answered.camera;
  frame.truth = std::move(truth).value();
  std::vector<ObjectId> missed;
  addMissed(*inputs.scene, frame.truth, answered.visible, missed, frame);
  frame.rays = frame.truth.rays;
  std::mt19937_64 random(answered.camera);
  for (std::uint32_t pose = 0; pose < poses && !camera.motion.still(); ++pose) {
    const auto other = oracle.look(poseWithin(camera, random), options);
    if (!other) return other.error();
    addMissed(*inputs.scene, other.value(), answered.visible, missed, frame);
    frame.rays += other.value().rays;
  }
  const OracleAnswer& seen = frame.truth;
  frame.in_frustum = seen.in_frustum.size();
  frame.answered = answered.visible.size();
  frame.visible = seen.visible.size();
  frame.visible_subpixel = static_cast<std::size_t>(
      std::count(seen.subpixel.begin(), seen.subpixel.end(), std::uint8_t{1}));
  frame.ties_left_out =
      static_cast<std::size_t>(std::count_if(seen.ties.begin(), seen.ties.end(), [&](ObjectId id) {
        return !std::binary_search(answered.visible.begin(), answered.visible.end(), id);
      }));
  frame.frustum_triangles = trianglesOf(*inputs.scene, seen.in_frustum);
  frame.answered_triangles = trianglesOf(*inputs.scene, answered.visible);
  frame.last_round_found = seen.last_round_found;
  frame.last_round_tried = seen.last_round_tried;
  frame.oracle_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return frame;
}

Result<void> drawFrame(const Inputs& inputs, const AnsweredFrame& answered,
                       const CheckedFrame& checked, const Oracle& oracle, const std::string& dir) {
  const std::vector<Verdict> verdicts = judge(*inputs.scene, checked.truth, answered.visible);
  std::string number = std::to_string(answered.camera);
  number.insert(0, number.size() < 3 ? 3 - number.size() : 0, '0');
  const FrameToDraw frame{
      inputs.scene.get(), &oracle, inputs.cameras[answered.camera], verdicts,
      inputs.name + ", camera " + std::to_string(answered.camera) + ", method " + inputs.method};
  if (auto drawn = drawFromCamera(frame, dir + "/camera-" + number + ".png"); !drawn) return drawn;
  return drawFromAbove(frame, dir + "/above-" + number + ".png");
}

}  // namespace culld::bench
