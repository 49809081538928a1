#include "culling/occluders/occluder_database.h"

#include <algorithm>
#include <array>
#include <bit>
#include <glm/geometric.hpp>
#include <glm/vector_relational.hpp>

#include "culling/core/parallel.h"
#include "culling/raster/object_rows.h"
#include "culling/spatial/wide_bvh_fit.h"

namespace culld {
namespace {

constexpr double kSticksOut = 0.2;         ///< of its own size: a picture does, a house does not
constexpr double kRedundantSize = 2.0;     ///< so much larger is what makes a thing redundant
constexpr std::uint32_t kMostLooked = 32;  ///< nodes, in the search for it
constexpr std::size_t kObjectsAtOnce = 1024;

glm::dvec3 sidesOf(const Box& box) { return box.max - box.min; }
double largestSide(const Box& box) {
  const glm::dvec3 s = sidesOf(box);
  return std::max({s.x, s.y, s.z});
}
double smallestSide(const Box& box) {
  const glm::dvec3 s = sidesOf(box);
  return std::min({s.x, s.y, s.z});
}

bool contains(const Box& outer, const Box& inner, double slack) {
  return glm::all(glm::lessThanEqual(outer.min - slack, inner.min)) &&
         glm::all(glm::lessThanEqual(inner.max, outer.max + slack));
}

/// World coordinates relative to a place near by, so that nothing is lost far from the origin.
glm::dvec3 placedBy(const Instance& instance, const glm::dvec3& p, const glm::dvec3& near_by) {
  const auto& m = instance.world_from_mesh;
  return {m[0] * p.x + m[1] * p.y + m[2] * p.z + (m[3] - near_by.x),
          m[4] * p.x + m[5] * p.y + m[6] * p.z + (m[7] - near_by.y),
          m[8] * p.x + m[9] * p.y + m[10] * p.z + (m[11] - near_by.z)};
}

using Corners = std::array<glm::dvec3, 8>;

Corners cornersOf(const Instance& instance, const Box& bounds_mesh, const glm::dvec3& near_by) {
  Corners corners;
  for (unsigned i = 0; i < 8; ++i) {
    const glm::dvec3 p((i & 1U) != 0 ? bounds_mesh.max.x : bounds_mesh.min.x,
                       (i & 2U) != 0 ? bounds_mesh.max.y : bounds_mesh.min.y,
                       (i & 4U) != 0 ? bounds_mesh.max.z : bounds_mesh.min.z);
    corners[i] = placedBy(instance, p, near_by);
  }
  return corners;
}

/// No corner lies farther than `slack_m` before any face of the piece.
bool solidHolds(const ConvexPiece& piece, const Instance& solid, const Corners& corners,
                const glm::dvec3& near_by, double slack_m) {
  const double turn = handedness(solid.world_from_mesh);
  for (const PieceFace& face : piece.faces) {
    std::array<glm::dvec3, 3> p;
    for (std::size_t i = 0; i < 3; ++i) {
      p[i] = placedBy(solid, glm::dvec3(piece.vertices[face.corner[i]]), near_by);
    }
    const glm::dvec3 normal = turn * glm::cross(p[1] - p[0], p[2] - p[0]);
    const double most = slack_m * glm::length(normal);
    for (const glm::dvec3& corner : corners) {
      if (!(glm::dot(normal, corner - p[0]) <= most)) return false;
    }
  }
  return true;
}

bool canBlock(const SceneSnapshot& scene, const Instance& instance) {
  return instance.active() && !instance.always_kept && instance.bounds_world.finite() &&
         scene.mesh(instance.mesh).blocking_triangles != 0;
}

double medianSide(const SceneSnapshot& scene) {
  std::vector<double> sides;
  for (ObjectId id = 0; id < scene.objectCount(); ++id) {
    const Instance& instance = scene.instance(id);
    if (canBlock(scene, instance)) sides.push_back(largestSide(instance.bounds_world));
  }
  if (sides.empty()) return 0.0;
  const auto middle = sides.begin() + static_cast<std::ptrdiff_t>(sides.size() / 2);
  std::nth_element(sides.begin(), middle, sides.end());
  return *middle;
}

}  // namespace

class OccluderJudge {
 public:
  using Verdict = OccluderDatabase::Verdict;

  OccluderJudge(const OccluderDatabase& rules, const SceneSnapshot& scene, const WideBvh& bvh,
                const OccluderSet& set)
      : base_(rules), scene_(scene), bvh_(bvh), set_(set) {}

  Verdict operator()(ObjectId id) const {
    const Instance& instance = scene_.instance(id);
    const Verdict alone = byItself(instance);
    const bool search = alone == Verdict::kTaken && base_.rules_.leave_redundant;
    return search && redundant(id, instance) ? Verdict::kRedundant : alone;
  }

