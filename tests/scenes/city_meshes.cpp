#include "tests/scenes/city_meshes.h"

#include <array>
#include <initializer_list>
#include <string>
#include <utility>

#include "tests/scenes/shapes.h"

namespace culld::scenes {
namespace {

struct Materials {
  std::uint32_t asphalt, stone, grass, earth, brick, concrete, plaster, roof, pane, metal, wood,
      fabric, foliage, white;
  std::array<std::uint32_t, 3> paint;
};

Materials makeMaterials(Model& model) {
  const auto plain = [&](const char* name, float r, float g, float b) {
    return model.addMaterial({name, {r, g, b, 1.0F}, Alpha::kOpaque, false});
  };
  Materials m{};
  m.asphalt = plain("asphalt", 0.25F, 0.25F, 0.27F);
  m.stone = plain("stone", 0.55F, 0.55F, 0.53F);
  m.grass = plain("grass", 0.35F, 0.5F, 0.25F);
  m.earth = plain("earth", 0.45F, 0.42F, 0.3F);
  m.brick = plain("brick", 0.6F, 0.32F, 0.25F);
  m.concrete = plain("concrete", 0.62F, 0.62F, 0.6F);
  m.plaster = model.addMaterial({"plaster", {0.85F, 0.8F, 0.68F, 1.0F}, Alpha::kOpaque, true});
  m.roof = plain("roof", 0.4F, 0.25F, 0.22F);
  m.pane = model.addMaterial({"pane", {0.5F, 0.65F, 0.75F, 0.4F}, Alpha::kBlend, true});
  m.metal = plain("metal", 0.35F, 0.36F, 0.38F);
  m.wood = plain("wood", 0.5F, 0.36F, 0.22F);
  m.fabric = plain("fabric", 0.3F, 0.35F, 0.5F);
  m.foliage = model.addMaterial({"foliage", {0.2F, 0.42F, 0.16F, 1.0F}, Alpha::kMask, true});
  m.white = plain("white", 0.9F, 0.9F, 0.88F);
  m.paint = {plain("red paint", 0.7F, 0.15F, 0.12F), plain("blue paint", 0.15F, 0.25F, 0.6F),
             plain("grey paint", 0.5F, 0.5F, 0.52F)};
  return m;
}

struct Span3 {
  glm::vec3 min, max;
};

Triangles boxes(std::initializer_list<Span3> spans) {
  Triangles all;
  for (const Span3& s : spans) append(all, box(s.min, s.max));
  return all;
}

Triangles post(std::uint32_t sides, float radius, float low, float high) {
  return prism(regularFootprint(sides, radius), low, high);
}

/// A slab on four legs.
Triangles onLegs(float half_x, float half_z, float top, float thickness, float leg) {
  Triangles all = box({-half_x, top - thickness, -half_z}, {half_x, top, half_z});
  for (const float x : {-half_x, half_x - leg}) {
    for (const float z : {-half_z, half_z - leg}) {
      append(all, box({x, 0, z}, {x + leg, top - thickness, z + leg}));
    }
  }
  return all;
}

/// Storeys of windows in a wall of width 2 half_x: the wall's front is z = 0, towards +z. Around
/// each opening four trapezoids, so neighbours share all vertices; four strips go inwards.
void addWindowedWall(Triangles& wall, Triangles& panes, const Rows& placed, float half_x,
                     std::uint32_t bays, std::uint32_t storeys) {
  const float bay = 2 * half_x / static_cast<float>(bays), depth = 0.25F;
  const auto storey = static_cast<float>(kStorey);
  Triangles one, reveal;
  append(one, wallWithHole({0, 0}, {0.5F, 0.5F}),
         {bay / 2, 0, 0, 0, 0, storey / 2, 0, storey / 2, 0, 0, 1, 0});
  const std::array<glm::vec3, 4> rim{one.positions[4], one.positions[5], one.positions[6],
                                     one.positions[7]};
  for (std::size_t k = 0; k < 4; ++k) {
    append(reveal, quad(rim[k], rim[(k + 1) % 4] - rim[k], {0, 0, -depth}));
  }
  append(one, reveal);
  const Triangles pane =
      quad(rim[0] - glm::vec3(0, 0, depth / 2), rim[1] - rim[0], rim[3] - rim[0]);
  for (std::uint32_t s = 0; s < storeys; ++s) {
    for (std::uint32_t b = 0; b < bays; ++b) {
      const Rows there = composed(placed, movedBy({(b + 0.5) * bay - half_x, s * kStorey, 0.0}));
      append(wall, one, there);
      append(panes, pane, there);
    }
  }
}

/// A quarter turn k times about +y, without rounding.
Rows quarters(int k, const glm::dvec3& o) {
  const std::array<double, 4> cosines{1, 0, -1, 0}, sines{0, 1, 0, -1};
  const double c = cosines[static_cast<std::size_t>(k)], s = sines[static_cast<std::size_t>(k)];
  return {c, 0, s, o.x, 0, 1, 0, o.y, -s, 0, c, o.z};
}

class MeshMaker {
 public:
  MeshMaker(Model& model, Random& random)
      : model_(model), random_(random), m_(makeMaterials(model)) {}

