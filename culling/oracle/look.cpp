#include "culling/oracle/look.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <glm/vec2.hpp>

#include "culling/core/parallel.h"
#include "culling/oracle/aim.h"
#include "culling/oracle/lattice.h"

namespace culld::oracle {
namespace {

constexpr std::size_t kObjectsPerPart = 64;
// Points drawn per aimed ray, before giving up on a part outside of the frustum or seen from
// behind.
constexpr std::uint32_t kDrawsPerRay = 4;
// What the random numbers are for.
constexpr std::uint64_t kForSamples = 1, kForBeside = 2, kForAiming = 3;

/// Counts what its rays meet. Sums and flags only, so the order of threads leaves no trace.
class Look {
 public:
  Look(const RayView& view, const Camera& camera, const OracleOptions& options)
      : view_(view),
        options_(options),
        lattice_(camera, options.lattice, options.max_samples),
        pixel_ndc_(2.0 / camera.width_px, 2.0 / camera.height_px),
        tallies_(view.objects().size()) {}

  void sample();
  void aim();
  LookResult result() const;

 private:
  struct Tally {
    std::atomic<std::uint32_t> samples{0};
    std::atomic<std::uint32_t> rounds{0};
    std::atomic<std::uint32_t> last_round{0};  ///< that met it, counted from 1
    std::atomic<bool> tie{false};
    bool seen() const noexcept { return samples > 0 || rounds > 0; }
  };

  void sampleRow(std::size_t row, Hits& hits);
  void aimAtObject(std::uint32_t index, Hits& hits);
  void aimBesideObject(std::uint32_t index, Hits& hits);
  void remember(const Hits& hits);

  const RayView& view_;
  const OracleOptions& options_;
  Lattice lattice_;
  glm::dvec2 pixel_ndc_;
  std::vector<Tally> tallies_;
  std::uint32_t round_ = 0;  ///< under way or done last, counted from 1
  std::atomic<std::uint64_t> rays_{0};
};

/// After an aimed ray: an object counts once a round, however many rays of the round meet it.
void Look::remember(const Hits& hits) {
  for (const Hit& hit : hits.found) {
    Tally& tally = tallies_[hit.placed];
    if (hit.tie) {
      tally.tie.store(true, std::memory_order_relaxed);
    } else if (tally.last_round.load(std::memory_order_relaxed) != round_ &&
               tally.last_round.exchange(round_, std::memory_order_relaxed) != round_) {
      tally.rounds.fetch_add(1, std::memory_order_relaxed);
    }
  }
}

void Look::sampleRow(std::size_t row, Hits& hits) {
  Random random(options_.seed, kForSamples, row);
  std::vector<std::uint32_t> seen;
  for (std::size_t column = 0; column < lattice_.columns(); ++column) {
    const double x = ndcWithin(column, random.unit(), lattice_.columns());
    const double y = ndcWithin(row, random.unit(), lattice_.rows());
    const auto ray = view_.rays().through(x, y);
    if (!ray) continue;
    view_.trace(*ray, hits);
    seen.clear();  // an object counts once, whichever number of its surfaces the ray met
    for (const Hit& hit : hits.found) {
      Tally& tally = tallies_[hit.placed];
      if (hit.tie) {
        tally.tie.store(true, std::memory_order_relaxed);
      } else if (std::find(seen.begin(), seen.end(), hit.placed) == seen.end()) {
        seen.push_back(hit.placed);
        tally.samples.fetch_add(1, std::memory_order_relaxed);
      }
    }
  }
  rays_ += lattice_.columns();
}

void Look::sample() {
  parallelFor(
      partsOf(lattice_.rows(), kRowsPerPart),
      [this](std::size_t part) {
        Hits hits;
        const std::size_t end = std::min(lattice_.rows(), (part + 1) * kRowsPerPart);
        for (std::size_t row = part * kRowsPerPart; row < end; ++row) sampleRow(row, hits);
      },
      options_.threads);
}

void Look::aimAtObject(std::uint32_t index, Hits& hits) {
  const RayView::Placed& placed = view_.objects()[index];
  Random random(options_.seed, kForAiming + std::uint64_t{2} * round_, placed.object);
  std::uint64_t cast = 0;
  for (std::uint32_t number = 0; number < kAimedRaysPerRound; ++number) {
    for (std::uint32_t draw = 0; draw < kDrawsPerRay; ++draw) {
      const auto ray = aimAt(view_, placed, number, random);
      if (!ray) continue;
      view_.trace(*ray, hits);
      remember(hits);
      ++cast;
      break;
    }
  }
  rays_ += cast;
}

void Look::aimBesideObject(std::uint32_t index, Hits& hits) {
  const RayView::Placed& placed = view_.objects()[index];
  Random random(options_.seed, kForBeside + std::uint64_t{2} * round_, placed.object);
  std::uint64_t cast = 0;
  for (std::uint32_t draw = 0; draw < kDrawsPerRay * kAimedRaysPerRound; ++draw) {
    const auto ray = aimBeside(view_, placed, pixel_ndc_, random);
    if (!ray) continue;
    view_.trace(*ray, hits);
    remember(hits);
    ++cast;
  }
  rays_ += cast;
}

void Look::aim() {
  const std::uint32_t rounds =
      (options_.rays_per_object + kAimedRaysPerRound - 1) / kAimedRaysPerRound;
  while (round_ < rounds) {
    // Who is aimed at depends on whole rounds only, not on which thread was first.
    std::vector<bool> seen(tallies_.size());
    std::transform(tallies_.begin(), tallies_.end(), seen.begin(),
                   [](const Tally& tally) { return tally.seen(); });
    if (std::find(seen.begin(), seen.end(), false) == seen.end()) return;  // nothing left to find
    ++round_;
    parallelFor(
        partsOf(tallies_.size(), kObjectsPerPart),
        [&](std::size_t part) {
          Hits hits;
          const std::size_t end = std::min(tallies_.size(), (part + 1) * kObjectsPerPart);
          for (std::size_t i = part * kObjectsPerPart; i < end; ++i) {
            const auto index = static_cast<std::uint32_t>(i);
            // Also when an earlier round has found it: rounds that find alike can be compared.
            if (tallies_[i].samples == 0) aimAtObject(index, hits);
            if (seen[i]) aimBesideObject(index, hits);
          }
        },
        options_.threads);
  }
}

LookResult Look::result() const {
  LookResult result;
  result.pixels_per_sample = lattice_.pixelsPerSample();
  result.rounds = round_;
  result.rays = rays_;
  result.objects.reserve(tallies_.size());
  for (std::size_t i = 0; i < tallies_.size(); ++i) {
    const Tally& tally = tallies_[i];
    result.objects.push_back({view_.objects()[i].object, tally.samples, tally.rounds, tally.tie});
  }
  return result;
}

}  // namespace

LookResult lookFrom(const RayView& view, const Camera& camera, const OracleOptions& options) {
  Look look(view, camera, options);
  look.sample();
  look.aim();
  return look.result();
}

}  // namespace culld::oracle
