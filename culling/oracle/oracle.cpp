#include "culling/oracle/oracle.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

#include "culling/core/parallel.h"
#include "culling/oracle/aim.h"
#include "culling/oracle/ray_scene.h"

namespace culld {
namespace {

using oracle::Hits;
using oracle::Random;
using oracle::RayView;

constexpr std::size_t kRowsPerPart = 4;
constexpr std::size_t kObjectsPerPart = 64;
// Points drawn per aimed ray, before giving up on a part outside of the frustum or seen from
// behind.
constexpr std::uint32_t kDrawsPerRay = 4;
// What the random numbers are for.
constexpr std::uint64_t kForSamples = 1, kForBeside = 2, kForAiming = 3;

std::size_t partsOf(std::size_t count, std::size_t size) { return (count + size - 1) / size; }

/// Runs over the samples of an image in parts of a few rows, each part with its own scratch.
class Lattice {
 public:
  Lattice(const Camera& camera, const OracleOptions& options) {
    const double side = std::max(1U, options.lattice);
    const double wanted = side * camera.width_px * side * camera.height_px;
    const double most = static_cast<double>(std::max<std::uint64_t>(1, options.max_samples));
    const double thin = std::min(1.0, std::sqrt(most / wanted));
    columns_ = static_cast<std::size_t>(std::max(1.0, std::floor(side * camera.width_px * thin)));
    rows_ = static_cast<std::size_t>(std::max(1.0, std::floor(side * camera.height_px * thin)));
    pixels_per_sample_ = static_cast<double>(camera.width_px) * camera.height_px /
                         static_cast<double>(columns_ * rows_);
  }
  std::size_t columns() const { return columns_; }
  std::size_t rows() const { return rows_; }
  double pixelsPerSample() const { return pixels_per_sample_; }
  static double ndc(std::size_t cell, double within, std::size_t cells) {
    return (static_cast<double>(cell) + within) / static_cast<double>(cells) * 2.0 - 1.0;
  }

 private:
  std::size_t columns_ = 1, rows_ = 1;
  double pixels_per_sample_ = 1.0;
};

/// One look: counts what its rays meet. Sums and flags only, so the order of threads leaves no
/// trace.
class Look {
 public:
  Look(const RayView& view, const Camera& camera, const OracleOptions& options)
      : view_(view),
        options_(options),
        lattice_(camera, options),
        pixel_ndc_(2.0 / camera.width_px, 2.0 / camera.height_px),
        samples_(view.objects().size()),
        state_(view.objects().size()) {}

  void sample();
  void aim();
  OracleAnswer answer() const;

 private:
  enum State : std::uint8_t { kUnseen = 0, kTie = 1, kSeen = 2 };

  void sampleRow(std::size_t row, Hits& hits);
  void aimAtObject(std::uint32_t index, std::uint32_t first_ray, Hits& hits);
  void aimBesideObject(std::uint32_t index, std::uint32_t first_ray, Hits& hits);
  void remember(const Hits& hits);
  void raise(std::uint32_t index, State to);

