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

}  // namespace

std::vector<std::string> simdTargets() {
  std::vector<std::string> names;
  for (std::int64_t target : hwy::SupportedAndGeneratedTargets())
    names.push_back(lowerName(target));
  return names;
}

Result<void> forceSimdTarget(std::string_view name) {
  if (name == "auto") {
    hwy::SetSupportedTargetsForTest(0);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    return Done{};
  }
  hwy::SetSupportedTargetsForTest(0);  // forget an earlier choice before listing
  std::string known;
  for (std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
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
