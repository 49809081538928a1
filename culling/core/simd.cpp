#include "culling/core/simd.h"

#include <hwy/highway.h>
#include <hwy/targets.h>

#include <cctype>

namespace culld {
namespace {

std::string lowerName(std::int64_t target) {
  std::string name = hwy::TargetName(target);
  for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return name;
}

/// Asked before anything is forced: later Highway would tell only of the forced one.
const std::vector<std::int64_t>& allTargets() {
  static const std::vector<std::int64_t> targets = hwy::SupportedAndGeneratedTargets();
  return targets;
}

}  // namespace

std::vector<std::string> simdTargets() {
  std::vector<std::string> names;
  for (std::int64_t target : allTargets()) names.push_back(lowerName(target));
  return names;
}

std::string activeSimdTarget() {
  allTargets();
  return lowerName(hwy::SupportedAndGeneratedTargets().front());
}

Result<void> forceSimdTarget(std::string_view name) {
  const std::vector<std::int64_t>& targets = allTargets();
  if (name == "auto") {
    hwy::SetSupportedTargetsForTest(0);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    return Done{};
  }
  std::string known;
  for (std::int64_t target : targets) {
    if (lowerName(target) == name) {
      hwy::SetSupportedTargetsForTest(target);
      hwy::GetChosenTarget().Update(target);
      return Done{};
    }
    known += (known.empty() ? "" : ", ") + lowerName(target);
  }
  return invalidInput("--simd=" + std::string(name) + ": not a target of this machine: " + known);
}

}  // namespace culld
