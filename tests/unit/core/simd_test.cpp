#include "culling/core/simd.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace culld {
namespace {

class Simd : public ::testing::Test {
 protected:
  void TearDown() override { ASSERT_TRUE(forceSimdTarget("auto").ok()); }
};

TEST_F(Simd, HasTheBaselineEverywhere) {
  const auto targets = simdTargets();
  ASSERT_FALSE(targets.empty());
  // The build's baseline (docs/adr/0001): without it Highway falls to one lane with g++ 12.
  EXPECT_EQ(targets.back(), "sse4");
}

TEST_F(Simd, TakesEveryTargetThatItLists) {
  for (const std::string& name : simdTargets()) EXPECT_TRUE(forceSimdTarget(name).ok()) << name;
}

TEST_F(Simd, StillListsAllTargetsAfterOneWasForced) {
  const auto all = simdTargets();
  for (const std::string& name : all) {
    ASSERT_TRUE(forceSimdTarget(name).ok());
    EXPECT_EQ(simdTargets(), all) << name;
  }
}

TEST_F(Simd, NamesTheTargetsWhenAskedForAnother) {
  for (const char* wrong : {"", "avx9", "SSE4", "sse4 "}) {
    const auto result = forceSimdTarget(wrong);
    ASSERT_FALSE(result.ok()) << wrong;
    EXPECT_EQ(result.error().code, ErrorCode::kInvalidInput);
    EXPECT_NE(result.error().message.find("--simd=" + std::string(wrong) + ":"), std::string::npos);
    EXPECT_NE(result.error().message.find("sse4"), std::string::npos);
  }
}

TEST_F(Simd, KeepsAnEarlierChoiceWhenAskedForAWrongOne) {
  ASSERT_TRUE(forceSimdTarget("sse4").ok());
  ASSERT_FALSE(forceSimdTarget("nonsense").ok());
  EXPECT_EQ(activeSimdTarget(), "sse4");
}

TEST_F(Simd, SaysWhichTargetIsInUse) {
  for (const std::string& name : simdTargets()) {
    ASSERT_TRUE(forceSimdTarget(name).ok());
    EXPECT_EQ(activeSimdTarget(), name);
  }
  ASSERT_TRUE(forceSimdTarget("auto").ok());
  EXPECT_EQ(activeSimdTarget(), simdTargets().front());
}

}  // namespace
}  // namespace culld
