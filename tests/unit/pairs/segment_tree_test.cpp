#include "culling/pairs/segment_tree.h"

#include <gtest/gtest.h>

#include <set>

#include "tests/scenes/random.h"

namespace culld {
namespace {

glm::dvec3 randomPoint(scenes::Random& random, double size) {
  const double x = random.uniform(-size, size), y = random.uniform(-size, size);
  return {x, y, random.uniform(-size, size)};
}

std::set<std::uint32_t> metBy(const SegmentTree& tree, const glm::dvec3& from,
                              const glm::dvec3& to) {
  std::set<std::uint32_t> met;
  std::uint64_t nodes = 0;
  tree.any(from, to, 1'000'000, nodes, [&](std::uint32_t i) {
    EXPECT_TRUE(met.insert(i).second) << "twice";
    return false;
  });
  return met;
}

TEST(SegmentTree, FindsEveryBoxThatTheSegmentPasses) {
  scenes::Random random(7);
  for (const std::size_t count : {1U, 4U, 5U, 300U}) {
    std::vector<Box> boxes;
    for (std::size_t i = 0; i < count; ++i) {
      const glm::dvec3 centre = randomPoint(random, 10);
      boxes.push_back({centre - 0.5, centre + 0.5});
    }
    const SegmentTree tree(boxes);
    for (std::size_t i = 0; i < count; ++i) {  // through a box, along an axis every third time
      glm::dvec3 along = randomPoint(random, 30);
      if (i % 3 == 0) along = {0, along.y, 0};
      const glm::dvec3 inside = boxes[i].min + 0.25;
      EXPECT_TRUE(
          metBy(tree, inside - along, inside + along).contains(static_cast<std::uint32_t>(i)));
      EXPECT_TRUE(metBy(tree, inside, inside).contains(static_cast<std::uint32_t>(i)));
    }
  }
}

TEST(SegmentTree, LooksAtFewNodesAndStopsWhenTold) {
  std::vector<Box> boxes;
  for (int i = 0; i < 4096; ++i) {
    const glm::dvec3 at(i % 64, i / 64, 0);
    boxes.push_back({at, at + 0.5});
  }
  const SegmentTree tree(boxes);
  const glm::dvec3 from(0, 0.2, 0.2), to(64, 0.2, 0.2);
  std::uint64_t nodes = 0, visits = 0;
  tree.any(from, to, 1000, nodes, [&](std::uint32_t) { return ++visits == 3; });
  EXPECT_EQ(visits, 3U);
  EXPECT_LT(nodes, 200U);
  nodes = 0;
  tree.any(from, to, 20, nodes, [](std::uint32_t) { return false; });
  EXPECT_EQ(nodes, 20U);
}

TEST(SegmentTree, OfNothingFindsNothing) {
  EXPECT_TRUE(metBy(SegmentTree(), {0, 0, 0}, {1, 1, 1}).empty());
  EXPECT_TRUE(metBy(SegmentTree(std::span<const Box>{}), {0, 0, 0}, {1, 1, 1}).empty());
}

}  // namespace
}  // namespace culld
