#include "culling/core/result.h"

#include <gtest/gtest.h>

#include <memory>

namespace culld {
namespace {

TEST(Result, HoldsAValueOrAnError) {
  const Result<int> fine(7);
  EXPECT_TRUE(fine.ok());
  EXPECT_TRUE(static_cast<bool>(fine));
  EXPECT_EQ(fine.value(), 7);
  const Result<int> failed(invalidInput("box 3: no corners"));
  EXPECT_FALSE(failed.ok());
  EXPECT_EQ(failed.error().code, ErrorCode::kInvalidInput);
  EXPECT_EQ(failed.error().message, "box 3: no corners");
}

TEST(Result, TellsAnErrorValueFromAnError) {
  const Result<std::string> text(std::string("an error message as a value"));
  EXPECT_TRUE(text.ok());
}

TEST(Result, GivesAwayValuesThatOnlyMove) {
  Result<std::unique_ptr<int>> owner(std::make_unique<int>(5));
  const std::unique_ptr<int> mine = std::move(owner).value();
  EXPECT_EQ(*mine, 5);
}

TEST(Result, PassesAnErrorOnToAnotherType) {
  const auto inner = []() -> Result<void> { return Error{ErrorCode::kIo, "disk full"}; };
  const auto outer = [&]() -> Result<std::string> {
    if (auto done = inner(); !done) return std::move(done).error();
    return std::string("never");
  };
  const auto result = outer();
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.error().code, ErrorCode::kIo);
  EXPECT_EQ(result.error().message, "disk full");
}

TEST(Result, OfNothingIsDone) {
  const Result<void> done = Done{};
  EXPECT_TRUE(done.ok());
}

}  // namespace
}  // namespace culld
