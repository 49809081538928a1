#include "culling/core/settings.h"

#include <gtest/gtest.h>

namespace culld {
namespace {

constexpr Setting kTable[] = {
    {"coherence", "last frame's nodes first"},
    {"levels", "of the pyramid", 6, 1, 12},
    {"opacity", "share of a cell that counts as covered", 0.5, 0, 1, false}};

TEST(Settings, AreStandardUntilSet) {
  SettingValues values(kTable);
  EXPECT_TRUE(values.on("coherence"));
  EXPECT_EQ(values.number("levels"), 6);
  EXPECT_EQ(values.number("opacity"), 0.5);
  EXPECT_TRUE(values.set("coherence=off").ok());
  EXPECT_TRUE(values.set("levels=12").ok());
  EXPECT_TRUE(values.set("opacity=0.875").ok());
  EXPECT_FALSE(values.on("coherence"));
  EXPECT_EQ(values.number("levels"), 12);
  EXPECT_EQ(values.number("opacity"), 0.875);
}

TEST(Settings, NameWhatIsWrongAndStayAsTheyWere) {
  SettingValues values(kTable);
  const auto message = [&](const char* text) { return values.set(text).error().message; };
  EXPECT_EQ(message("coherence=1"), "setting coherence=1: its values are on, off");
  EXPECT_EQ(message("coherence"), "setting coherence: its values are on, off");
  EXPECT_EQ(message("levels=0"), "setting levels=0: its values are 1 to 12");
  EXPECT_EQ(message("levels=2.5"), "setting levels=2.5: its values are 1 to 12");
  EXPECT_EQ(message("levels="), "setting levels=: its values are 1 to 12");
  EXPECT_EQ(message("opacity=nan"), "setting opacity=nan: its values are 0 to 1, fractions too");
  EXPECT_EQ(message("opacity=0.5x"), "setting opacity=0.5x: its values are 0 to 1, fractions too");
  EXPECT_EQ(message("depth=1"), "setting depth: unknown; there are coherence, levels, opacity");
  EXPECT_EQ(message(""), "setting : unknown; there are coherence, levels, opacity");
  EXPECT_TRUE(values.on("coherence"));
  EXPECT_EQ(values.number("levels"), 6);
  EXPECT_EQ(values.number("opacity"), 0.5);
  EXPECT_EQ(SettingValues({}).set("x=1").error().message, "setting x: unknown; there are none");
}

TEST(Settings, AreWrittenAsTheyAreRead) {
  EXPECT_EQ(valueText(kTable[0], 1), "on");
  EXPECT_EQ(valueText(kTable[1], 6), "6");
  EXPECT_EQ(valueText(kTable[2], 0.1), "0.1");
}

}  // namespace
}  // namespace culld
