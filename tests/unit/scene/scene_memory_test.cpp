// What docs promise: at most 200 bytes per instance and 40 per triangle, 40 of the 200 for the
// hierarchy over them (culling/spatial).
#include <gtest/gtest.h>

#include "culling/scene/edit.h"
#include "tests/unit/scene/test_meshes.h"

namespace culld {
namespace {

TEST(SceneMemory, AnInstanceTakesAtMost161Bytes) {
  const std::size_t few = test::rowOfCubes(1)->bytes();
  constexpr std::size_t kMany = 200'001;
  const double each = static_cast<double>(test::rowOfCubes(kMany)->bytes() - few) / (kMany - 1);
  RecordProperty("bytes_per_instance", std::to_string(each));
  EXPECT_LE(each, 161.0);
}

TEST(SceneMemory, ATriangleOfAWeldedSheetTakesAtMost31Bytes) {
  const auto bytesOf = [](std::uint32_t side) {
    SceneBuilder builder;
    builder.addInstance(builder.addMesh(makeMesh({test::gridSheet(side)})), test::kIdentity, 0);
    return builder.finish()->bytes();
  };
  constexpr std::uint32_t kSide = 500;
  const double each = static_cast<double>(bytesOf(kSide) - bytesOf(1)) / (2.0 * kSide * kSide);
  RecordProperty("bytes_per_triangle", std::to_string(each));
  EXPECT_LE(each, 31.0);
}

TEST(SceneMemory, ManySmallMeshesStayBelow40BytesPerTriangle) {
  SceneBuilder builder;
  constexpr std::size_t kMeshes = 1000;
  for (std::size_t i = 0; i < kMeshes; ++i) builder.addMesh(makeMesh({test::gridSheet(10)}));
  const double each = static_cast<double>(builder.finish()->bytes()) / (kMeshes * 200.0);
  RecordProperty("bytes_per_triangle", std::to_string(each));
  EXPECT_LE(each, 40.0);
}

TEST(SceneMemory, AnEditedVersionHoldsOneMoreChunkAndNoMore) {
  const SnapshotPtr before = test::rowOfCubes(100'000);
  const auto after = applyEdits(before, std::vector<Edit>{HideObject{7}});
  ASSERT_TRUE(after.ok());
  EXPECT_EQ(after.value().snapshot->chunksNotIn(*before), 1U);
  EXPECT_LE(after.value().snapshot->bytes(), before->bytes() + 1024);
}

}  // namespace
}  // namespace culld
