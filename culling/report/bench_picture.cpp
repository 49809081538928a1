#include "culling/report/bench_picture.h"

#include "culling/report/frame_picture.h"

namespace culld::report {
namespace {

constexpr std::uint32_t kWidthPx = 960;

}  // namespace

void WorstFrame::consider(std::size_t camera, std::span<const ObjectId> answered,
                          const Checked& checked, std::size_t visible) {
  const Missed missed{checked.missed_px, checked.missed + checked.missed_subpixel};
  const std::size_t in_vain = answered.size() + missed.second - visible;
  if (any_ && std::tie(missed, in_vain) <= std::tie(missed_, in_vain_)) return;
  any_ = true;
  camera_ = camera;
  missed_ = missed;
  in_vain_ = in_vain;
  answered_.assign(answered.begin(), answered.end());
}

Result<std::string> WorstFrame::draw(const SceneSnapshot& scene, const Oracle& oracle,
                                     const Camera& camera, const OracleOptions& options,
                                     const std::string& title) const {
  const auto truth = oracle.look(camera, options);
  if (!truth) return truth.error();
  const std::vector<Verdict> verdicts = culld::judge(scene, truth.value(), answered_);
  return pngFromCamera({&scene, &oracle, camera, verdicts, title}, kWidthPx);
}

}  // namespace culld::report