  CityMeshes make() {
    makeUnitBoxes();
    makeStreetThings();
    makeFurniture();
    for (int i = 0; i < 6; ++i) makeHouse(i);
    for (int i = 0; i < 6; ++i) makeWindowedBlock(i);
    for (int i = 0; i < 5; ++i) makeCornerBlock(i);
    for (int i = 0; i < 4; ++i) makePlainBlock(i);
    for (int i = 0; i < 8; ++i) makeRoundTower(i);
    for (int i = 0; i < 6; ++i) makeSteppedTower(i);
    return std::move(city_);
  }

 private:
  std::uint32_t mesh(const std::string& name, std::vector<Part> parts) {
    return model_.addMesh({name, std::move(parts)});
  }
  std::uint32_t unitBox(const std::string& name, std::uint32_t material) {
    return mesh(name, {{box({-0.5F, -1, -0.5F}, {0.5F, 0, 0.5F}), material}});  // its top at y = 0
  }

  void makeUnitBoxes() {
    city_.earth = m_.earth;
    city_.slab = unitBox("slab", m_.concrete);
    city_.shaft = unitBox("shaft", m_.concrete);
    city_.partition = unitBox("partition", m_.white);
    city_.pavement = unitBox("pavement", m_.stone);
    city_.lawn = unitBox("lawn", m_.grass);
    for (int i = 0; i < 3; ++i) {
      city_.grounds.push_back(mesh("ground", {{bumpySheet(6, 0.04, random_), m_.asphalt}}));
    }
  }

