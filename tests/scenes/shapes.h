// Triangle shapes that the generators put together. All closed ones face outwards.
#pragma once
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "tests/scenes/model.h"
#include "tests/scenes/random.h"

namespace culld::scenes {

void append(Triangles& to, const Triangles& more, const Rows& placed = kIdentity);

/// The parallelogram corner, corner + u, corner + u + v, corner + v; its front is where u x v
/// points.
Triangles quad(const glm::vec3& corner, const glm::vec3& u, const glm::vec3& v);
Triangles box(const glm::vec3& min, const glm::vec3& max);

/// A footprint in the xz plane, extruded from y_low to y_high. The caps are fans from `hub`, a
/// corner that sees all others. REQUIRES: counter-clockwise seen from above (+y towards the eye,
/// +x right, +z down, so clockwise in a diagram with z up).
Triangles prism(std::span<const glm::vec2> footprint, float y_low, float y_high,
                std::size_t hub = 0);
std::vector<glm::vec2> regularFootprint(std::uint32_t sides, float radius);

/// A ball of `rings` x 2 `rings` squares with radius 1 +- roughness; closed, concave if rough.
Triangles ball(std::uint32_t rings, double roughness, Random& random);
/// A ring around the y axis, closed and concave.
Triangles torus(std::uint32_t around, std::uint32_t across, float radius, float thickness);
/// (side + 1)^2 points over [0,1]^2 in xz, front up, heights up to `roughness`, flat at its rim.
Triangles bumpySheet(std::uint32_t side, double roughness, Random& random);
/// The square [-1,1]^2 in xy, front to +z, with a hole of half sides `hole` around `centre`.
Triangles wallWithHole(const glm::vec2& centre, const glm::vec2& hole);

}  // namespace culld::scenes
