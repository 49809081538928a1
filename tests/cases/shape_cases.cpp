// Families whose shapes are pushed: slivers, cracks, holes, coordinates that are no numbers.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "tests/cases/families.h"

namespace culld::cases {
namespace {

using scenes::Triangles;

glm::vec3 narrowed(double x, double y, double z) { return glm::vec3(glm::dvec3(x, y, z)); }

Sight usualSight(CaseBuilder& builder) {
  Sight sight;
  LookAt look;
  look.yfov_rad = 2.0 * std::atan(sight.tan_half);
  builder.look(look);
  return sight;
}

/// Of the usual wall, in pixels of the usual image.
double wallUnitsPerPixel() { return 2.0 / kCaseImage.height_px / 0.6; }

/// A wall with a hole, and all kinds of things behind it.
void holed(CaseBuilder& builder, const glm::vec2& hole_half) {
  Sight sight = usualSight(builder);
  scenes::Random& random = builder.random();
  const double x = random.uniform(-0.4, 0.4);
  const glm::vec2 centre(glm::dvec2{x, random.uniform(-0.3, 0.3)});
  sight.wall = scenes::wallWithHole(centre, hole_half);
  addWall(builder, sight);
  addThings(builder, sight);
  builder.again(placed(sight, 1.5 * sight.distance_m, glm::dvec2(centre) * 0.6, 0.1));
}

template <typename Spoil>
void spoiled(CaseBuilder& builder, double share, const Spoil& spoil) {
  builder.look({});
  LookAt across;
  across.eye = {12, 5, 9};
  across.target = glm::dvec3(0.0);
  builder.look(across);
  addClutter(builder, 60, 10.0);
  for (scenes::ModelNode& node : builder.model().nodes) {
    if (!builder.random().chance(share)) continue;
    if (builder.random().chance(0.3)) {
      spoil(node.parent_from_node[builder.random().below(12)]);
    } else {
      auto& positions = builder.model().meshes[node.mesh].parts[0].triangles.positions;
      const std::uint32_t which =
          builder.random().below(static_cast<std::uint32_t>(positions.size()));
      double number = 0.0;
      spoil(number);
      positions[which][static_cast<int>(builder.random().below(3))] = static_cast<float>(number);
    }
  }
}

}  // namespace

/// Five strips across the wall, each two slivers long and as thin as asked.
Sight slivers(CaseBuilder& builder, double aspect) {
  Sight sight = usualSight(builder);
  const double thin = 2.0 / aspect;
  Triangles wall;
  double low = -1.0;
  for (int strip = 0; strip <= 5; ++strip) {
    const double next =
        strip == 5 ? 1.0 : -1.0 + (strip + 1) / 3.0 + builder.random().uniform(0, 0.1);
    const auto row = [&](double y0, double y1) {
      const auto first = static_cast<std::uint32_t>(wall.positions.size());
      for (const double y : {y0, y1}) {
        wall.positions.push_back(narrowed(-1, y, 0));
        wall.positions.push_back(narrowed(1, y, 0));
      }
      for (const std::uint32_t i : {0U, 1U, 3U, 0U, 3U, 2U}) wall.indices.push_back(first + i);
    };
    row(low, next);
    if (strip < 5) row(next, next + thin);
    low = next + (strip < 5 ? thin : 0.0);
  }
  sight.wall = wall;
  builder.made(scenes::Alpha::kOpaque, true);  // free slivers, before and behind the wall
  for (int i = 0; i < 6; ++i) {
    const double y = builder.random().uniform(-0.7, 0.7);
    Triangles sliver{{narrowed(-1, y, 0), narrowed(1, y, 0), narrowed(0, y + thin, 0)}, {0, 1, 2}};
    builder.add(sliver, placed(sight, 4.0 + 3.0 * i, {0.02 * i, 0.0}, 0.4));
  }
  builder.made(scenes::Alpha::kOpaque, false);
  return sight;
}

/// A slanted edge whose other side has one vertex more, off the edge by `offset` of its length.
Sight tJunction(CaseBuilder& builder, double offset) {
  Sight sight = usualSight(builder);
  const glm::dvec3 from(-0.31, -1, 0), to(0.23, 1, 0);
  const glm::dvec3 middle =
      from + (to - from) * builder.random().uniform(0.3, 0.7) + glm::dvec3(2.0 * offset, 0, 0);
  const auto at = [](const glm::dvec3& p) { return glm::vec3(p); };
  const glm::dvec3 left_low(-1, -1, 0), left_high(-1, 1, 0);
  const glm::dvec3 right_low(1, -1, 0), right_high(1, 1, 0);
  sight.wall.positions = {at(left_low),  at(from),       at(to),    at(left_high),
                          at(right_low), at(right_high), at(middle)};
  sight.wall.indices = {0, 1, 2, 0, 2, 3, 1, 4, 6, 4, 5, 6, 5, 2, 6};
  return sight;
}

Sight largeTriangle(CaseBuilder& builder, double size) {
  Sight sight = usualSight(builder);
  const auto v = static_cast<float>(size);
  sight.wall = {{{-v, -v, 0}, {v, -v, 0}, {0, v, 0}}, {0, 1, 2}};
  return sight;
}

/// A good wall with so many triangles more that have no area, repeat others or turn them over.
Sight degenerate(CaseBuilder& builder, double count) {
  Sight sight = usualSight(builder);
  scenes::Random& random = builder.random();
  Triangles wall;  // lies in xz with its front up; turned to face +z
  scenes::append(wall, scenes::bumpySheet(8, 0.0, random), {2, 0, 0, -1, 0, 0, -2, 1, 0, 1, 0, 0});
  const auto points = static_cast<std::uint32_t>(wall.positions.size());
  const auto good = static_cast<std::uint32_t>(wall.indices.size() / 3);
  for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(count); ++i) {
    const std::uint32_t a = random.below(points), row = a / 9 * 9, t = 3 * random.below(good);
    std::vector<std::uint32_t> more;
    switch (i % 4) {
      case 0:
        more = {a, a, random.below(points)};
        break;
      case 1:
        more = {row, row + 8, row + 4};  // on one line
        break;
      case 2:
        more = {wall.indices[t], wall.indices[t + 1], wall.indices[t + 2]};
        break;
      default:
        more = {wall.indices[t], wall.indices[t + 2], wall.indices[t + 1]};
    }
    wall.indices.insert(wall.indices.end(), more.begin(), more.end());
  }
  sight.wall = wall;
  return sight;
}

