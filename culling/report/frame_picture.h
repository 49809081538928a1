// Pictures of one answered frame, for people: what is seen, what was kept although hidden, what was
// left out. From the camera, and as a map from above.
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "culling/core/camera.h"
#include "culling/core/result.h"
#include "culling/culler.h"
#include "culling/oracle/oracle.h"

namespace culld {

/// What became of an object.
enum class Verdict : std::uint8_t {
  kOutside,  ///< of the frustum, and not answered
  kLeftOut,  ///< in the frustum, not answered, not seen
  kKept,     ///< answered, and not seen
  kSeen,     ///< answered, and truly visible
  kMissed,   ///< truly visible, and not answered: must not happen
};
inline constexpr std::size_t kVerdictCount = 5;

/// One per object of the scene. REQUIRES: `answered` ascending, ids of the scene.
std::vector<Verdict> judge(const SceneSnapshot& scene, const OracleAnswer& truth,
                           std::span<const ObjectId> answered);

/// REQUIRES: all of the same scene; what is pointed to outlives the drawing.
struct FrameToDraw {
  const SceneSnapshot* scene = nullptr;
  const Oracle* oracle = nullptr;
  Camera camera;
  std::span<const Verdict> verdicts;  ///< from judge()
  std::string title;                  ///< e.g. "city.glb, camera 3, raster"
};

inline constexpr std::uint32_t kPictureWidthPx = 1280;

/// Surfaces as the camera sees them; hidden objects drawn through them.
/// ERROR: kIo naming the path; kUnavailable from the oracle.
Result<void> drawFromCamera(const FrameToDraw& frame, const std::string& path_png,
                            std::uint32_t width_px = kPictureWidthPx);

/// The same as the bytes of a PNG. ERROR: kUnavailable from the oracle or the drawing library.
Result<std::string> pngFromCamera(const FrameToDraw& frame,
                                  std::uint32_t width_px = kPictureWidthPx);

/// A map with y pointing at the viewer, the frustum, and where the camera's rays end.
/// ERROR: as above.
Result<void> drawFromAbove(const FrameToDraw& frame, const std::string& path_png,
                           std::uint32_t width_px = kPictureWidthPx);

}  // namespace culld