  void makeStreetThings() {
    Triangles lamp = post(8, 0.08F, 0, 5);
    append(lamp, box({-0.05F, 4.9F, -0.05F}, {1.2F, 5.05F, 0.05F}));
    city_.lamp = mesh(
        "lamp", {{lamp, m_.metal}, {box({0.7F, 4.8F, -0.12F}, {1.3F, 4.9F, 0.12F}), m_.white}});
    Triangles bench = onLegs(0.9F, 0.25F, 0.45F, 0.06F, 0.08F);
    append(bench, box({-0.9F, 0.45F, -0.25F}, {0.9F, 0.9F, -0.2F}));
    city_.bench = mesh("bench", {{bench, m_.wood}});
    city_.bin = mesh("bin", {{post(8, 0.25F, 0, 0.9F), m_.metal}});
    city_.hydrant = mesh("hydrant", {{post(6, 0.15F, 0, 0.7F), m_.paint[0]}});
    city_.sign = mesh("sign", {{post(6, 0.04F, 0, 2.4F), m_.metal},
                               {box({-0.35F, 1.8F, 0.04F}, {0.35F, 2.4F, 0.07F}), m_.paint[1]}});
    city_.cooler = mesh("cooler", {{box({-1, 0, -0.7F}, {1, 1.1F, 0.7F}), m_.metal},
                                   {post(12, 0.5F, 1.1F, 1.25F), m_.white}});
    city_.antenna = mesh("antenna", {{post(5, 0.06F, 0, 5), m_.metal}});
    for (const std::uint32_t paint : m_.paint) {
      Triangles wheels;
      for (const float x : {-1.3F, 1.3F}) {
        for (const float z : {-0.8F, 0.6F}) {
          append(wheels, post(8, 0.32F, 0, 0.2F), {1, 0, 0, x, 0, 0, -1, 0.32, 0, 1, 0, z});
        }
      }
      Triangles cabin;  // drawn in xz, set upright across the car
      append(cabin,
             prism(std::vector<glm::vec2>{{-1, 0}, {1.2F, 0}, {0.8F, -0.55F}, {-0.7F, -0.55F}},
                   -0.75F, 0.75F),
             {1, 0, 0, 0, 0, 0, -1, 0.95, 0, 1, 0, 0});
      city_.cars.push_back(mesh("car", {{box({-2.1F, 0.3F, -0.9F}, {2.1F, 0.95F, 0.9F}), paint},
                                        {wheels, m_.metal},
                                        {cabin, m_.metal}}));
    }
    for (int i = 0; i < 4; ++i) {
      const double height = random_.uniform(2.2, 3.4), radius = random_.uniform(1.2, 1.9);
      Triangles crown;
      append(crown, ball(5, 0.25, random_),
             scaledAndMoved(glm::dvec3(radius), {0, height + radius * 0.7, 0}));
      city_.trees.push_back(mesh(
          "tree", {{post(6, 0.16F, 0, static_cast<float>(height)), m_.wood}, {crown, m_.foliage}}));
    }
  }

  void makeFurniture() {
    auto& all = city_.furniture;
    all.push_back(mesh("table", {{onLegs(0.7F, 0.4F, 0.75F, 0.05F, 0.06F), m_.wood}}));
    Triangles chair = onLegs(0.22F, 0.22F, 0.45F, 0.04F, 0.04F);
    append(chair, box({-0.22F, 0.45F, -0.22F}, {0.22F, 0.95F, -0.18F}));
    all.push_back(mesh("chair", {{chair, m_.wood}}));
    all.push_back(mesh("cabinet", {{box({-0.5F, 0, -0.25F}, {0.5F, 1.8F, 0.22F}), m_.white},
                                   {boxes({{{-0.48F, 0.1F, 0.22F}, {-0.02F, 1.75F, 0.25F}},
                                           {{0.02F, 0.1F, 0.22F}, {0.48F, 1.75F, 0.25F}}}),
                                    m_.wood}}));
    all.push_back(mesh("bed", {{box({-0.5F, 0, -1}, {0.5F, 0.3F, 1}), m_.wood},
                               {boxes({{{-0.48F, 0.3F, -0.98F}, {0.48F, 0.5F, 0.98F}},
                                       {{-0.4F, 0.5F, -0.95F}, {0.4F, 0.6F, -0.6F}}}),
                                m_.fabric}}));
    Triangles shelf =
        boxes({{{-0.5F, 0, -0.18F}, {-0.47F, 2, 0.18F}}, {{0.47F, 0, -0.18F}, {0.5F, 2, 0.18F}}});
    for (int i = 0; i < 5; ++i) {
      const float y = 0.1F + 0.45F * static_cast<float>(i);
      append(shelf, box({-0.47F, y, -0.18F}, {0.47F, y + 0.03F, 0.18F}));
    }
    all.push_back(mesh("shelf", {{shelf, m_.wood}}));
    all.push_back(mesh("sofa", {{boxes({{{-0.9F, 0.1F, -0.4F}, {0.9F, 0.45F, 0.4F}},
                                        {{-0.9F, 0.45F, -0.4F}, {0.9F, 0.85F, -0.2F}},
                                        {{-1.05F, 0.1F, -0.4F}, {-0.9F, 0.6F, 0.4F}},
                                        {{0.9F, 0.1F, -0.4F}, {1.05F, 0.6F, 0.4F}}}),
                                 m_.fabric}}));
    Triangles desk = onLegs(0.8F, 0.4F, 0.73F, 0.04F, 0.05F);
    append(desk, box({-0.3F, 0.85F, -0.1F}, {0.3F, 1.2F, -0.06F}));
    append(desk, box({-0.03F, 0.73F, -0.1F}, {0.03F, 0.85F, -0.06F}));
    all.push_back(mesh("desk", {{desk, m_.metal}}));
    Triangles leaves;
    append(leaves, ball(3, 0.3, random_), scaledAndMoved({0.35, 0.5, 0.35}, {0, 0.85, 0}));
    all.push_back(mesh("plant", {{post(8, 0.2F, 0, 0.4F), m_.brick}, {leaves, m_.foliage}}));
    all.push_back(mesh("stool", {{post(12, 0.2F, 0, 0.5F), m_.fabric}}));
  }

