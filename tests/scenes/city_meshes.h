// The parts that the sample city is built from: few meshes, shared by very many objects.
#pragma once
#include <cstdint>
#include <vector>

#include "tests/scenes/model.h"
#include "tests/scenes/random.h"

namespace culld::scenes {

/// Around the building's own middle.
struct FloorPlan {
  double y = 0.0;                     ///< of the floor's upper side
  double half_x = 0.0, half_z = 0.0;  ///< a rectangle that lies within the outer walls
  double centre_x = 0.0, centre_z = 0.0;
};

struct Building {
  std::uint32_t shell = 0;  ///< mesh
  double half_x = 0.0, half_z = 0.0, height = 0.0;
  std::vector<FloorPlan> floors;
  bool core = false;  ///< has a lift shaft in the middle
};

/// Mesh indices into the model, and buildings sorted by the lot they fit.
struct CityMeshes {
  std::uint32_t slab = 0, shaft = 0, partition = 0, pavement = 0,
                lawn = 0;  ///< unit boxes to scale
  std::uint32_t lamp = 0, bench = 0, bin = 0, sign = 0, hydrant = 0, cooler = 0, antenna = 0;
  std::vector<std::uint32_t> trees, cars, furniture, grounds;
  std::vector<Building> houses, blocks, towers, landmarks;
  std::uint32_t earth = 0;  ///< material of the hills
};

inline constexpr double kStorey = 3.25;      ///< metres from floor to floor
inline constexpr double kShaftHalf = 1.5;    ///< of the lift shaft
inline constexpr double kBlockPitch = 64.0;  ///< from street to street
inline constexpr double kPavementHalf = 26.0;
inline constexpr double kPavementTop = 0.15;

/// Adds all materials and meshes to the model.
CityMeshes makeCityMeshes(Model& model, Random& random);

}  // namespace culld::scenes
