// Cameras of all kinds for tests of frusta.
#pragma once
#include <gtest/gtest.h>

#include <glm/geometric.hpp>
#include <glm/mat4x4.hpp>
#include <random>

#include "culling/core/camera.h"

namespace culld::testing {

inline double uniform(std::mt19937_64& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

inline Camera perspectiveCamera(std::mt19937_64& random, const glm::dvec3& centre, double extent) {
  const auto point = [&] {
    return centre + extent * glm::dvec3(uniform(random, -1, 1), uniform(random, -1, 1),
                                        uniform(random, -1, 1));
  };
  LookAt look;
  look.eye = point();
  look.target = point();
  look.yfov_rad = uniform(random, 2e-4, 3.12);  // 0.01 to 179 degrees
  look.aspect = std::exp(uniform(random, -3, 3));
  look.znear_m = extent * std::pow(10.0, uniform(random, -6, -1));
  if (random() % 2 == 0) look.zfar_m = extent * std::pow(10.0, uniform(random, -0.5, 9));
  return cameraFromLookAt(look, {}).value();
}

/// Off-centre, and mirrored, reversed or orthographic now and then.
inline Camera matrixCamera(std::mt19937_64& random, const glm::dvec3& centre, double extent) {
  const Camera pose = perspectiveCamera(random, centre, extent);
  const glm::dvec3 w = glm::normalize(glm::dvec3(pose.w_row));
  const glm::dvec3 x = glm::normalize(glm::dvec3(pose.x_row)) * (random() % 3 == 0 ? -1.0 : 1.0);
  const glm::dvec3 y = glm::normalize(glm::dvec3(pose.y_row));
  const glm::dvec3 eye = pose.origin_world;
  const glm::dmat4 view =
      glm::transpose(glm::dmat4(glm::dvec4(x, -glm::dot(x, eye)), glm::dvec4(y, -glm::dot(y, eye)),
                                glm::dvec4(-w, glm::dot(w, eye)), glm::dvec4(0, 0, 0, 1)));
  const double near = extent * 1e-3, far = extent * 2.0;
  const double sx = uniform(random, 0.3, 5), sy = uniform(random, 0.3, 5);
  const double ox = uniform(random, -2, 2), oy = uniform(random, -2, 2);
  glm::dmat4 projection(0.0);
  if (random() % 3 == 0) {  // orthographic, `extent` wide or so
    projection[0][0] = sx / extent;
    projection[1][1] = sy / extent;
    projection[2][2] = -2.0 / (far - near);
    projection[3] = glm::dvec4(ox, oy, -(far + near) / (far - near), 1.0);
  } else {
    const bool reversed = random() % 2 == 0;
    const double sign = reversed ? -1.0 : 1.0;
    projection[0][0] = sx;
    projection[1][1] = sy;
    projection[2] = glm::dvec4(ox, oy, -sign * (far + near) / (far - near), -1.0);
    projection[3][2] = -sign * 2.0 * far * near / (far - near);
  }
  auto camera = cameraFromMatrices(view, projection, {});
  EXPECT_TRUE(camera.ok());
  return camera.value();
}

}  // namespace culld::testing
