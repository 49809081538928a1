#include "tests/scenes/shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

namespace culld::scenes {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

std::uint32_t countOf(const Triangles& t) { return static_cast<std::uint32_t>(t.positions.size()); }

void addQuad(Triangles& to, std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
  for (const std::uint32_t i : {a, b, c, a, c, d}) to.indices.push_back(i);
}

glm::vec3 narrowed(double x, double y, double z) { return glm::vec3(glm::dvec3(x, y, z)); }

}  // namespace

void append(Triangles& to, const Triangles& more, const Rows& m) {
  const std::uint32_t first = countOf(to);
  for (const glm::vec3& given : more.positions) {
    const glm::dvec3 p(given);
    to.positions.push_back(narrowed(m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3],
                                    m[4] * p.x + m[5] * p.y + m[6] * p.z + m[7],
                                    m[8] * p.x + m[9] * p.y + m[10] * p.z + m[11]));
  }
  for (const std::uint32_t i : more.indices) to.indices.push_back(first + i);
}

Triangles quad(const glm::vec3& corner, const glm::vec3& u, const glm::vec3& v) {
  return {{corner, corner + u, corner + u + v, corner + v}, {0, 1, 2, 0, 2, 3}};
}

Triangles box(const glm::vec3& min, const glm::vec3& max) {
  const std::array<glm::vec2, 4> footprint{glm::vec2(min.x, min.z), glm::vec2(min.x, max.z),
                                           glm::vec2(max.x, max.z), glm::vec2(max.x, min.z)};
  return prism(footprint, min.y, max.y);
}

Triangles prism(std::span<const glm::vec2> footprint, float y_low, float y_high, std::size_t hub) {
  const auto n = static_cast<std::uint32_t>(footprint.size());
  Triangles shape;
  for (const float y : {y_low, y_high}) {
    for (const glm::vec2& p : footprint) shape.positions.emplace_back(p.x, y, p.y);
  }
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t next = (i + 1) % n;
    addQuad(shape, i, next, n + next, n + i);
  }
  const auto h = static_cast<std::uint32_t>(hub);
  for (std::uint32_t i = 1; i + 1 < n; ++i) {
    const std::uint32_t b = (h + i) % n, c = (h + i + 1) % n;
    for (const std::uint32_t k : {h, c, b, n + h, n + b, n + c}) shape.indices.push_back(k);
  }
  return shape;
}

std::vector<glm::vec2> regularFootprint(std::uint32_t sides, float radius) {
  std::vector<glm::vec2> corners;
  for (std::uint32_t i = 0; i < sides; ++i) {
    const double angle = kTurn * i / sides;
    corners.emplace_back(glm::dvec2(radius * std::cos(angle), -radius * std::sin(angle)));
  }
  return corners;
}

Triangles ball(std::uint32_t rings, double roughness, Random& random) {
  Triangles shape;
  const std::uint32_t around = 2 * rings;
  shape.positions.emplace_back(0.0F, 1.0F, 0.0F);
  for (std::uint32_t i = 1; i < rings; ++i) {
    const double theta = std::numbers::pi * i / rings;
    for (std::uint32_t j = 0; j < around; ++j) {
      const double phi = kTurn * j / around, r = 1.0 + random.uniform(-roughness, roughness);
      shape.positions.push_back(narrowed(r * std::sin(theta) * std::cos(phi), r * std::cos(theta),
                                         r * std::sin(theta) * std::sin(phi)));
    }
  }
  const std::uint32_t south = countOf(shape);
  shape.positions.emplace_back(0.0F, -1.0F, 0.0F);
  const auto at = [&](std::uint32_t i, std::uint32_t j) {
    return 1 + (i - 1) * around + j % around;
  };
  for (std::uint32_t j = 0; j < around; ++j) {
    for (const std::uint32_t k : {0U, at(1, j + 1), at(1, j)}) shape.indices.push_back(k);
    for (std::uint32_t i = 1; i + 1 < rings; ++i) {
      addQuad(shape, at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j));
    }
    for (const std::uint32_t k : {south, at(rings - 1, j), at(rings - 1, j + 1)}) {
      shape.indices.push_back(k);
    }
  }
  return shape;
}

Triangles torus(std::uint32_t around, std::uint32_t across, float radius, float thickness) {
  Triangles shape;
  for (std::uint32_t i = 0; i < around; ++i) {
    const double a = kTurn * i / around;
    for (std::uint32_t j = 0; j < across; ++j) {
      const double b = kTurn * j / across, r = radius + thickness * std::cos(b);
      shape.positions.push_back(
          narrowed(r * std::cos(a), thickness * std::sin(b), r * std::sin(a)));
    }
  }
  const auto at = [&](std::uint32_t i, std::uint32_t j) {
    return (i % around) * across + j % across;
  };
  for (std::uint32_t i = 0; i < around; ++i) {
    for (std::uint32_t j = 0; j < across; ++j) {
      addQuad(shape, at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j));
    }
  }
  return shape;
}

Triangles bumpySheet(std::uint32_t side, double roughness, Random& random) {
  Triangles sheet;
  for (std::uint32_t z = 0; z <= side; ++z) {
    for (std::uint32_t x = 0; x <= side; ++x) {
      const bool rim = x == 0 || z == 0 || x == side || z == side;
      const double height = random.uniform(0.0, roughness);
      sheet.positions.push_back(narrowed(static_cast<double>(x) / side, rim ? 0.0 : height,
                                         static_cast<double>(z) / side));
    }
  }
  for (std::uint32_t z = 0; z < side; ++z) {
    for (std::uint32_t x = 0; x < side; ++x) {
      const std::uint32_t a = z * (side + 1) + x, below = a + side + 1;
      addQuad(sheet, a, below, below + 1, a + 1);
    }
  }
  return sheet;
}

Triangles wallWithHole(const glm::vec2& centre, const glm::vec2& hole) {
  Triangles wall;
  const std::array<glm::vec2, 4> corners{glm::vec2(-1, -1), glm::vec2(1, -1), glm::vec2(1, 1),
                                         glm::vec2(-1, 1)};
  for (const glm::vec2& c : corners) wall.positions.emplace_back(c, 0.0F);
  for (const glm::vec2& c : corners) wall.positions.emplace_back(centre + c * hole, 0.0F);
  for (std::uint32_t k = 0; k < 4; ++k) addQuad(wall, k, (k + 1) % 4, 4 + (k + 1) % 4, 4 + k);
  return wall;
}

}  // namespace culld::scenes
