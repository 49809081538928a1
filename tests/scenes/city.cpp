#include "tests/scenes/city.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "tests/scenes/city_cameras.h"
#include "tests/scenes/city_meshes.h"
#include "tests/scenes/random.h"
#include "tests/scenes/shapes.h"

namespace culld::scenes {
namespace {

constexpr std::uint32_t kObjectsPerBlock = 300;
constexpr std::uint32_t kDistrictBlocks = 4;  // along each side of a district

/// Whole centimetres: short numbers in the file.
double centimetres(double metres) { return std::round(metres * 100.0) / 100.0; }

Rows quarters(std::uint32_t k, const glm::dvec3& o) {
  static constexpr std::array<double, 4> kCosines{1, 0, -1, 0}, kSines{0, 1, 0, -1};
  const double c = kCosines[k % 4], s = kSines[k % 4];
  return {c, 0, s, o.x, 0, 1, 0, o.y, -s, 0, c, o.z};
}

class CityMaker {
 public:
  explicit CityMaker(const CityOptions& options)
      : options_(options), random_(options.seed), meshes_(makeCityMeshes(model_, random_)) {
    const std::uint32_t blocks = std::max(1U, options.objects / kObjectsPerBlock);
    columns_ = std::max(1U, static_cast<std::uint32_t>(std::sqrt(static_cast<double>(blocks))));
    rows_ = std::max(1U, blocks / columns_);
  }

  City make() {
    root_ = model_.addNode({kNone, kNone, kIdentity, "city"});
    for (std::uint32_t j = 0; j < rows_; ++j) {
      for (std::uint32_t i = 0; i < columns_; ++i) addBlock(i, j);
    }
    addHills();
    furnish();
    const CityExtent extent{columns_, rows_, highest_};
    return {std::move(model_), cityCameras(extent, options_.frames)};
  }

 private:
  struct Floor {
    std::uint32_t node;
    FloorPlan plan;
    bool shaft;
  };

  std::uint32_t group(std::uint32_t parent, const Rows& rows, std::string name) {
    return model_.addNode({parent, kNone, rows, std::move(name)});
  }
  void put(std::uint32_t parent, std::uint32_t mesh, const Rows& rows) {
    ++objects_;
    model_.addNode({parent, mesh, rows, ""});
  }
  template <typename T>
  const T& any(const std::vector<T>& from) {
    return from[random_.below(static_cast<std::uint32_t>(from.size()))];
  }

  std::uint32_t districtOf(std::uint32_t i, std::uint32_t j) {
    const std::uint32_t a = i / kDistrictBlocks, b = j / kDistrictBlocks;
    const std::uint32_t across = (columns_ + kDistrictBlocks - 1) / kDistrictBlocks;
    districts_.resize(std::max(districts_.size(), std::size_t{b + 1} * across), kNone);
    std::uint32_t& district = districts_[b * across + a];
    if (district == kNone) {
      district = group(root_, kIdentity, "district " + std::to_string(a) + "-" + std::to_string(b));
    }
    return district;
  }

  void addBlock(std::uint32_t i, std::uint32_t j) {
    const glm::dvec3 centre((i - (columns_ - 1) / 2.0) * kBlockPitch, 0.0,
                            (j - (rows_ - 1) / 2.0) * kBlockPitch);
    const std::uint32_t block = group(districtOf(i, j), movedBy(centre),
                                      "block " + std::to_string(i) + "-" + std::to_string(j));
    put(block, any(meshes_.grounds),
        scaledAndMoved({kBlockPitch, 1, kBlockPitch}, {-kBlockPitch / 2, -0.05, -kBlockPitch / 2}));
    put(block, meshes_.pavement,
        scaledAndMoved({2 * kPavementHalf, 0.2, 2 * kPavementHalf}, {0, kPavementTop, 0}));
    fillLots(block, std::hypot(centre.x, centre.z) / reach());
    addStreetThings(block);
  }

  double reach() const { return 0.5 * kBlockPitch * std::max({columns_, rows_, 2U}); }

