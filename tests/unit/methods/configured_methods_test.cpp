#include <gtest/gtest.h>

#include <set>

#include "culling/culler.h"

namespace culld {
namespace {

constexpr Setting kParts[] = {{"coherence", "last frame first"}, {"levels", "kept", 6, 1, 12}};

/// Says in its source how it is set.
class PartsMethod final : public Method {
 public:
  explicit PartsMethod(bool coherent = true) : coherent_(coherent) {}
  MethodInfo info() const noexcept override {
    return {"parts", coherent_ ? "coherent" : "forgetful", Guarantee::kConservative, "boxes"};
  }
  Result<void> accepts(const SceneProfile& /*profile*/) const override { return Done{}; }
  Result<std::unique_ptr<Culler>> prepare(SnapshotPtr /*scene*/,
                                          const Clock& /*clock*/) const override {
    return Error{ErrorCode::kUnsupported, "never asked"};
  }
  std::span<const Setting> settings() const noexcept override { return kParts; }
  std::unique_ptr<const Method> with(const SettingValues& values) const override {
    return std::make_unique<const PartsMethod>(values.on("coherence"));
  }

 private:
  bool coherent_;
};

const PartsMethod parts;
const Method* const table[] = {&parts, findMethod("frustum")};

TEST(ConfiguredMethods, AreTheTablesOwnUnderTheirPlainNames) {
  ConfiguredMethods methods(table);
  EXPECT_EQ(methods.find("parts").value(), &parts);
  EXPECT_EQ(methods.find("frustum").value(), table[1]);
  EXPECT_EQ(methods.all().size(), 2U);
}

TEST(ConfiguredMethods, HaveTheirSettingsAndTheNameThatSaysThem) {
  ConfiguredMethods methods(table);
  const Method* forgetful = methods.find("parts:levels=3:coherence=off").value();
  EXPECT_EQ(forgetful->info().name, "parts:levels=3:coherence=off");
  EXPECT_EQ(forgetful->info().source, "forgetful");
  EXPECT_EQ(methods.find("parts:coherence=on").value()->info().source, "coherent");
  EXPECT_EQ(methods.find("parts:levels=3:coherence=off").value(), forgetful);
  EXPECT_EQ(methods.all().size(), 4U);
}

TEST(ConfiguredMethods, NameWhatIsUnknown) {
  ConfiguredMethods methods(table);
  const auto message = [&](const char* name) { return methods.find(name).error().message; };
  EXPECT_TRUE(methods.find("parts:coherence=off").ok());
  EXPECT_EQ(message("part"), "method part: unknown; there are parts, frustum");
  EXPECT_EQ(message(""), "method : unknown; there are parts, frustum");
  EXPECT_EQ(message("parts:"), "method parts: setting : unknown; there are coherence, levels");
  EXPECT_EQ(message("parts:x=1"), "method parts: setting x: unknown; there are coherence, levels");
  EXPECT_EQ(message("parts:levels=3:"),
            "method parts: setting : unknown; there are coherence, levels");
  EXPECT_EQ(message("parts:levels=99"), "method parts: setting levels=99: its values are 1 to 12");
}

TEST(AllMethods, HaveSettingsThatCanBeSet) {
  for (const Method* method : allMethods()) {
    const std::string name(method->info().name);
    std::set<std::string_view> names;
    for (const Setting& setting : method->settings()) {
      EXPECT_TRUE(names.insert(setting.name).second) << name << ": " << setting.name;
      for (const double value : {setting.least, setting.standard, setting.most}) {
        ConfiguredMethods methods(allMethods());
        const std::string full =
            name + ":" + std::string(setting.name) + "=" + valueText(setting, value);
        const auto configured = methods.find(full);
        ASSERT_TRUE(configured.ok()) << configured.error().message;
        EXPECT_EQ(configured.value()->info().name, full);
      }
    }
  }
}

TEST(AcceptedLoss, IsTheDemandsNumberWhateverTheSetting) {
  Camera camera = cameraFromLookAt({}, {}).value();
  Demand demand;
  demand.accepted_missed_px = 20.0F;
  EXPECT_EQ(acceptedLossPx(camera, demand, 300.0), 0.0) << "a superset is demanded";
  demand.guarantee = Guarantee::kApproximate;
  EXPECT_EQ(acceptedLossPx(camera, demand, 300.0), 20.0);
  EXPECT_EQ(acceptedLossPx(camera, demand, 5.0), 20.0);
  demand.accepted_missed_px = 0.0F;
  EXPECT_EQ(acceptedLossPx(camera, demand, 300.0), 300.0);
  camera.motion.radius_m = 0.1;
  EXPECT_EQ(acceptedLossPx(camera, demand, 300.0), 0.0) << "it may be lost from another eye";
}

}  // namespace
}  // namespace culld
