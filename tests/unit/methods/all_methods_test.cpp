#include <gtest/gtest.h>

#include <set>

#include "culling/culler.h"

namespace culld {
namespace {

TEST(AllMethods, HaveDistinctNamesThatFindThem) {
  std::set<std::string_view> names;
  for (const Method* method : allMethods()) {
    const MethodInfo info = method->info();
    EXPECT_FALSE(info.name.empty());
    EXPECT_FALSE(info.source.empty()) << info.name;
    EXPECT_TRUE(names.insert(info.name).second) << info.name;
    EXPECT_EQ(findMethod(info.name), method);
  }
  EXPECT_TRUE(names.contains("frustum"));
}

TEST(AllMethods, AreNotFoundByAnyOtherName) {
  EXPECT_EQ(findMethod(""), nullptr);
  EXPECT_EQ(findMethod("Frustum"), nullptr);
  EXPECT_EQ(findMethod("frustum "), nullptr);
}

TEST(AllMethods, AnswerNothingForAnEmptyScene) {
  const SnapshotPtr empty = std::make_shared<const SceneSnapshot>();
  for (const Method* method : allMethods()) {
    auto culler = method->prepare(empty);
    ASSERT_TRUE(culler.ok()) << method->info().name << ": " << culler.error().message;
    ViewState view;
    const Answer answer = culler.value()->cull(cameraFromLookAt({}, {}).value(), {}, view);
    EXPECT_TRUE(answer.visible.empty());
    EXPECT_FALSE(answer.out_of_budget);
  }
}

TEST(GuaranteeName, IsTheWordOfTheContract) {
  EXPECT_EQ(guaranteeName(Guarantee::kConservative), "conservative");
  EXPECT_EQ(guaranteeName(Guarantee::kHole), "hole");
  EXPECT_EQ(guaranteeName(Guarantee::kSampled), "sampled");
  EXPECT_EQ(guaranteeName(Guarantee::kApproximate), "approximate");
}

}  // namespace
}  // namespace culld
