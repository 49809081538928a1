#include "culling/oracle/oracle.h"

#include <algorithm>
#include <glm/geometric.hpp>

#include "culling/core/parallel.h"
#include "culling/oracle/lattice.h"
#include "culling/oracle/look.h"
#include "culling/oracle/poses.h"
#include "culling/oracle/ray_scene.h"

namespace culld {
namespace {

using oracle::Hits;
using oracle::LookResult;
using oracle::RayView;
using oracle::Sighting;

/// What the looks from all poses saw, together.
class Union {
 public:
  explicit Union(std::size_t objects) : seen_(objects) {}

  void add(const LookResult& look) {
    ++poses_;
    rays_ += look.rays;
    rounds_ = std::max(rounds_, look.rounds);
    for (const Sighting& sighting : look.objects) {
      Seen& seen = seen_[sighting.object];
      seen.in_frustum = true;
      seen.tie = seen.tie || sighting.tie;
      seen.rounds += sighting.rounds;
      seen.poses += sighting.seen() ? 1U : 0U;
      seen.pixels =
          std::max(seen.pixels, static_cast<float>(sighting.samples * look.pixels_per_sample));
    }
  }

  OracleAnswer answer() const {
    OracleAnswer answer;
    answer.poses = poses_;
    answer.rays = rays_;
    UnfoundEstimate& by_rays = answer.unfound_by_rays;
    UnfoundEstimate& by_poses = answer.unfound_by_poses;
    by_rays.tries = rounds_;
    by_poses.tries = poses_ > 1 ? poses_ : 0;
    for (ObjectId object = 0; object < seen_.size(); ++object) {
      const Seen& seen = seen_[object];
      if (!seen.in_frustum) continue;
      answer.in_frustum.push_back(object);
      count(by_poses, seen.poses);
      if (seen.pixels == 0.0F) count(by_rays, seen.rounds);
      if (seen.poses == 0) {
        if (seen.tie) answer.ties.push_back(object);
        continue;
      }
      answer.visible.push_back(object);
      answer.pixels.push_back(seen.pixels);
      answer.subpixel.push_back(seen.pixels == 0.0F ? 1 : 0);
    }
    return answer;
  }

 private:
  struct Seen {
    float pixels = 0.0F;
    std::uint32_t rounds = 0;
    std::uint32_t poses = 0;  ///< that saw it
    bool in_frustum = false, tie = false;
  };

  static void count(UnfoundEstimate& estimate, std::uint32_t found) {
    estimate.not_found += found == 0 ? 1U : 0U;
    estimate.found_once += found == 1 ? 1U : 0U;
  }

  std::vector<Seen> seen_;
  std::uint32_t poses_ = 0, rounds_ = 0;
  std::uint64_t rays_ = 0;
};

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

double UnfoundEstimate::byOneMoreTry() const noexcept {
  if (tries == 0) return 0.0;
  const double once = static_cast<double>(found_once);
  return std::min(static_cast<double>(not_found), once / static_cast<double>(tries));
}

double UnfoundEstimate::byAnyNumber() const noexcept {
  if (tries == 0) return 0.0;
  // Twice: for chances to be found whose density falls like 1 / sqrt(chance), see docs/oracle.md.
  return std::min(static_cast<double>(not_found), 2.0 * static_cast<double>(found_once));
}

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
  Union seen(parts_->scene->snapshot().objectCount());
  OracleOptions of_pose = options;
  for (const Camera& pose : oracle::posesWithin(camera, options.poses, options.seed)) {
    const auto view = RayView::build(*parts_->scene, pose);
    if (!view) return view.error();
    seen.add(oracle::lookFrom(*view.value(), pose, of_pose));
    ++of_pose.seed;  // other places within the pixels
  }
  return seen.answer();
}

Result<std::vector<OraclePixel>> Oracle::paint(const Camera& camera, std::size_t threads) const {
  const auto view = RayView::build(*parts_->scene, camera);
  if (!view) return view.error();
  const RayView& rays = *view.value();
  const std::size_t width = camera.width_px, height = camera.height_px;
  std::vector<OraclePixel> pixels(width * height);
  parallelFor(
      oracle::partsOf(height, oracle::kRowsPerPart),
      [&](std::size_t part) {
        Hits hits;
        const std::size_t end = std::min(height, (part + 1) * oracle::kRowsPerPart);
        for (std::size_t row = part * oracle::kRowsPerPart; row < end; ++row) {
          for (std::size_t column = 0; column < width; ++column) {
            const auto ray = rays.rays().through(oracle::ndcWithin(column, 0.5, width),
                                                 -oracle::ndcWithin(row, 0.5, height));
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