  /// Floors of one size, from y = 0 up.
  static std::vector<FloorPlan> floorsOf(std::uint32_t count, double half_x, double half_z) {
    std::vector<FloorPlan> floors;
    for (std::uint32_t f = 0; f < count; ++f)
      floors.push_back({0.2 + f * kStorey, half_x, half_z, 0, 0});
    return floors;
  }

  void makeHouse(int i) {
    const float x = 4.0F + 0.25F * static_cast<float>(i % 3),
                z = 3.5F + 0.25F * static_cast<float>(i);
    const std::uint32_t storeys = 1 + static_cast<std::uint32_t>(i % 2);
    const auto height = static_cast<float>(storeys * kStorey);
    const float ridge = height + 2.5F;
    Triangles roof;  // a triangle in xz, set upright along z
    append(roof,
           prism(std::vector<glm::vec2>{{-x - 0.3F, 0}, {x + 0.3F, 0}, {0, -2.5F}}, -z - 0.3F,
                 z + 0.3F),
           {1, 0, 0, 0, 0, 0, -1, height, 0, 1, 0, 0});
    const std::uint32_t shell = mesh(
        "house",
        {{box({-x, 0, -z}, {x, height, z}), i % 2 == 0 ? m_.brick : m_.white}, {roof, m_.roof}});
    city_.houses.push_back({shell, x, z, ridge, floorsOf(storeys, x - 0.3, z - 0.3), false});
  }

  /// Real openings with panes in them: one looks into the rooms.
  void makeWindowedBlock(int i) {
    const float bay = 2.5F + 0.25F * static_cast<float>(i % 3);  // a sum of powers of two: no seams
    const float x = 3 * bay, z = 2.5F * bay;
    const std::uint32_t storeys = 3 + static_cast<std::uint32_t>(i);
    const auto height = static_cast<float>(storeys * kStorey);
    Triangles walls, panes;
    addWindowedWall(walls, panes, quarters(0, {0, 0, z}), x, 6, storeys);
    addWindowedWall(walls, panes, quarters(1, {x, 0, 0}), z, 5, storeys);
    addWindowedWall(walls, panes, quarters(2, {0, 0, -z}), x, 6, storeys);
    addWindowedWall(walls, panes, quarters(3, {-x, 0, 0}), z, 5, storeys);
    const Triangles roof =
        box({-x - 0.2F, height - 0.3F, -z - 0.2F}, {x + 0.2F, height + 0.5F, z + 0.2F});
    const std::uint32_t shell =
        mesh("windowed block", {{walls, m_.plaster}, {roof, m_.stone}, {panes, m_.pane}});
    city_.blocks.push_back({shell, x, z, height + 0.5, floorsOf(storeys, x - 0.4, z - 0.4), true});
  }

