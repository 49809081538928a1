#include "culling/pairs/pairs.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "culling/pairs/blocker.h"
#include "culling/pairs/segment_tree.h"

namespace culld {
namespace {

constexpr double kFarthest = 1e100;
constexpr std::size_t kMostTried = 256;    ///< occluders per pair: what hides is mostly found soon
constexpr std::size_t kPairsPerLook = 64;  ///< at the clock

double surfaceOf(const Box& box) {
  const glm::dvec3 size = box.max - box.min;
  return size.x * size.y + size.y * size.z + size.z * size.x;
}

struct Candidate {
  ObjectId object;
  std::uint32_t piece;
};

Result<std::vector<PlaceCorners>> cornersOfAll(std::span<const Place> places, const char* what) {
  std::vector<PlaceCorners> out;
  out.reserve(places.size());
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Place& place = places[i];
    const auto wrong = [&](const char* why) {
      return invalidInput(std::string(what) + " " + std::to_string(i) + ": " + why);
    };
    if (place.box.empty()) return wrong("an empty box");
    if (!(place.radius_m >= 0.0 && place.radius_m <= kFarthest)) {
      return wrong("the radius is not a number from 0 to 1e100 m");
    }
    out.push_back(culld::cornersOf(place));
    if (!(out.back().largest <= 2.0 * kFarthest)) return wrong("farther out than 1e100 m");
  }
  return out;
}

/// Boxes that are not finite come last: no segment finds them.
double rankOf(const Box& box) { return box.finite() ? surfaceOf(box) : -1.0; }

}  // namespace

struct PairsCuller::Blockers {
  std::vector<SolidBlocker> solids;
  std::vector<FaceBlocker> faces;
  SegmentTree tree;  ///< over both, solids first
  std::size_t left_out = 0;

  bool hides(std::uint32_t index, const PlaceCorners& viewer, const PlaceCorners& target) const {
    return index < solids.size() ? solids[index].hides(viewer, target)
                                 : faces[index - solids.size()].hides(viewer, target);
  }
  void add(const SceneSnapshot& scene, const OccluderSet& set, const Candidate& candidate);
  void plant();
};

void PairsCuller::Blockers::add(const SceneSnapshot& scene, const OccluderSet& set,
                                const Candidate& candidate) {
  const ConvexPiece piece = set.piece(candidate.piece);
  const Instance& instance = scene.instance(candidate.object);
  if (auto solid = SolidBlocker::of(piece, instance)) {
    solids.push_back(std::move(*solid));
  } else {
    FaceBlocker::append(piece, instance, faces);
  }
}

void PairsCuller::Blockers::plant() {
  std::vector<Box> boxes;
  boxes.reserve(solids.size() + faces.size());
  for (const SolidBlocker& solid : solids) boxes.push_back(solid.bounds());
  for (const FaceBlocker& face : faces) boxes.push_back(face.bounds());
  tree = SegmentTree(boxes);
}

PairsCuller::PairsCuller(const SceneSnapshot& scene)
    : PairsCuller(scene, std::make_shared<const OccluderSet>(OccluderSet::of(scene))) {}

std::unique_ptr<const PairsCuller> PairsCuller::edited(const SceneSnapshot& next) const {
  return std::unique_ptr<const PairsCuller>(new PairsCuller(next, pieces_));
}

PairsCuller::PairsCuller(const SceneSnapshot& scene, std::shared_ptr<const OccluderSet> pieces)
    : pieces_(std::move(pieces)) {
  const OccluderSet& set = *pieces_;
  std::vector<std::pair<double, Candidate>> found;
  for (std::size_t i = 0; i < scene.objectCount(); ++i) {
    const auto object = static_cast<ObjectId>(i);
    const Instance& instance = scene.instance(object);
    if (!instance.active() || instance.always_kept) continue;
    const OccluderMesh& mesh = set.mesh(instance.mesh);
    // Pieces of one object are ranked by the whole: their own boxes are not known yet.
    for (std::uint32_t p = 0; p < mesh.piece_count; ++p) {
      found.push_back({rankOf(instance.bounds_world), {object, mesh.first_piece + p}});
    }
  }
  auto blockers = std::make_unique<Blockers>();
  if (found.size() > kMostBlockers) {
    const auto rank = [](const auto& f) {
      return std::tuple(-f.first, f.second.object, f.second.piece);
    };
    std::nth_element(found.begin(), found.begin() + kMostBlockers, found.end(),
                     [&](const auto& a, const auto& b) { return rank(a) < rank(b); });
    blockers->left_out = found.size() - kMostBlockers;
    found.resize(kMostBlockers);
  }
  for (const auto& [rank, candidate] : found) blockers->add(scene, set, candidate);
  blockers->plant();
  blockers_ = std::move(blockers);
}

PairsCuller::~PairsCuller() = default;

std::size_t PairsCuller::blockers() const noexcept {
  return blockers_->solids.size() + blockers_->faces.size();
}
std::size_t PairsCuller::leftOut() const noexcept { return blockers_->left_out; }

std::size_t PairsCuller::bytes() const noexcept {
  std::size_t bytes = sizeof *blockers_ + blockers_->tree.bytes() + pieces_->bytes();
  for (const SolidBlocker& solid : blockers_->solids) bytes += solid.bytes();
  for (const FaceBlocker& face : blockers_->faces) bytes += face.bytes();
  return bytes;
}

Result<PairsAnswer> PairsCuller::cull(std::span<const Place> viewers,
                                      std::span<const Place> targets, std::chrono::nanoseconds time,
                                      const Clock& clock) const {
  const auto start = clock.now();
  const Deadline deadline(clock, start, time);
  const auto from = cornersOfAll(viewers, "viewer");
  if (!from) return from.error();
  const auto to = cornersOfAll(targets, "target");
  if (!to) return to.error();

  PairsAnswer answer;
  const std::size_t pairs = viewers.size() * targets.size();
  answer.may_see.assign((pairs + 7) / 8, 0xFF);
  if (pairs % 8 != 0) answer.may_see.back() = static_cast<std::uint8_t>((1U << pairs % 8) - 1U);
  // What hid a target from the viewer before often hides it from this one.
  constexpr std::uint32_t kNone = 0xFFFFFFFFU;
  std::vector<std::uint32_t> hid(targets.size(), kNone);
  for (std::size_t pair = 0; pair < pairs; ++pair) {
    if (pair % kPairsPerLook == 0 && deadline.passed()) {
      answer.out_of_budget = true;
      break;
    }
    const std::size_t t = pair % targets.size();
    const PlaceCorners& viewer = from.value()[pair / targets.size()];
    const PlaceCorners& target = to.value()[t];
    std::size_t tried = 0;
    const auto hides = [&](std::uint32_t index) {
      ++tried;
      if (!blockers_->hides(index, viewer, target)) return false;
      hid[t] = index;
      return true;
    };
    const bool hidden =
        (hid[t] != kNone && hides(hid[t])) ||
        blockers_->tree.any(viewer.centre, target.centre, answer.nodes_visited,
                            [&](std::uint32_t i) { return tried < kMostTried && hides(i); });
    answer.tested += tried;
    if (!hidden) continue;
    ++answer.hidden;
    answer.may_see[pair / 8] &= static_cast<std::uint8_t>(~(1U << pair % 8));
  }
  answer.time = clock.now() - start;
  return answer;
}

}  // namespace culld
