#include "protocol/text.h"

#include <gtest/gtest.h>

#include <string>

namespace culld::protocol {
namespace {

TEST(OneLine, SpellsControlCharactersOut) {
  EXPECT_EQ(oneLine("x\ny"), "x\\ny");
  EXPECT_EQ(oneLine("a\tb\rc"), "a\\tb\\rc");
  EXPECT_EQ(oneLine("\x1b[31mred\x7f"), "\\x1b[31mred\\x7f");
  EXPECT_EQ(oneLine(std::string("a\0b", 3)), "a\\x00b");
}

TEST(OneLine, LeavesOtherTextAlone) {
  EXPECT_EQ(oneLine(""), "");
  EXPECT_EQ(oneLine("Straße \"city\" \\ 100 %"), "Straße \"city\" \\ 100 %");
}

}  // namespace
}  // namespace culld::protocol