  /// An L with a parapet; its rooms are in the longer wing.
  void makeCornerBlock(int i) {
    const float x = 9.5F, z = 9.0F, wing = 6.5F;
    const std::uint32_t storeys = 4 + static_cast<std::uint32_t>(i);
    const auto height = static_cast<float>(storeys * kStorey + 0.8);
    const std::vector<glm::vec2> corner{
        {-x, -z}, {-x, z}, {-x + wing, z}, {-x + wing, -z + wing}, {x, -z + wing}, {x, -z}};
    Building building{
        mesh("corner block", {{prism(corner, 0, height, 3), i % 2 == 0 ? m_.brick : m_.concrete}}),
        x,
        z,
        height,
        {},
        false};
    building.floors = floorsOf(storeys, wing / 2 - 0.4, z - 0.4);
    for (FloorPlan& floor : building.floors) floor.centre_x = -x + wing / 2;
    city_.blocks.push_back(std::move(building));
  }

  /// Closed walls with bands of panes before them.
  void makePlainBlock(int i) {
    const float x = 7.5F + static_cast<float>(i), z = 9.0F - 0.5F * static_cast<float>(i);
    const std::uint32_t storeys = 5 + 2 * static_cast<std::uint32_t>(i);
    const auto height = static_cast<float>(storeys * kStorey + 0.5);
    Triangles bands;
    for (std::uint32_t s = 0; s < storeys; ++s) {
      const auto y = static_cast<float>(0.9 + s * kStorey);
      append(bands, quad({-x, y, z + 0.03F}, {2 * x, 0, 0}, {0, 1.5F, 0}));
      append(bands, quad({x, y, -z - 0.03F}, {-2 * x, 0, 0}, {0, 1.5F, 0}));
    }
    const std::uint32_t shell =
        mesh("plain block", {{box({-x, 0, -z}, {x, height, z}), m_.concrete}, {bands, m_.pane}});
    city_.blocks.push_back({shell, x, z, height, floorsOf(storeys, x - 0.4, z - 0.4), true});
  }

  void makeRoundTower(int i) {
    const std::array<std::uint32_t, 8> sides{8, 10, 12, 16, 20, 24, 6, 14};
    const std::uint32_t storeys = 12 + 3 * static_cast<std::uint32_t>(i);
    const bool large = i >= 6;
    const float radius = large ? 16.0F : 8.0F + 0.25F * static_cast<float>(i);
    const auto height = static_cast<float>(storeys * kStorey + 1.0);
    const std::uint32_t n = sides[static_cast<std::size_t>(i)];
    Triangles body = post(n, radius, 0, height);
    append(body, post(n, radius * 0.4F, height, height + 3));
    const double room = 0.6 * radius;  // a square in any polygon with 6 or more sides
    Building tower{mesh("round tower", {{body, i % 2 == 0 ? m_.concrete : m_.metal}}),
                   radius,
                   radius,
                   height + 3,
                   floorsOf(storeys, room, room),
                   true};
    (large ? city_.landmarks : city_.towers).push_back(std::move(tower));
  }

  void makeSteppedTower(int i) {
    const bool large = i >= 4;
    const std::uint32_t tier = 5 + static_cast<std::uint32_t>(i);
    const float base = large ? 17.0F : 9.5F, step = large ? 3.5F : 1.75F;
    Building tower{0, base, base, 3 * tier * kStorey + 1.0, {}, true};
    Triangles body;
    for (std::uint32_t t = 0; t < 3; ++t) {
      const float half = base - step * static_cast<float>(t);
      const auto top = static_cast<float>((t + 1) * tier * kStorey + (t == 2 ? 1.0 : 0.0));
      const auto low = static_cast<float>(t * tier * kStorey);
      append(body, box({-half, low, -half}, {half, top, half}));
      for (std::uint32_t f = 0; f < tier; ++f) {
        tower.floors.push_back({0.2 + (t * tier + f) * kStorey, half - 0.5, half - 0.5, 0, 0});
      }
    }
    tower.shell = mesh("stepped tower", {{body, i % 2 == 0 ? m_.stone : m_.concrete}});
    (large ? city_.landmarks : city_.towers).push_back(std::move(tower));
  }

  Model& model_;
  Random& random_;
  Materials m_;
  CityMeshes city_;
};

}  // namespace

CityMeshes makeCityMeshes(Model& model, Random& random) { return MeshMaker(model, random).make(); }

}  // namespace culld::scenes
