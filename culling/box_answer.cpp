#include "culling/box_answer.h"

#include <string>

#include "culling/spatial/frustum_test.h"
#include "culling/spatial/frustum_walk.h"

namespace culld {

const PreparedBoxes* boxesOf(const Culler& culler) noexcept {
  const auto* holder = dynamic_cast<const HoldsBoxes*>(&culler);
  return holder == nullptr ? nullptr : holder->boxes();
}

void answerFrustum(const PreparedBoxes& boxes, const Camera& camera, const Deadline& deadline,
                   std::string_view note, Answer& answer) {
  const WideBvh& bvh = boxes.bvh();
  const FrustumWalkStats walk =
      appendInFrustum(bvh, FrustumTest(camera, bvh), deadline, answer.visible);
  countFrustum(walk, bvh.liveObjects(), bvh.alwaysKept().size(), answer);
  answer.note = note;
}

void countFrustum(const FrustumWalkStats& walk, std::size_t live, std::size_t always_kept,
                  Answer& answer) {
  const std::size_t found = answer.visible.size();
  answer.stats.nodes_visited = walk.nodes_visited;
  answer.stats.tested = walk.tested;
  answer.stats.plane_tests = walk.plane_tests;
  answer.stats.outside = static_cast<std::uint32_t>(live - found);
  answer.stats.in_frustum = static_cast<std::uint32_t>(found);
  answer.stats.work = walk.work(found + always_kept);
  answer.out_of_budget = walk.out_of_time;
}

void completeAnswer(const PreparedBoxes& boxes, std::string_view method, Answer& answer) {
  boxes.completeIds(answer.visible);
  CullStats& stats = answer.stats;
  stats.always_kept = static_cast<std::uint32_t>(boxes.bvh().alwaysKept().size());
  // 0 stands for not counted: by who ran out of time, or stopped as some loss is accepted.
  const bool counted_all = !answer.out_of_budget && answer.guarantee != Guarantee::kApproximate;
  if (stats.in_frustum != 0 || counted_all) stats.in_frustum += stats.always_kept;
  if (answer.out_of_budget) {
    answer.note = std::string(method) + ": out of time or work, undecided objects are kept";
  }
}

}  // namespace culld
