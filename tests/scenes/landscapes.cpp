#include "tests/scenes/landscapes.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/scenes/random.h"
#include "tests/scenes/shapes.h"

namespace culld::scenes {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

std::uint32_t meshOf(Model& model, const char* name, Triangles triangles) {
  return model.addMesh({name, {{std::move(triangles), 0}}});
}

void place(Model& model, std::uint32_t mesh, const Rows& rows) {
  model.addNode({kNone, mesh, rows, ""});
}

/// A box standing on the ground, of a size of its own.
void placeBox(Model& model, std::uint32_t unit_box, const glm::dvec3& low, const glm::dvec3& high) {
  place(model, unit_box, scaledAndMoved(high - low, low));
}

CameraSpec looking(const glm::dvec3& eye, const glm::dvec3& target) {
  LookAt look;
  look.eye = eye;
  look.target = target;
  return {look, ImageSize{}, "walk"};
}

constexpr double kRoomSide = 6.0, kRoomHeight = 3.0, kWall = 0.2, kDoorHalf = 0.6;

/// A wall from `from`, `along` one axis, with a door in its middle: three boxes.
void placeWall(Model& model, std::uint32_t box, const glm::dvec3& from, bool along_x) {
  const auto piece = [&](double begin, double end, double low) {
    const glm::dvec3 size = along_x ? glm::dvec3(end - begin, kRoomHeight - low, kWall)
                                    : glm::dvec3(kWall, kRoomHeight - low, end - begin);
    const glm::dvec3 step = along_x ? glm::dvec3(begin, low, 0.0) : glm::dvec3(0.0, low, begin);
    placeBox(model, box, from + step, from + step + size);
  };
  const double middle = 0.5 * kRoomSide;
  piece(0.0, middle - kDoorHalf, 0.0);
  piece(middle + kDoorHalf, kRoomSide, 0.0);
  piece(middle - kDoorHalf, middle + kDoorHalf, 2.1);
}

constexpr std::uint32_t kObjectsPerShell = 8;  ///< floor, ceiling, two walls of three pieces

void placeShell(Model& model, std::uint32_t box, const glm::dvec3& corner) {
  const glm::dvec3 far = corner + glm::dvec3(kRoomSide, 0.0, kRoomSide);
  placeBox(model, box, corner - glm::dvec3(0.0, kWall, 0.0), far);
  const glm::dvec3 up(0.0, kRoomHeight, 0.0);
  placeBox(model, box, corner + up, far + up + glm::dvec3(0.0, kWall, 0.0));
  placeWall(model, box, corner, true);
  placeWall(model, box, corner, false);
}

}  // namespace

Landscape arena(const LandscapeOptions& options) {
  Landscape out;
  Random random(options.seed);
  out.model.addMaterial({});
  const std::uint32_t cube = meshOf(out.model, "thing", box({-0.5F, 0, -0.5F}, {0.5F, 1, 0.5F}));
  const std::uint32_t tile = meshOf(out.model, "field", quad({0, 0, 0}, {0, 0, 20}, {20, 0, 0}));
  for (int x = -4; x < 4; ++x) {
    for (int z = -4; z < 4; ++z) place(out.model, tile, movedBy({20.0 * x, 0.0, 20.0 * z}));
  }
  while (out.model.objectCount() < options.objects) {
    const double angle = random.uniform(0.0, kTurn), radius = 78.0 * std::sqrt(random.unit());
    const double width = random.uniform(0.1, 0.3), height = random.uniform(0.1, 0.3);
    place(out.model, cube,
          composed(turnedAndMoved(random.uniform(0.0, kTurn),
                                  {radius * std::cos(angle), 0.0, radius * std::sin(angle)}),
                   scaledAndMoved({width, height, width}, {0, 0, 0})));
  }
  for (std::uint32_t i = 0; i < options.frames; ++i) {
    const double turn = kTurn * i / options.frames;
    const glm::dvec3 eye(85.0 * std::cos(turn), 12.0, 85.0 * std::sin(turn));
    out.cameras.push_back(looking(eye, {20.0 * std::sin(3.0 * turn), 0.0, 0.0}));
  }
  return out;
}

