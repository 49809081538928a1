#include "culling/report/depth_picture.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <vector>

namespace culld {
namespace {

TEST(DepthPicture, IsWrittenForAnyCounts) {
  const auto path = std::filesystem::path(testing::TempDir()) / "depth_picture_test.png";
  for (const std::uint32_t most : {0U, 1U, 7U, 0xFFFFFFFFU}) {
    std::vector<std::uint32_t> surfaces(64 * 36, 0);
    surfaces[100] = most;
    surfaces[101] = most / 2;
    ASSERT_TRUE(drawDepth({surfaces, 64, 36, "a scene"}, path.string()).ok()) << most;
    EXPECT_GT(std::filesystem::file_size(path), 100U);
  }
  std::filesystem::remove(path);
}

TEST(DepthPicture, NamesThePathThatCannotBeWritten) {
  const std::vector<std::uint32_t> surfaces(16, 1);
  const auto drawn = drawDepth({surfaces, 4, 4, ""}, "/no/such/folder/depth.png");
  ASSERT_FALSE(drawn.ok());
  EXPECT_EQ(drawn.error().code, ErrorCode::kIo);
  EXPECT_NE(drawn.error().message.find("/no/such/folder/depth.png"), std::string::npos);
}

}  // namespace
}  // namespace culld
