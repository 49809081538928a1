#include "culling/report/frame_picture.h"

namespace culld {

std::vector<Verdict> judge(const SceneSnapshot& scene, const OracleAnswer& truth,
                           std::span<const ObjectId> answered) {
  std::vector<Verdict> verdicts(scene.objectCount(), Verdict::kOutside);
  for (const ObjectId id : truth.in_frustum) verdicts[id] = Verdict::kLeftOut;
  for (const ObjectId id : answered) verdicts[id] = Verdict::kKept;
  for (const ObjectId id : truth.visible) {
    verdicts[id] = verdicts[id] == Verdict::kKept ? Verdict::kSeen : Verdict::kMissed;
  }
  return verdicts;
}

}  // namespace culld