 private:
  Verdict byItself(const Instance& instance) const {
    if (!canBlock(scene_, instance)) return Verdict::kNotBlocking;
    const OccluderRules& rules = base_.rules_;
    if (largestSide(instance.bounds_world) < base_.least_side_m_) return Verdict::kSmall;
    const std::uint32_t polygons = set_.mesh(instance.mesh).polygons();
    if (rules.most_polygons != 0 && polygons > rules.most_polygons) return Verdict::kDetailed;
    return set_.mesh(instance.mesh).fill < rules.least_fill ? Verdict::kIllShaped : Verdict::kTaken;
  }

  /// Does it hardly stick out of a larger solid? Solids are of one convex piece: of a room, the box
  /// says nothing of what is in it.
  bool redundant(ObjectId id, const Instance& instance) const {
    const Box& box = instance.bounds_world;
    const double slack = std::min(smallestSide(box), kSticksOut * largestSide(box));
    std::vector<std::uint32_t> stack;
    for (auto root = static_cast<std::uint32_t>(bvh_.rootCount()); root-- > 0;) {
      stack.push_back(root);
    }
    for (std::uint32_t looked = 0; looked < kMostLooked && !stack.empty(); ++looked) {
      const WideNode& node = bvh_.node(stack.back());
      stack.pop_back();
      for (std::uint32_t lanes = node.blocking; lanes != 0; lanes &= lanes - 1) {
        const auto lane = static_cast<std::size_t>(std::countr_zero(lanes));
        if (!contains(boundsOfLane(node, lane), box, slack)) continue;
        const ChildRef child = node.child[lane];
        if (child.isNode()) {
          stack.push_back(child.nodeIndex());
        } else if (child.objectId() != id && solidAround(child.objectId(), instance, slack)) {
          return true;
        }
      }
    }
    return false;
  }

  bool solidAround(ObjectId id, const Instance& inner, double slack) const {
    const Instance& solid = scene_.instance(id);
    const OccluderMesh& mesh = set_.mesh(solid.mesh);
    const double size = largestSide(solid.bounds_world);
    if (mesh.piece_count != 1 || size < kRedundantSize * largestSide(inner.bounds_world) ||
        byItself(solid) != Verdict::kTaken) {
      return false;
    }
    if (!contains(solid.bounds_world, inner.bounds_world, slack)) return false;
    const glm::dvec3& near_by = inner.bounds_world.min;
    const Corners corners = cornersOf(inner, scene_.mesh(inner.mesh).bounds, near_by);
    return solidHolds(set_.piece(mesh.first_piece), solid, corners, near_by, slack);
  }

  const OccluderDatabase& base_;
  const SceneSnapshot& scene_;
  const WideBvh& bvh_;
  const OccluderSet& set_;
};

OccluderDatabase OccluderDatabase::of(const SceneSnapshot& scene, const WideBvh& bvh,
                                      const OccluderSet& set, const OccluderRules& rules) {
  OccluderDatabase database;
  database.rules_ = rules;
  database.least_side_m_ = rules.least_size * medianSide(scene);
  database.verdicts_.resize(scene.objectCount());
  const OccluderJudge judge(database, scene, bvh, set);
  const std::size_t parts = (scene.objectCount() + kObjectsAtOnce - 1) / kObjectsAtOnce;
  parallelFor(parts, [&](std::size_t part) {
    const std::size_t end = std::min((part + 1) * kObjectsAtOnce, scene.objectCount());
    for (std::size_t id = part * kObjectsAtOnce; id < end; ++id) {
      database.verdicts_[id] = judge(static_cast<ObjectId>(id));
    }
  });
  return database;
}

OccluderDatabase OccluderDatabase::edited(const SceneSnapshot& next, const WideBvh& bvh,
                                          const OccluderSet& set,
                                          std::span<const ObjectId> changed) const {
  OccluderDatabase database = *this;
  database.verdicts_.resize(next.objectCount(), Verdict::kNotBlocking);
  const OccluderJudge judge(database, next, bvh, set);
  for (const ObjectId id : changed) database.verdicts_[id] = judge(id);
  return database;
}

OccluderTally OccluderDatabase::tally() const noexcept {
  const auto count = [&](Verdict verdict) {
    return static_cast<std::size_t>(std::count(verdicts_.begin(), verdicts_.end(), verdict));
  };
  return {count(Verdict::kTaken),    count(Verdict::kNotBlocking), count(Verdict::kSmall),
          count(Verdict::kDetailed), count(Verdict::kIllShaped),   count(Verdict::kRedundant)};
}

std::size_t OccluderDatabase::bytes() const noexcept { return verdicts_.capacity(); }

}  // namespace culld