  /// Towers in the middle, houses at the rim, parks everywhere.
  void fillLots(std::uint32_t block, double from_centre) {
    const double dice = random_.unit();
    if (dice < 0.1) return addPark(block);
    if (from_centre < 0.35) {
      if (dice < 0.3) return addBuilding(block, any(meshes_.landmarks), {0, kPavementTop, 0});
      return addFour(block, meshes_.towers, meshes_.blocks);
    }
    if (from_centre < 0.75 && dice < 0.85) return addFour(block, meshes_.blocks, meshes_.blocks);
    if (dice > 0.6) return addFour(block, meshes_.blocks, meshes_.houses);
    for (int x = -1; x <= 1; ++x) {
      for (int z = -1; z <= 1; ++z) {
        addBuilding(block, any(meshes_.houses), {15.0 * x, kPavementTop, 15.0 * z});
      }
    }
  }

  void addFour(std::uint32_t block, const std::vector<Building>& often,
               const std::vector<Building>& seldom) {
    for (const double x : {-11.5, 11.5}) {
      for (const double z : {-11.5, 11.5}) {
        addBuilding(block, any(random_.chance(0.7) ? often : seldom), {x, kPavementTop, z});
      }
    }
  }

  void addBuilding(std::uint32_t block, const Building& kind, const glm::dvec3& at) {
    const std::uint32_t node = group(block, quarters(random_.below(4), at), "building");
    put(node, kind.shell, kIdentity);
    if (kind.core) {
      put(node, meshes_.shaft,
          scaledAndMoved({2 * kShaftHalf, kind.height - 0.5, 2 * kShaftHalf},
                         {0, kind.height - 0.5, 0}));
      for (const double x : {-0.4, 0.4}) {
        put(node, meshes_.cooler, movedBy({x * kind.half_x * 0.4, kind.height, 0}));
      }
      put(node, meshes_.antenna, movedBy({0, kind.height, 1}));
    }
    highest_ = std::max(highest_, at.y + kind.height + 5.0);
    for (const FloorPlan& plan : kind.floors) {
      const std::uint32_t floor = group(node, movedBy({plan.centre_x, plan.y, plan.centre_z}), "");
      put(floor, meshes_.slab,
          scaledAndMoved({2 * plan.half_x, 0.2, 2 * plan.half_z}, glm::dvec3(0.0)));
      floors_.push_back({floor, plan, kind.core});
    }
  }

  void addPark(std::uint32_t block) {
    put(block, meshes_.lawn, scaledAndMoved({46, 0.1, 46}, {0, kPavementTop + 0.05, 0}));
    for (int i = 0; i < 40; ++i) putLoose(block, any(meshes_.trees), 21.0);
    for (int i = 0; i < 8; ++i) putLoose(block, meshes_.bench, 21.0);
  }

  void putLoose(std::uint32_t block, std::uint32_t mesh, double half) {
    const glm::dvec3 at{centimetres(random_.uniform(-half, half)), kPavementTop + 0.05,
                        centimetres(random_.uniform(-half, half))};
    put(block, mesh, quarters(random_.below(4), at));
  }

  /// Along the four sides of a block; the pavement ends at 26 m, the street's middle is at 32 m.
  void addStreetThings(std::uint32_t block) {
    for (std::uint32_t side = 0; side < 4; ++side) {
      const auto along = [&](std::uint32_t mesh, double t, double out, std::uint32_t turn) {
        const double y = out < kPavementHalf ? kPavementTop : 0.0;
        const Rows there =
            composed(quarters(side, glm::dvec3(0.0)), quarters(turn, {centimetres(t), y, out}));
        put(block, mesh, there);
      };
      for (const double t : {-18.0, 0.0, 18.0}) along(meshes_.lamp, t, 25.4, 3);
      for (const double t : {-12.0, 10.0}) {
        const std::uint32_t turn = random_.below(4);
        along(any(meshes_.trees), t, 24.6, turn);
      }
      along(meshes_.bench, random_.uniform(-9, 6), 24.0, 0);
      along(meshes_.bin, random_.uniform(-20, 20), 25.2, 0);
      along(meshes_.sign, 22.5, 25.5, random_.below(4));
      if (random_.chance(0.4)) along(meshes_.hydrant, random_.uniform(-16, 16), 25.6, 0);
      for (const double t : {-16.0, -9.0, -2.0, 5.0, 12.0}) {
        const double parked = t + random_.uniform(-0.8, 0.8);
        if (random_.chance(0.55)) along(any(meshes_.cars), parked, 27.3, 0);
      }
      const double driving = random_.uniform(-18, 18);
      if (random_.chance(0.3)) along(any(meshes_.cars), driving, 29.7, 2);
    }
  }

