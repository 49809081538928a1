#include "culling/pairs/pairs.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "culling/core/parallel.h"
#include "culling/pairs/blocker.h"
#include "culling/pairs/segment_tree.h"

namespace culld {
namespace {

constexpr std::size_t kMostFaces = 4096;                   ///< of one mesh
constexpr std::size_t kMostRanked = std::size_t{1} << 22;  ///< pieces, those of large objects first
constexpr std::size_t kMostTried = 256;   ///< occluders per pair: what hides is mostly found soon
constexpr std::size_t kMostNodes = 4096;  ///< of the tree per pair
constexpr std::uint64_t kStepsPerLook = 256;  ///< nodes and occluders between looks at the clock

/// Ordered by size, the largest first; never a tie.
struct Candidate {
  double minus_surface;
  ObjectId object;
  std::uint32_t piece;
  auto operator<=>(const Candidate&) const = default;
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
    if (!(place.radius_m >= 0.0 && place.radius_m < kFarthestPlace)) {
      return wrong("the radius is not a number from 0 to 1e90 m");
    }
    out.push_back(culld::cornersOf(place));
    if (!(out.back().largest < kFarthestPlace)) return wrong("farther out than 1e90 m");
  }
  return out;
}

/// Half the surface of the piece's box in the world; -1 for what no segment finds.
double rankOf(const ConvexPiece& piece, const Instance& instance) {
  Box mesh;
  for (const glm::vec3& v : piece.vertices) mesh.grow(glm::dvec3(v));
  const Box box = boundsOf(instance.world_from_mesh, mesh);
  return box.finite() ? halfArea(box) : -1.0;
}

/// The `most` largest stay.
void keepLargest(std::vector<Candidate>& found, std::size_t most) {
  if (found.size() <= most) return;
  std::nth_element(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(most), found.end());
  found.resize(most);
}

/// The largest pieces, at least as many as are kept; memory does not grow with the scene's pieces.
std::vector<Candidate> candidatesIn(const SceneSnapshot& scene, const MeshPieces& pieces) {
  std::vector<std::pair<double, ObjectId>> objects;
  for (std::size_t i = 0; i < scene.objectCount(); ++i) {
    const Instance& instance = scene.instance(static_cast<ObjectId>(i));
    if (!instance.active() || instance.always_kept || pieces[instance.mesh].size() == 0) continue;
    if (!instance.bounds_world.finite()) continue;
    objects.emplace_back(-halfArea(instance.bounds_world), static_cast<ObjectId>(i));
  }
  std::sort(objects.begin(), objects.end());
  constexpr std::size_t kMost = PairsCuller::kMostBlockers;
  std::size_t ranked = 0;
  std::vector<Candidate> found;
  for (const auto& [minus_surface, object] : objects) {
    const Instance& instance = scene.instance(object);
    const ConvexPieces& of_mesh = pieces[instance.mesh];
    const std::size_t taken = std::min(of_mesh.size(), kMostRanked - ranked);
    ranked += taken;
    for (std::uint32_t p = 0; p < taken; ++p) {
      found.push_back({-rankOf(of_mesh[p], instance), object, p});
    }
    if (found.size() > 8 * kMost) keepLargest(found, kMost);
  }
  keepLargest(found, kMost);
  return found;
}

}  // namespace

struct PairsCuller::Blockers {
  std::vector<SolidBlocker> solids;
  std::vector<FaceBlocker> faces;
  SegmentTree tree;  ///< over both, solids first

  bool hides(std::uint32_t index, const PlaceCorners& viewer, const PlaceCorners& target) const {
    return index < solids.size() ? solids[index].hides(viewer, target)
                                 : faces[index - solids.size()].hides(viewer, target);
  }
  void add(const ConvexPiece& piece, const Instance& instance);
  void plant();
};

void PairsCuller::Blockers::add(const ConvexPiece& piece, const Instance& instance) {
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

std::shared_ptr<const MeshPieces> piecesOfMeshes(const SceneSnapshot& scene) {
  auto pieces = std::make_shared<MeshPieces>(scene.meshCount());
  parallelFor(pieces->size(), [&](std::size_t i) {
    const Mesh& mesh = scene.mesh(static_cast<MeshId>(i));
    (*pieces)[i] = ConvexPieces::of(mesh);
    if ((*pieces)[i].size() == 0) (*pieces)[i] = ConvexPieces::facesOf(mesh, kMostFaces);
  });
  return pieces;
}

PairsCuller::PairsCuller(const SceneSnapshot& scene, std::shared_ptr<const MeshPieces> pieces)
    : pieces_(std::move(pieces)) {
  auto blockers = std::make_unique<Blockers>();
  std::vector<Candidate> found = candidatesIn(scene, *pieces_);
  std::sort(found.begin(), found.end());
  for (const Candidate& candidate : found) {
    if (blockers->solids.size() + blockers->faces.size() >= kMostBlockers) break;
    const Instance& instance = scene.instance(candidate.object);
    blockers->add((*pieces_)[instance.mesh][candidate.piece], instance);
  }
  blockers->plant();
  blockers_ = std::move(blockers);
}

PairsCuller::~PairsCuller() = default;

std::size_t PairsCuller::blockers() const noexcept {
  return blockers_->solids.size() + blockers_->faces.size();
}

std::size_t PairsCuller::bytes() const noexcept {
  std::size_t bytes = sizeof *blockers_ + blockers_->tree.bytes();
  for (const ConvexPieces& pieces : *pieces_) bytes += sizeof pieces + pieces.bytes();
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
  std::uint64_t next_look = 0;
  for (std::size_t pair = 0; pair < pairs; ++pair) {
    const std::uint64_t steps = pair + answer.nodes_visited + answer.tested;
    if (steps >= next_look) {
      answer.out_of_budget = deadline.passed();
      if (answer.out_of_budget) break;
      next_look = steps + kStepsPerLook;
    }
    const std::size_t t = pair % targets.size();
    const PlaceCorners& viewer = from.value()[pair / targets.size()];
    const PlaceCorners& target = to.value()[t];
    const std::uint64_t most_tested = answer.tested + kMostTried;
    const std::uint64_t most_nodes = answer.nodes_visited + kMostNodes;
    bool hidden = false;
    // True ends the walk: it is hidden, or not worth more work.
    const auto ends = [&](std::uint32_t index) {
      ++answer.tested;
      hidden = blockers_->hides(index, viewer, target);
      if (hidden) hid[t] = index;
      return hidden || answer.tested >= most_tested;
    };
    if (hid[t] == kNone || !ends(hid[t])) {
      blockers_->tree.any(viewer.centre, target.centre, most_nodes, answer.nodes_visited, ends);
    }
    if (!hidden) continue;
    ++answer.hidden;
    answer.may_see[pair / 8] &= static_cast<std::uint8_t>(~(1U << pair % 8));
  }
  answer.time = clock.now() - start;
  return answer;
}

}  // namespace culld
