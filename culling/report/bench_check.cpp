#include "culling/report/bench_check.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "culling/report/svg.h"

namespace culld::report {
namespace {

// A lattice of one sample a pixel finds whatever fills a pixel: the least that `sampled` promises.
constexpr double kSampledHolePx = 1.0;
// Samples along the side of a hole when a square of that side is looked for.
constexpr double kSamplesPerHole = 4.0;
constexpr double kMaxPaintedPixels = 1U << 24U;

struct Missed {
  ObjectId object = 0;
  double pixels = 0.0;
  bool subpixel = false;
};

std::vector<Missed> missedBy(const Answer& answer, const OracleAnswer& truth) {
  std::vector<Missed> missed;
  auto next = answer.visible.begin();
  for (std::size_t i = 0; i < truth.visible.size(); ++i) {
    const ObjectId id = truth.visible[i];
    next = std::lower_bound(next, answer.visible.end(), id);
    if (next != answer.visible.end() && *next == id) continue;
    missed.push_back({id, static_cast<double>(truth.pixels[i]), truth.subpixel[i] != 0});
  }
  return missed;
}

std::string named(const SceneSnapshot& scene, const Missed& missed) {
  const Instance& instance = scene.instance(missed.object);
  std::string text = "object " + std::to_string(missed.object) + " (node " +
                     std::to_string(instance.node) + ", instance " +
                     std::to_string(instance.instance_number) + ") is visible ";
  text += missed.subpixel ? "below a pixel" : "in " + shortNumber(missed.pixels) + " px";
  return text + " and was left out";
}

std::string malformed(const SceneSnapshot& scene, const Answer& answer) {
  const auto& ids = answer.visible;
  const auto bad = std::adjacent_find(ids.begin(), ids.end(), std::greater_equal<>());
  if (bad != ids.end()) return "ids are not ascending and unique at " + std::to_string(*bad);
  if (!ids.empty() && ids.back() >= scene.objectCount()) {
    return "object " + std::to_string(ids.back()) + " is not in the scene";
  }
  if (!answer.seen.empty() && answer.seen.size() != ids.size()) {
    return "seen marks are not one per object";
  }
  return "";
}

/// The largest of what a hole of that side must not lose, if it was lost.
std::string lostSquare(const Asked& asked, const std::vector<Missed>& missed, double hole_px) {
  for (const Missed& object : missed) {
    if (object.pixels < hole_px * hole_px) continue;  // cannot hold such a square
    const auto side =
        largestSquarePx(asked.oracle, asked.camera, object.object, kSamplesPerHole / hole_px);
    if (!side || side.value() < hole_px) continue;
    return named(asked.scene, object) + ", although it fills a square of side " +
           shortNumber(side.value()) + " px";
  }
  return "";
}

std::string brokenBound(const Asked& asked, const Answer& answer, double missed_px) {
  // So many pixels by samples that were hit at random: three standard deviations of that number.
  const double doubt_px = 3.0 * std::sqrt(missed_px) / std::max(1U, asked.options.lattice);
  if (!answer.proven || missed_px - doubt_px <= static_cast<double>(answer.missed_px)) return "";
  return shortNumber(missed_px) + " px were missed, more than the proven bound of " +
         shortNumber(static_cast<double>(answer.missed_px)) + " px";
}

std::string breachOf(const Asked& asked, const Answer& answer, const std::vector<Missed>& missed,
                     double missed_px) {
  const Guarantee given = answer.guarantee;
  if (given > asked.demand.guarantee) {
    return "the answer is " + std::string(guaranteeName(given)) + ", not " +
           std::string(guaranteeName(asked.demand.guarantee));
  }
  if (given == Guarantee::kApproximate) return brokenBound(asked, answer, missed_px);
  if (missed.empty()) return "";
  if (given == Guarantee::kSampled) return lostSquare(asked, missed, kSampledHolePx);
  const auto hole_px = static_cast<double>(asked.demand.hole_px);
  if (given == Guarantee::kHole && hole_px > 0.0) return lostSquare(asked, missed, hole_px);
  const auto most =
      std::max_element(missed.begin(), missed.end(),
                       [](const Missed& a, const Missed& b) { return a.pixels < b.pixels; });
  return named(asked.scene, *most);
}

}  // namespace

Checked checkAnswer(const Asked& asked, const Answer& answer) {
  Checked checked;
  checked.breach = malformed(asked.scene, answer);
  checked.malformed = !checked.breach.empty();
  if (checked.malformed) return checked;
  const std::vector<Missed> missed = missedBy(answer, asked.truth);
  for (const Missed& object : missed) {
    ++(object.subpixel ? checked.missed_subpixel : checked.missed);
    checked.missed_px += object.pixels;
  }
  checked.breach = breachOf(asked, answer, missed, checked.missed_px);
  return checked;
}

Result<double> largestSquarePx(const Oracle& oracle, const Camera& camera, ObjectId object,
                               double per_px) {
  Camera fine = camera;
  const double pixels = static_cast<double>(camera.width_px) * camera.height_px;
  const double most = std::sqrt(kMaxPaintedPixels / pixels);
  const double scale = std::floor(std::min(std::max(1.0, std::ceil(per_px)), most));
  if (!(scale >= 1.0)) return 0.0;
  fine.width_px = static_cast<std::uint32_t>(camera.width_px * scale);
  fine.height_px = static_cast<std::uint32_t>(camera.height_px * scale);
  const auto painted = oracle.paint(fine);
  if (!painted) return painted.error();
  // side[x]: of the largest square of samples that ends at (x, y); `corner` was side[x - 1] above.
  std::vector<std::uint32_t> side(std::size_t{fine.width_px} + 1, 0);
  std::uint32_t largest = 0;
  for (std::size_t y = 0; y < fine.height_px; ++y) {
    std::uint32_t corner = 0;
    for (std::size_t x = 0; x < fine.width_px; ++x) {
      const std::uint32_t above = side[x + 1];
      const bool shows = painted.value()[y * fine.width_px + x].object == object;
      side[x + 1] = shows ? 1 + std::min({corner, above, side[x]}) : 0;
      corner = above;
      largest = std::max(largest, side[x + 1]);
    }
  }
  return largest == 0 ? 0.0 : static_cast<double>(largest - 1) / scale;
}

}  // namespace culld::report
