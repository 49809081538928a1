// What every soundness test asks: is the answer well formed, and is anything missing from it?
#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "culling/culler.h"
#include "culling/oracle/oracle.h"

namespace culld {

/// Ids of `expected` that `answered` lacks. Both ascending.
inline std::vector<ObjectId> missing(const std::vector<ObjectId>& expected,
                                     const std::vector<ObjectId>& answered) {
  std::vector<ObjectId> out;
  std::set_difference(expected.begin(), expected.end(), answered.begin(), answered.end(),
                      std::back_inserter(out));
  return out;
}

inline void expectWellFormed(const Answer& answer, const SceneSnapshot& scene) {
  EXPECT_TRUE(std::is_sorted(answer.visible.begin(), answer.visible.end()));
  EXPECT_EQ(std::adjacent_find(answer.visible.begin(), answer.visible.end()), answer.visible.end());
  EXPECT_TRUE(answer.visible.empty() || answer.visible.back() < scene.objectCount());
  EXPECT_TRUE(answer.proven);
  EXPECT_EQ(answer.guarantee, Guarantee::kConservative);
  EXPECT_EQ(answer.missed_px, 0.0F);
}

struct PreparedMethod {
  std::string name;
  std::unique_ptr<Culler> culler;
  ViewState view;
};

/// Every method of the table, ready for `scene`.
/// `settings`: methods with settings, beside all the others.
inline std::vector<PreparedMethod> prepareAll(const SnapshotPtr& scene,
                                              std::span<const char* const> settings = {}) {
  std::vector<PreparedMethod> out;
  for (const Method* method : allMethods()) {
    auto culler = method->prepare(scene);
    EXPECT_TRUE(culler.ok()) << method->info().name;
    if (culler.ok()) {
      out.push_back({std::string(method->info().name), std::move(culler).value(), ViewState{}});
    }
  }
  static ConfiguredMethods configured(allMethods());
  for (const char* const name : settings) {
    const auto method = configured.find(name);
    EXPECT_TRUE(method.ok()) << name;
    if (method.ok()) out.push_back({name, method.value()->prepare(scene).value(), ViewState{}});
  }
  return out;
}

/// Settings of `frustum` that leave out more than the standard, or answer from what is out of date.
inline constexpr const char* kFrustumSettings[] = {"frustum:oriented=on", "frustum:late=4096"};

}  // namespace culld