void pinhole(CaseBuilder& builder, double side_px) {
  const double half = side_px / 2.0 * wallUnitsPerPixel();
  holed(builder, glm::vec2(glm::dvec2(half, half)));
}

void needleHole(CaseBuilder& builder, double width_px) {
  const double half = width_px / 2.0 * wallUnitsPerPixel();
  holed(builder, glm::vec2(glm::dvec2(half, 0.5)));
}

void notANumber(CaseBuilder& builder, double share) {
  spoiled(builder, share,
          [](double& number) { number = std::numeric_limits<double>::quiet_NaN(); });
}

/// Infinite, or overflowing on the way: the largest float in a node that is scaled up 1e300 times.
void infinite(CaseBuilder& builder, double share) {
  spoiled(builder, share, [&](double& number) {
    const double infinity = std::numeric_limits<double>::infinity();
    number = builder.random().chance(0.5) ? infinity : -infinity;
  });
  const auto huge = std::numeric_limits<float>::max();
  for (int i = 0; i < 5; ++i) {
    if (!builder.random().chance(share)) continue;
    builder.add(scenes::box(glm::vec3(-huge), glm::vec3(huge)),
                scenes::scaledAndMoved(glm::dvec3(1e300), glm::dvec3(0.0)));
  }
}

void nestedBoxes(CaseBuilder& builder, double apart) {
  builder.made(scenes::Alpha::kOpaque, builder.seed() % 2 != 0);
  builder.add(scenes::box(glm::vec3(-1), glm::vec3(1)));
  double size = 1.0;
  for (int i = 0; i < 8; ++i) {
    size *= 1.0 - apart;
    builder.again(scenes::scaledAndMoved(glm::dvec3(size), glm::dvec3(0.0)));
  }
  builder.again(scenes::scaledAndMoved(glm::dvec3(0.1), {0.2, 0.1, 0.3}));
  LookAt look;
  look.target = glm::dvec3(0.0);
  look.znear_m = 1e-3;
  for (const glm::dvec3& eye : {glm::dvec3(0, 0, 4), glm::dvec3(3, 2, 2.5), glm::dvec3(0.5, 0, 0),
                                glm::dvec3(0, 0.3, 1.0 - apart * 2.5)}) {
    look.eye = eye;
    builder.look(look);
  }
}

/// Squares before and behind a wall, so far apart as a share of the distance.
void coplanar(CaseBuilder& builder, double apart) {
  Sight sight = usualSight(builder);
  addWall(builder, sight);
  builder.add(sight.wall, placed(sight, sight.distance_m * (1.0 + apart), {0.0, 0.0}, 0.3));
  for (int i = 0; i < 10; ++i) {
    const double side = i % 5 == 0 ? -1.0 : 1.0;
    const double x = builder.random().uniform(-0.4, 0.4);
    const glm::dvec2 at{x, builder.random().uniform(-0.4, 0.4)};
    builder.again(placed(sight, sight.distance_m * (1.0 + side * apart), at, 0.1));
  }
  builder.add(scenes::box(glm::vec3(-1), glm::vec3(1)), placed(sight, 20.0, {0.1, 0.1}, 0.1));
}

void trianglesInAPixel(CaseBuilder& builder, double count) {
  const Sight sight = usualSight(builder);
  const double pixel = 2.0 / kCaseImage.height_px;  // in half images
  const auto rings = static_cast<std::uint32_t>(std::max(3.0, std::sqrt(count / 4.0)));
  const Triangles ball = scenes::ball(rings, 0.2, builder.random());
  builder.add(ball, placed(sight, 10.0, {0.1, 0.1}, 0.4 * pixel));
  builder.again(placed(sight, 30.0, {0.1, 0.1}, 0.3 * pixel));
  builder.again(placed(sight, 30.0, {0.3, 0.1}, 0.4 * pixel));
  builder.add(scenes::box(glm::vec3(-1), glm::vec3(1)),
              placed(sight, 20.0, {0.1, 0.1}, 0.1 * pixel));
  builder.again(placed(sight, 20.0, {-0.3, 0.2}, 0.1));
  LookAt close;  // all of it in the one pixel of an image
  close.eye = {0.5, 0.5, -9.8};
  close.target = {0.5, 0.5, -10.0};
  close.yfov_rad = 0.3;
  close.znear_m = 1e-3;
  builder.look(close, {1, 1}, "one pixel");
}

}  // namespace culld::cases