Landscape sparseTerrain(const LandscapeOptions& options) {
  constexpr double kSide = 800.0;
  constexpr int kTiles = 16;
  Landscape out;
  Random random(options.seed);
  out.model.addMaterial({});
  const std::uint32_t ground = meshOf(out.model, "ground", bumpySheet(12, 0.004, random));
  const std::uint32_t stone = meshOf(out.model, "stone", ball(3, 0.2, random));
  for (int x = 0; x < kTiles; ++x) {
    for (int z = 0; z < kTiles; ++z) {
      const double side = kSide / kTiles;
      place(out.model, ground, scaledAndMoved({side, side, side}, {side * x, 0.0, side * z}));
    }
  }
  while (out.model.objectCount() < options.objects) {
    const double size = random.uniform(0.1, 0.4);
    const glm::dvec3 at{random.uniform(0.0, kSide), 0.1, random.uniform(0.0, kSide)};
    place(out.model, stone, scaledAndMoved({size, size, size}, at));
  }
  for (std::uint32_t i = 0; i < options.frames; ++i) {
    const double way = static_cast<double>(i) / options.frames;
    const glm::dvec3 eye(100.0 + 600.0 * way, 4.0, 400.0 + 200.0 * std::sin(kTurn * way));
    const double heading = 1.5 * std::sin(2.0 * kTurn * way);
    out.cameras.push_back(
        looking(eye, eye + glm::dvec3(50.0 * std::cos(heading), -1.0, 50.0 * std::sin(heading))));
  }
  return out;
}

Landscape closedRooms(const LandscapeOptions& options) {
  Landscape out;
  Random random(options.seed);
  out.model.addMaterial({});
  const std::uint32_t cube = meshOf(out.model, "box", box({0, 0, 0}, {1, 1, 1}));
  const double rooms = options.objects / (3.0 * kObjectsPerShell);
  const int side = std::max(2, static_cast<int>(std::sqrt(rooms)));
  for (int x = 0; x < side; ++x) {
    for (int z = 0; z < side; ++z) {
      placeShell(out.model, cube, {kRoomSide * x, 0.0, kRoomSide * z});
    }
  }
  const double width = kRoomSide * side;
  placeBox(out.model, cube, {width, 0, 0}, {width + kWall, kRoomHeight, width});
  placeBox(out.model, cube, {0, 0, width}, {width, kRoomHeight, width + kWall});
  while (out.model.objectCount() < options.objects) {
    const double size = random.uniform(0.2, 0.9), height = random.uniform(0.3, 1.2);
    // In a quarter of a room, so that the way through the doors stays free.
    const auto within = [&](std::uint32_t room) {
      return kRoomSide * room + random.uniform(0.3, 0.5 * kRoomSide - kDoorHalf - 1.0);
    };
    const glm::dvec3 low{within(random.below(static_cast<std::uint32_t>(side))), 0.0,
                         within(random.below(static_cast<std::uint32_t>(side)))};
    placeBox(out.model, cube, low, low + glm::dvec3(size, height, size));
  }
  for (std::uint32_t i = 0; i < options.frames; ++i) {
    const double way = static_cast<double>(i) / options.frames;
    const double row = kRoomSide * (std::floor(way * side) + 0.5);
    const double along =
        kRoomSide * 0.5 + (width - kRoomSide) * (way * side - std::floor(way * side));
    const double heading = 0.9 * std::sin(11.0 * way);
    const glm::dvec3 eye(along, 1.7, row);
    out.cameras.push_back(
        looking(eye, eye + glm::dvec3(std::cos(heading), -0.05, std::sin(heading))));
  }
  return out;
}

}  // namespace culld::scenes
