// Scenes that differ in what occlusion can bring: open ones where nothing is hidden, and closed
// rooms where nearly everything is. Metres, y up, each with a walk through it.
#pragma once
#include <cstdint>
#include <vector>

#include "tests/scenes/camera_spec.h"
#include "tests/scenes/model.h"

namespace culld::scenes {

struct Landscape {
  Model model;
  std::vector<CameraSpec> cameras;
};

struct LandscapeOptions {
  std::uint64_t seed = 1;
  std::uint32_t objects = 2'000;  ///< exactly this many; at least 400, of rooms 100
  std::uint32_t frames = 60;
};

/// A round field of 80 m with small things on it, seen from stands 12 m high that go around it.
Landscape arena(const LandscapeOptions& options);

/// 800 m of gently rolling ground with stones, crossed at a rider's height.
Landscape sparseTerrain(const LandscapeOptions& options);

/// A square of closed rooms with doors and furniture; the walk goes from room to room.
Landscape closedRooms(const LandscapeOptions& options);

}  // namespace culld::scenes
