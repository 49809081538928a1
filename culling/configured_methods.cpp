// Methods under names that say their settings: what a program takes on its command line.
#include <algorithm>

#include "culling/culler.h"

namespace culld {
namespace {

/// The method under a name that says its settings.
class ConfiguredMethod final : public Method {
 public:
  ConfiguredMethod(std::string name, std::unique_ptr<const Method> method)
      : name_(std::move(name)), method_(std::move(method)) {}

  MethodInfo info() const noexcept override {
    MethodInfo info = method_->info();
    info.name = name_;
    return info;
  }
  Result<void> accepts(const SceneProfile& profile) const override {
    return method_->accepts(profile);
  }
  Result<std::unique_ptr<Culler>> prepare(SnapshotPtr scene, const Clock& clock) const override {
    return method_->prepare(std::move(scene), clock);
  }
  Result<std::unique_ptr<Culler>> prepareBeside(const Culler& sibling, SnapshotPtr scene,
                                                const Clock& clock) const override {
    return method_->prepareBeside(sibling, std::move(scene), clock);
  }

 private:
  std::string name_;
  std::unique_ptr<const Method> method_;
};

Error unknownMethod(std::string_view name, std::span<const Method* const> methods) {
  std::string known;
  for (const Method* method : methods) {
    if (method->info().name.find(':') != std::string_view::npos) continue;
    known += (known.empty() ? "" : ", ") + std::string(method->info().name);
  }
  return invalidInput("method " + std::string(name) + ": unknown; there are " + known);
}

}  // namespace

const Method* findMethod(std::span<const Method* const> methods, std::string_view name) noexcept {
  const auto at = std::find_if(methods.begin(), methods.end(),
                               [&](const Method* method) { return method->info().name == name; });
  return at == methods.end() ? nullptr : *at;
}

Result<const Method*> ConfiguredMethods::find(const std::string& name) {
  if (const Method* known = findMethod(methods_, name); known != nullptr) return known;
  const std::string plain = name.substr(0, name.find(':'));
  const Method* method = findMethod(methods_, plain);
  if (method == nullptr) return unknownMethod(plain, methods_);

  SettingValues values(method->settings());
  for (std::size_t at = plain.size(); at < name.size();) {
    const std::size_t end = std::min(name.find(':', at + 1), name.size());
    if (auto set = values.set(std::string_view(name).substr(at + 1, end - at - 1)); !set) {
      return invalidInput("method " + plain + ": " + set.error().message);
    }
    at = end;
  }
  own_.push_back(std::make_unique<const ConfiguredMethod>(name, method->with(values)));
  methods_.push_back(own_.back().get());
  return methods_.back();
}

}  // namespace culld
