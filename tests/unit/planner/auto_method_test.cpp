#include "culling/planner/auto_method.h"

#include <gtest/gtest.h>

namespace culld {
namespace {

/// A method that only says what it is; the planner must look at nothing else.
class NamedMethod final : public Method {
 public:
  NamedMethod(std::string_view name, std::string_view needs,
              Guarantee guarantee = Guarantee::kConservative, std::string refusal = "")
      : info_{name, "nobody", guarantee, needs}, refusal_(std::move(refusal)) {}
  MethodInfo info() const noexcept override { return info_; }
  Result<void> accepts(const SceneProfile&) const override {
    if (refusal_.empty()) return Done{};
    return Error{ErrorCode::kUnsupported, refusal_};
  }
  Result<std::unique_ptr<Culler>> prepare(SnapshotPtr, const Clock&) const override {
    return Error{ErrorCode::kUnsupported, "planning must not prepare"};
  }

 private:
  MethodInfo info_;
  std::string refusal_;
};

constexpr SceneProfile kCity{100000, 5000000, 4000000};

TEST(AutoMethod, TakesTheMethodThatUsesTrianglesForALargeScene) {
  const NamedMethod frustum("frustum", "boxes"), raster("raster", "triangles");
  const Method* methods[] = {&frustum, &raster};
  const auto choice = chooseMethod(kCity, methods);
  ASSERT_TRUE(choice.ok());
  EXPECT_EQ(choice.value().method, &raster);
  EXPECT_EQ(choice.value().why, "raster: 100000 objects and 4000000 blocking triangles");
}

TEST(AutoMethod, TakesTheFrustumForFewObjects) {
  const NamedMethod frustum("frustum", "boxes"), raster("raster", "triangles");
  const Method* methods[] = {&raster, &frustum};
  const auto choice = chooseMethod({255, 5000000, 4000000}, methods);
  ASSERT_TRUE(choice.ok());
  EXPECT_EQ(choice.value().method, &frustum);
  EXPECT_EQ(choice.value().why, "frustum: 255 objects, fewer than 256: occluders cannot pay");
}

TEST(AutoMethod, TakesTheFrustumWhereNothingBlocks) {
  const NamedMethod frustum("frustum", "boxes"), raster("raster", "triangles");
  const Method* methods[] = {&raster, &frustum};
  const auto choice = chooseMethod({100000, 5000000, 0}, methods);
  ASSERT_TRUE(choice.ok());
  EXPECT_EQ(choice.value().method, &frustum);
  EXPECT_EQ(choice.value().why, "frustum: no blocking triangles: nothing can hide anything");
}

TEST(AutoMethod, SaysWhyAMethodDeclinedTheScene) {
  const NamedMethod frustum("frustum", "boxes");
  const NamedMethod raster("raster", "triangles", Guarantee::kConservative, "too many triangles");
  const Method* methods[] = {&frustum, &raster};
  const auto choice = chooseMethod(kCity, methods);
  ASSERT_TRUE(choice.ok());
  EXPECT_EQ(choice.value().method, &frustum);
  EXPECT_NE(choice.value().why.find("raster: too many triangles"), std::string::npos);
}

TEST(AutoMethod, NeverTakesAMethodThatMayMiss) {
  const NamedMethod frustum("frustum", "boxes");
  const NamedMethod loose("loose", "triangles", Guarantee::kApproximate);
  const NamedMethod sampled("sampled", "triangles", Guarantee::kSampled);
  const Method* methods[] = {&loose, &sampled, &frustum};
  const auto choice = chooseMethod(kCity, methods);
  ASSERT_TRUE(choice.ok());
  EXPECT_EQ(choice.value().method, &frustum);
}

TEST(AutoMethod, IsAnErrorIfNoMethodIsLeft) {
  const NamedMethod loose("loose", "boxes", Guarantee::kApproximate);
  const Method* methods[] = {&loose};
  const auto choice = chooseMethod(kCity, methods);
  ASSERT_FALSE(choice.ok());
  EXPECT_EQ(choice.error().code, ErrorCode::kUnsupported);
  EXPECT_FALSE(chooseMethod(kCity, {}).ok());
}

}  // namespace
}  // namespace culld
