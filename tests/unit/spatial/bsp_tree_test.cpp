#include "culling/spatial/bsp_tree.h"

#include <gtest/gtest.h>

#include <random>

#include "culling/spatial/wide_bvh_fit.h"

namespace culld {
namespace {

struct Met {
  ObjectId id;
  Box box;
  std::uint32_t group;
};

/// The parts as an eye meets them.
void meet(const BspTree& tree, std::uint32_t index, const glm::dvec3& eye, std::vector<Met>& out) {
  const BspNode& node = tree.node(index);
  if (node.axis == BspNode::kGroup) {
    for (std::uint32_t at = node.below[0]; at < node.below[1]; ++at) {
      for (std::size_t l = 0; l < kWideLanes; ++l) {
        if ((tree.lanes(at).live >> l & 1U) == 0) continue;
        out.push_back({tree.lanes(at).child[l].objectId(), boundsOfLane(tree.lanes(at), l), index});
      }
    }
    return;
  }
  const bool high_first = eye[node.axis] >= node.plane;
  meet(tree, node.below[high_first ? 1 : 0], eye, out);
  meet(tree, node.below[high_first ? 0 : 1], eye, out);
}

/// Does the segment from `eye` to a point of `far` pass through the inside of `near`?
bool standsBefore(const Box& near, const glm::dvec3& eye, const glm::dvec3& p) {
  double first = 0.0, last = 1.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double d = p[axis] - eye[axis];
    double a = (near.min[axis] - eye[axis]) / d, b = (near.max[axis] - eye[axis]) / d;
    if (a > b) std::swap(a, b);
    first = std::max(first, a);
    last = std::min(last, b);
  }
  return first + 1e-6 < last && last < 1.0 - 1e-6;
}

std::vector<BspPart> boxes(std::size_t count, std::mt19937_64& random) {
  std::uniform_real_distribution<double> place(-10.0, 10.0), size(0.0, 4.0);
  std::vector<BspPart> parts;
  for (std::size_t i = 0; i < count; ++i) {
    const glm::dvec3 low(place(random), place(random), place(random));
    parts.push_back({static_cast<ObjectId>(i),
                     {low, low + glm::dvec3(size(random), size(random), size(random))},
                     true});
  }
  return parts;
}

TEST(BspTree, NothingMetLaterStandsBeforeWhatWasMetEarlier) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> unit(0.0, 1.0), place(-15.0, 15.0);
  std::size_t groups = 0;
  for (int round = 0; round < 60; ++round) {
    const auto parts = boxes(24, random);
    const BspTree tree = BspTree::of(parts, true);
    const glm::dvec3 eye(place(random), place(random), place(random));
    std::vector<Met> met;
    meet(tree, 0, eye, met);
    for (std::size_t i = 0; i < met.size(); ++i) {
      if (i > 0 && met[i].group != met[i - 1].group) ++groups;
      const Box& box = met[i].box;
      for (int k = 0; k < 8; ++k) {
        const glm::dvec3 t(unit(random), unit(random), unit(random));
        const glm::dvec3 p = box.min + t * (box.max - box.min);
        for (std::size_t j = i + 1; j < met.size(); ++j) {
          if (met[j].group == met[i].group) continue;
          ASSERT_FALSE(standsBefore(met[j].box, eye, p)) << round;
        }
      }
    }
  }
  EXPECT_GT(groups, 60U * 8U);
}

TEST(BspTree, ThePartsMakeUpTheBoxes) {
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const auto parts = boxes(40, random);
  std::vector<Met> met;
  meet(BspTree::of(parts, true), 0, {0, 0, 0}, met);
  EXPECT_LE(met.size(), 3 * parts.size());
  for (const BspPart& part : parts) {
    for (int k = 0; k < 50; ++k) {
      const glm::dvec3 p = part.box.min + glm::dvec3(unit(random), unit(random), unit(random)) *
                                              (part.box.max - part.box.min);
      const bool held = std::any_of(met.begin(), met.end(), [&](const Met& m) {
        return m.id == part.id && p.x >= m.box.min.x && p.y >= m.box.min.y && p.z >= m.box.min.z &&
               p.x <= m.box.max.x && p.y <= m.box.max.y && p.z <= m.box.max.z;
      });
      ASSERT_TRUE(held);
    }
  }
}

TEST(BspTree, KeepsTogetherWhatNoPlaneSeparates) {
  const Box box{glm::dvec3(0.0), glm::dvec3(1.0)};
  const BspTree same = BspTree::of(std::vector<BspPart>(20, BspPart{0, box, true}), true);
  EXPECT_EQ(same.node(0).axis, BspNode::kGroup);
  // A flat thing on the side of a box: at the same place, neither is before the other.
  const BspTree touching =
      BspTree::of(std::vector<BspPart>{{0, box, true}, {1, {{0, 0, 1}, {1, 1, 1}}, true}}, true);
  std::vector<Met> met;
  meet(touching, 0, {0.5, 0.5, -5.0}, met);
  ASSERT_FALSE(met.empty());
  EXPECT_EQ(met.back().group, met[met.size() - 2].group);
  EXPECT_NE(met.back().id, met[met.size() - 2].id);
  EXPECT_TRUE(BspTree::of({}, true).empty());
}

}  // namespace
}  // namespace culld
