#include "culling/culler.h"

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

}  // namespace culld
