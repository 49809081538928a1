// A dump as the engine's scene: its boxes are objects that never block, its meshes are objects too.
#pragma once
#include <cstdint>

#include "culling/core/camera.h"
#include "culling/scene/scene_snapshot.h"
#include "tests/bench/dump_file.h"

namespace culld::bench {

/// Object i is box i of the dump; occluder meshes follow.
SnapshotPtr toSnapshot(const Dump& dump);
Result<Camera> toCamera(const DumpCamera& camera, ImageSize image);

/// What every engine must beat: boxes one by one against the six planes, in plain scalar code.
/// Returns how many are not outside one of them.
std::uint32_t scanBoxes(const std::vector<DumpBox>& boxes, const DumpCamera& camera);

}  // namespace culld::bench
