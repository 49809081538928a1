// One answered frame held against the oracle: figures, and the objects that should not be missing.
#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "culling/core/camera.h"
#include "culling/core/result.h"
#include "culling/oracle/oracle.h"
#include "culling/scene/scene_snapshot.h"

namespace culld::bench {

struct AnsweredFrame {
  std::size_t camera = 0;         ///< index in the cameras file
  std::vector<ObjectId> visible;  ///< ascending, unique
};

struct Inputs {
  std::string name;  ///< the scene's file name
  SnapshotPtr scene;
  std::vector<Camera> cameras;
  std::string method, guarantee;
  std::vector<AnsweredFrame> frames;
};

/// ERROR: one line naming the file and the place: unreadable, not an answers file, a node that is
/// not an object of the scene, a camera that is not in the cameras file.
Result<Inputs> readInputs(const std::string& scene, const std::string& cameras,
                          const std::string& answers);

struct MissedObject {
  std::uint32_t node = 0, instance = 0;
  float pixels = 0.0F;  ///< 0: below a pixel
};

struct CheckedFrame {
  std::size_t camera = 0;
  std::size_t in_frustum = 0;  ///< objects whose box reaches into the frustum, from any pose
  std::size_t answered = 0;
  std::size_t visible = 0;           ///< truly, by the oracle, sub-pixel ones included
  std::size_t visible_subpixel = 0;  ///< met by aimed rays only
  std::size_t missed = 0;            ///< seen by samples and not answered
  std::size_t missed_subpixel = 0;   ///< seen by aimed rays only, and not answered
  double missed_px = 0.0;
  std::size_t ties_left_out = 0;  ///< not answered, at the depth of what hides them: no fault
  std::uint64_t frustum_triangles = 0, answered_triangles = 0;
  std::uint64_t rays = 0;
  double oracle_s = 0.0;
  std::vector<MissedObject> examples;  ///< a few of the missed
  OracleAnswer truth;                  ///< of all poses within the camera's motion bound

  double excess() const {
    return visible == 0 ? 1.0 : static_cast<double>(answered) / static_cast<double>(visible);
  }
};

/// What any pose within the camera's motion bound sees must be answered (Oracle::look).
Result<CheckedFrame> checkFrame(const Inputs& inputs, const AnsweredFrame& answered,
                                const Oracle& oracle, const OracleOptions& options);

/// Writes DIR/camera-NNN.png and DIR/above-NNN.png.
Result<void> drawFrame(const Inputs& inputs, const AnsweredFrame& answered,
                       const CheckedFrame& checked, const Oracle& oracle, const std::string& dir);

}  // namespace culld::bench
