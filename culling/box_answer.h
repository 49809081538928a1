// What methods that cull with boxes do alike, whatever they leave out in between.
#pragma once
#include <string>
#include <string_view>

#include "culling/core/clock.h"
#include "culling/culler.h"
#include "culling/spatial/frustum_walk.h"
#include "culling/spatial/prepared_boxes.h"

namespace culld {

/// The boxes that a culler lends to another method's culler of the same snapshot; nullptr if none.
const PreparedBoxes* boxesOf(const Culler& culler) noexcept;

/// Appends all that the frustum may hold, in no particular order, and counts the work. `note`: why
/// no more is left out.
void answerFrustum(const PreparedBoxes& boxes, const Camera& camera, const Deadline& deadline,
                   std::string_view note, Answer& answer);

/// Counts the work of a walk whose finds are answer.visible, of so many live objects with a bound.
void countFrustum(const FrustumWalkStats& walk, std::size_t live, std::size_t always_kept,
                  Answer& answer);

/// Completes what a walk has found: the objects without a bound, ascending ids, their counts, and
/// the note of `method` if it was cut short.
void completeAnswer(const PreparedBoxes& boxes, std::string_view method, Answer& answer);

/// The answer of `method`: what run(deadline, answer) appends to answer.visible; or, if that
/// returns a reason why occlusion cannot be looked for instead, all in the frustum.
template <typename Run>
Answer answerBy(std::string_view method, const PreparedBoxes& boxes, const Clock& clock,
                const Camera& camera, const Demand& demand, const Run& run) {
  const auto start = clock.now();
  const Deadline deadline(clock, start, demand.time);
  Answer answer;
  const std::string_view why_not = run(deadline, answer);
  if (!why_not.empty()) {
    const std::string note =
        std::string(method) + ": " + std::string(why_not) + ", occlusion is left out";
    answerFrustum(boxes, camera, deadline, note, answer);
  }
  completeAnswer(boxes, method, answer);
  answer.stats.time = clock.now() - start;
  return answer;
}

}  // namespace culld
