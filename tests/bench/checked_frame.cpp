#include "tests/bench/checked_frame.h"

#include <algorithm>
#include <chrono>

#include "culling/report/frame_picture.h"

namespace culld::bench {
namespace {

constexpr std::size_t kMaxExamples = 8;

std::uint64_t trianglesOf(const SceneSnapshot& scene, const std::vector<ObjectId>& objects) {
  std::uint64_t sum = 0;
  for (const ObjectId id : objects) sum += scene.mesh(scene.instance(id).mesh).triangles.size();
  return sum;
}

void addMissed(const SceneSnapshot& scene, const std::vector<ObjectId>& answered,
               CheckedFrame& frame) {
  const OracleAnswer& truth = frame.truth;
  for (std::size_t i = 0; i < truth.visible.size(); ++i) {
    const ObjectId id = truth.visible[i];
    if (std::binary_search(answered.begin(), answered.end(), id)) continue;
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
                                const Oracle& oracle, const OracleOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  auto truth = oracle.look(inputs.cameras[answered.camera], options);
  if (!truth) return std::move(truth).error();
  CheckedFrame frame;
  frame.camera = answered.camera;
  frame.truth = std::move(truth).value();
  addMissed(*inputs.scene, answered.visible, frame);
  const OracleAnswer& seen = frame.truth;
  frame.rays = seen.rays;
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
