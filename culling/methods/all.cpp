// The table of all methods. Explicit: a static library drops objects that register themselves.
#include "culling/culler.h"
#include "culling/methods/frustum.h"
#include "culling/methods/raster.h"

namespace culld {

std::string_view guaranteeName(Guarantee guarantee) noexcept {
  switch (guarantee) {
    case Guarantee::kConservative:
      return "conservative";
    case Guarantee::kHole:
      return "hole";
    case Guarantee::kSampled:
      return "sampled";
    case Guarantee::kApproximate:
      break;
  }
  return "approximate";
}

std::span<const Method* const> allMethods() noexcept {
  static const Method* const methods[] = {&frustumMethod(), &rasterMethod()};
  return methods;
}

const Method* findMethod(std::string_view name) noexcept {
  for (const Method* method : allMethods()) {
    if (method->info().name == name) return method;
  }
  return nullptr;
}

}  // namespace culld