  /// Terrain around the city: flat where they meet, higher further out.
  void addHills() {
    const double half_x = 0.5 * kBlockPitch * columns_, half_z = 0.5 * kBlockPitch * rows_;
    const auto height = [&](double x, double z) {
      const double out = std::max({std::abs(x) - half_x, std::abs(z) - half_z, 0.0});
      const double waves = 2.0 + std::sin(x / 71.0) + std::cos(z / 53.0 + x / 190.0);
      return 0.08 * out * waves - 0.05;
    };
    const std::uint32_t hills = group(root_, kIdentity, "hills");
    for (int i = -2; i < 6; ++i) {
      for (int j = -2; j < 6; ++j) {
        if (i >= 0 && i < 4 && j >= 0 && j < 4) continue;
        const glm::dvec3 size(half_x / 2, 0, half_z / 2);
        const glm::dvec3 corner(i * size.x - half_x, 0, j * size.z - half_z);
        put(hills, hillMesh(corner, size, height), movedBy(corner));
      }
    }
  }

  template <typename Height>
  std::uint32_t hillMesh(const glm::dvec3& corner, const glm::dvec3& size, const Height& height) {
    Triangles tile = bumpySheet(12, 0.0, random_);
    for (glm::vec3& p : tile.positions) {
      const glm::dvec3 at(p.x * size.x, 0, p.z * size.z);
      p = glm::vec3(glm::dvec3(at.x, height(corner.x + at.x, corner.z + at.z), at.z));
    }
    return model_.addMesh({"hill", {{std::move(tile), meshes_.earth}}});
  }

  /// What is still missing goes into the rooms, evenly.
  void furnish() {
    if (objects_ >= options_.objects || floors_.empty()) return;
    const std::uint32_t missing = options_.objects - objects_;
    const auto floors = static_cast<std::uint32_t>(floors_.size());
    for (std::uint32_t f = 0; f < floors; ++f) {
      furnishFloor(floors_[f], missing / floors + (f < missing % floors ? 1 : 0));
    }
  }

  void furnishFloor(const Floor& floor, std::uint32_t count) {
    std::vector<glm::dvec2> spots;
    double pitch = 2.4;
    while (spots.size() < count) {
      spots = spotsOf(floor, pitch);
      pitch *= 0.8;
    }
    for (std::uint32_t k = 0; k < count; ++k) {
      const std::uint32_t other = k + random_.below(static_cast<std::uint32_t>(spots.size()) - k);
      std::swap(spots[k], spots[other]);
      const glm::dvec3 at(centimetres(spots[k].x), 0.0, centimetres(spots[k].y));
      if (random_.chance(0.15)) {
        put(floor.node, meshes_.partition,
            composed(quarters(random_.below(2), {at.x, 2.7, at.z}),
                     scaledAndMoved({1.8, 2.7, 0.12}, glm::dvec3(0.0))));
      } else {
        const std::uint32_t turn = random_.below(4);
        put(floor.node, any(meshes_.furniture), quarters(turn, at));
      }
    }
  }

  /// A grid over the floor, 1.1 m from its rim and clear of the shaft.
  static std::vector<glm::dvec2> spotsOf(const Floor& floor, double pitch) {
    std::vector<glm::dvec2> spots;
    const double reach_x = floor.plan.half_x - 1.1, reach_z = floor.plan.half_z - 1.1;
    for (double x = -reach_x; x <= reach_x; x += pitch) {
      for (double z = -reach_z; z <= reach_z; z += pitch) {
        const bool in_shaft = floor.shaft && std::max(std::abs(x), std::abs(z)) < kShaftHalf + 1.0;
        if (!in_shaft) spots.emplace_back(x, z);
      }
    }
    return spots;
  }

  const CityOptions options_;
  Model model_;
  Random random_;
  const CityMeshes meshes_;
  std::uint32_t columns_ = 0, rows_ = 0;
  std::uint32_t root_ = 0;
  std::uint32_t objects_ = 0;
  double highest_ = 0.0;
  std::vector<std::uint32_t> districts_;
  std::vector<Floor> floors_;
};

}  // namespace

City generateCity(const CityOptions& options) { return CityMaker(options).make(); }

}  // namespace culld::scenes
