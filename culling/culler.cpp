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

double acceptedLossPx(const Camera& camera, const Demand& demand, double by_setting_px) noexcept {
  if (demand.guarantee != Guarantee::kApproximate || !camera.motion.still()) return 0.0;
  const auto demanded_px = static_cast<double>(demand.accepted_missed_px);
  return demanded_px > 0.0 ? demanded_px : by_setting_px;
}

}  // namespace culld
