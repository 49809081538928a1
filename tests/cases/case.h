// The stiff and extreme cases: families of scenes and cameras, each with one quantity that is
// pushed from harmless to where something gives. Every method must keep its promise on all of them;
// what the price is, docs/stability.md shows.
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "culling/core/ids.h"
#include "culling/scene/scene_snapshot.h"
#include "tests/cases/case_builder.h"
#include "tests/scenes/camera_spec.h"

namespace culld::cases {

struct Family {
  std::string_view name;      ///< fit for a file's name
  std::string_view quantity;  ///< what is pushed
  std::string_view unit;      ///< empty: a ratio or a number
  std::vector<double> steps;  ///< in the order in which it gets harder
  /// Steps above are for the curves only: they take seconds.
  double quick_up_to = 0.0;
  /// Either a whole case, or a view onto a wall: things behind, before and beside it follow.
  void (*make)(CaseBuilder& builder, double value) = nullptr;
  Sight (*sight)(CaseBuilder& builder, double value) = nullptr;
};

/// All of them, an explicit table.
std::span<const Family> families();
/// nullptr if there is none of that name.
const Family* findFamily(std::string_view name);

/// Same family, value and seed: same case. Seed 0 stands straight at the world's origin, every
/// other seed turns and moves scene and cameras together.
Case makeCase(const Family& family, double value, std::uint64_t seed);

/// One thing behind one wall: how far behind must it be to be left out?
struct Probe {
  SnapshotPtr scene;
  scenes::CameraSpec camera;
  ObjectId occludee = 0;
  double distance_m = 0.0;  ///< of the wall
};

/// The thing stands at distance * (1 + gap). None if the family has no such wall.
std::optional<Probe> makeProbe(const Family& family, double value, std::uint64_t seed, double gap);

}  // namespace culld::cases
