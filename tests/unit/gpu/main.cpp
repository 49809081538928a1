// Ends with 77 if nothing failed but something was skipped, so that ctest's summary lists it.
#include <gtest/gtest.h>

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  constexpr int kSkipped = 77;
  const int result = RUN_ALL_TESTS();
  const bool skipped = testing::UnitTest::GetInstance()->skipped_test_count() > 0;
  return result == 0 && skipped ? kSkipped : result;
}