  const RayView& view_;
  const OracleOptions& options_;
  Lattice lattice_;
  glm::dvec2 pixel_ndc_;
  std::vector<std::atomic<std::uint32_t>> samples_;
  std::vector<std::atomic<std::uint8_t>> state_;
  std::atomic<std::uint64_t> rays_{0};
  std::size_t last_found_ = 0, last_tried_ = 0;
};

void Look::raise(std::uint32_t index, State to) {
  std::uint8_t was = state_[index].load(std::memory_order_relaxed);
  while (was < to && !state_[index].compare_exchange_weak(was, to, std::memory_order_relaxed)) {
  }
}

void Look::remember(const Hits& hits) {
  for (const oracle::Hit& hit : hits.found) raise(hit.placed, hit.tie ? kTie : kSeen);
}

void Look::sampleRow(std::size_t row, Hits& hits) {
  Random random(options_.seed, kForSamples, row);
  std::vector<std::uint32_t> seen;
  for (std::size_t column = 0; column < lattice_.columns(); ++column) {
    const double x = Lattice::ndc(column, random.unit(), lattice_.columns());
    const double y = Lattice::ndc(row, random.unit(), lattice_.rows());
    const auto ray = view_.rays().through(x, y);
    if (!ray) continue;
    view_.trace(*ray, hits);
    remember(hits);
    seen.clear();  // an object counts once, whichever number of its surfaces the ray met
    for (const oracle::Hit& hit : hits.found) {
      if (!hit.tie && std::find(seen.begin(), seen.end(), hit.placed) == seen.end()) {
        seen.push_back(hit.placed);
        samples_[hit.placed].fetch_add(1, std::memory_order_relaxed);
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

void Look::aimAtObject(std::uint32_t index, std::uint32_t first_ray, Hits& hits) {
  const RayView::Placed& placed = view_.objects()[index];
  Random random(options_.seed, kForAiming + 2U * first_ray, placed.object);
  const std::uint32_t end = std::min(first_ray + kAimedRaysPerRound, options_.rays_per_object);
  std::uint64_t cast = 0;
  for (std::uint32_t number = first_ray; number < end; ++number) {
    for (std::uint32_t draw = 0; draw < kDrawsPerRay; ++draw) {
      const auto ray = oracle::aimAt(view_, placed, number, random);
      if (!ray) continue;
      view_.trace(*ray, hits);
      remember(hits);
      ++cast;
      break;
    }
  }
  rays_ += cast;
}

void Look::aimBesideObject(std::uint32_t index, std::uint32_t first_ray, Hits& hits) {
  const RayView::Placed& placed = view_.objects()[index];
  Random random(options_.seed, kForBeside + 2U * first_ray, placed.object);
  std::uint64_t cast = 0;
  for (std::uint32_t draw = 0; draw < kDrawsPerRay * kAimedRaysPerRound; ++draw) {
    const auto ray = oracle::aimBeside(view_, placed, pixel_ndc_, random);
    if (!ray) continue;
    view_.trace(*ray, hits);
    remember(hits);
    ++cast;
  }
  rays_ += cast;
}

void Look::aim() {
  // By rounds: who is aimed at depends on whole rounds only, not on which thread was first.
  for (std::uint32_t ray = 0; ray < options_.rays_per_object; ray += kAimedRaysPerRound) {
    const std::vector<std::uint8_t> before(state_.begin(), state_.end());
    const auto tried = static_cast<std::size_t>(
        std::count_if(before.begin(), before.end(), [](std::uint8_t s) { return s != kSeen; }));
    if (tried == 0) return;
    parallelFor(
        partsOf(before.size(), kObjectsPerPart),
        [&](std::size_t part) {
          Hits hits;
          const std::size_t end = std::min(before.size(), (part + 1) * kObjectsPerPart);
          for (std::size_t i = part * kObjectsPerPart; i < end; ++i) {
            const auto index = static_cast<std::uint32_t>(i);
            before[i] == kSeen ? aimBesideObject(index, ray, hits) : aimAtObject(index, ray, hits);
          }
        },
        options_.threads);
    last_tried_ = tried;
    last_found_ =
        tried - static_cast<std::size_t>(std::count_if(state_.begin(), state_.end(),
                                                       [](const auto& s) { return s != kSeen; }));
  }
}

OracleAnswer Look::answer() const {
  OracleAnswer answer;
  answer.rays = rays_;
  answer.last_round_found = last_found_;
  answer.last_round_tried = last_tried_;
  for (std::uint32_t i = 0; i < state_.size(); ++i) {
    const ObjectId object = view_.objects()[i].object;
    answer.in_frustum.push_back(object);
    if (state_[i] == kTie) answer.ties.push_back(object);
    if (state_[i] != kSeen) continue;
    const std::uint32_t samples = samples_[i];
    answer.visible.push_back(object);
    answer.pixels.push_back(static_cast<float>(samples * lattice_.pixelsPerSample()));
    answer.subpixel.push_back(samples == 0 ? 1 : 0);
  }
  return answer;
}

OraclePixel pixelOf(const RayView& view, const oracle::Ray& ray, const Hits& hits) {
  const auto nearest = std::min_element(
      hits.found.begin(), hits.found.end(),
      [](const auto& a, const auto& b) { return a.t != b.t ? a.t < b.t : a.placed < b.placed; });
  if (nearest == hits.found.end()) return {};
  const RayView::Placed& placed = view.objects()[nearest->placed];
  const oracle::Triangle corners = placed.mesh->triangle(nearest->triangle);
  const glm::dvec3 normal =
      glm::normalize(glm::cross(placed.world_from_mesh * (corners[1] - corners[0]),
                                placed.world_from_mesh * (corners[2] - corners[0])));
  const double towards = glm::dot(normal, ray.direction) > 0.0 ? -1.0 : 1.0;
  return {placed.object, static_cast<float>(nearest->t * glm::length(ray.direction)),
          glm::vec3(towards * normal)};
}

}  // namespace

struct Oracle::Parts {
  std::unique_ptr<oracle::RayScene> scene;
};

Oracle::Oracle(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
Oracle::~Oracle() = default;

Result<std::unique_ptr<Oracle>> Oracle::build(SnapshotPtr scene) {
  auto built = oracle::RayScene::build(std::move(scene));
  if (!built) return std::move(built).error();
  auto parts = std::make_unique<Parts>();
  parts->scene = std::move(built).value();
  return std::unique_ptr<Oracle>(new Oracle(std::move(parts)));
}

Result<OracleAnswer> Oracle::look(const Camera& camera, const OracleOptions& options) const {
  const auto view = RayView::build(*parts_->scene, camera);
  if (!view) return view.error();
  Look look(*view.value(), camera, options);
  look.sample();
  look.aim();
  return look.answer();
}

Result<std::vector<OraclePixel>> Oracle::paint(const Camera& camera, std::size_t threads) const {
  const auto view = RayView::build(*parts_->scene, camera);
  if (!view) return view.error();
  const RayView& rays = *view.value();
  const std::size_t width = camera.width_px, height = camera.height_px;
  std::vector<OraclePixel> pixels(width * height);
  parallelFor(
      partsOf(height, kRowsPerPart),
      [&](std::size_t part) {
        Hits hits;
        const std::size_t end = std::min(height, (part + 1) * kRowsPerPart);
        for (std::size_t row = part * kRowsPerPart; row < end; ++row) {
          for (std::size_t column = 0; column < width; ++column) {
            const auto ray = rays.rays().through(Lattice::ndc(column, 0.5, width),
                                                 -Lattice::ndc(row, 0.5, height));
            if (!ray) continue;
            rays.trace(*ray, hits);
            pixels[row * width + column] = pixelOf(rays, *ray, hits);
          }
        }
      },
      threads);
  return pixels;
}

}  // namespace culld
