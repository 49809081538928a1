#include "culling/core/camera.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <numbers>
#include <random>

namespace culld {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();
const double kNaN = std::numeric_limits<double>::quiet_NaN();

glm::dmat4 viewOf(const glm::dvec3& eye, const glm::dvec3& forward, const glm::dvec3& up_hint) {
  const glm::dvec3 f = glm::normalize(forward);
  const glm::dvec3 s = glm::normalize(glm::cross(f, up_hint));
  const glm::dvec3 u = glm::cross(s, f);
  return glm::transpose(glm::dmat4(glm::dvec4(s, -glm::dot(s, eye)),
                                   glm::dvec4(u, -glm::dot(u, eye)),
                                   glm::dvec4(-f, glm::dot(f, eye)), glm::dvec4(0, 0, 0, 1)));
}

/// glFrustum's matrix; far infinite, depth reversed and the axis off centre if asked for.
glm::dmat4 perspective(double yfov, double aspect, double near, double far, double off = 0.0,
                       bool reversed = false) {
  const double focal = 1.0 / std::tan(yfov / 2.0);
  const bool infinite = std::isinf(far);
  const double sign = reversed ? -1.0 : 1.0;
  glm::dmat4 m(0.0);
  m[0][0] = focal / aspect;
  m[1][1] = focal;
  m[2] = glm::dvec4(off, -off, -sign * (infinite ? 1.0 : (far + near) / (far - near)), -1.0);
  m[3][2] = -sign * (infinite ? 2.0 * near : 2.0 * far * near / (far - near));
  return m;
}

glm::dmat4 orthographic(double half_width, double half_height, double near, double far,
                        bool reversed = false) {
  const double sign = reversed ? -1.0 : 1.0;
  glm::dmat4 m(1.0);
  m[0][0] = 1.0 / half_width;
  m[1][1] = 1.0 / half_height;
  m[2][2] = -sign * 2.0 / (far - near);
  m[3][2] = -sign * (far + near) / (far - near);
  return m;
}

glm::dvec4 clip(const Camera& camera, const glm::dvec3& p_world) {
  const glm::dvec4 q(p_world - camera.origin_world, 1.0);
  return {glm::dot(camera.x_row, q), glm::dot(camera.y_row, q), glm::dot(camera.z_row, q),
          glm::dot(camera.w_row, q)};
}

double nearness(const Camera& camera, const glm::dvec3& p_world) {
  const glm::dvec4 q(p_world - camera.origin_world, 1.0);
  return glm::dot(camera.near_row, q) / glm::dot(camera.w_row, q);
}

void expectNear(const glm::dvec4& a, const glm::dvec4& b, double tolerance) {
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(a[i], b[i], tolerance) << "component " << i;
}

TEST(CameraFromLookAt, AgreesWithTheSameCameraGivenAsMatrices) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (int n = 0; n < 500; ++n) {
    LookAt look;
    look.eye = 100.0 * glm::dvec3(unit(random), unit(random), unit(random));
    look.target = look.eye + glm::dvec3(unit(random), 0.5 * unit(random), unit(random) + 1.5);
    look.yfov_rad = 0.1 + 1.4 * (unit(random) + 1.0);
    look.aspect = std::exp(unit(random));
    if (n % 2 == 0) look.zfar_m = 500.0;
    const Camera a = cameraFromLookAt(look, {}).value();
    const glm::dmat4 view = viewOf(look.eye, look.target - look.eye, look.up);
    const glm::dmat4 projection =
        perspective(look.yfov_rad, look.aspect, look.znear_m, look.zfar_m.value_or(kInf));
    const Camera b = cameraFromMatrices(view, projection, {}).value();
    EXPECT_TRUE(b.perspective);
    EXPECT_NEAR(glm::length(a.origin_world - b.origin_world), 0.0, 1e-10);
    for (int k = 0; k < 5; ++k) {
      const glm::dvec3 p = 100.0 * glm::dvec3(unit(random), unit(random), unit(random));
      expectNear(clip(a, p), clip(b, p), 1e-8);
      expectNear(clip(b, p), projection * view * glm::dvec4(p, 1.0), 1e-8);
    }
  }
}

TEST(CameraFromLookAt, PutsNearAndFarPlanesWhereAsked) {
  LookAt look;
  look.eye = {10, 0, 0};
  look.target = {20, 0, 0};
  look.znear_m = 0.5;
  look.zfar_m = 80.0;
  const Camera camera = cameraFromLookAt(look, {}).value();
  const glm::dvec4 near = clip(camera, {10.5, 0, 0}), far = clip(camera, {90, 0, 0});
  EXPECT_NEAR(near.z, -near.w, 1e-12);
  EXPECT_NEAR(far.z, far.w, 1e-12 * far.w);
  EXPECT_DOUBLE_EQ(near.w, 0.5);
}

TEST(CameraFromLookAt, HasNoFarPlaneIfNoneIsGiven) {
  const Camera camera = cameraFromLookAt({}, {}).value();
  const glm::dvec4 far_plane = camera.far_cut_row;
  EXPECT_EQ(glm::dvec3(far_plane), glm::dvec3(0.0));
  EXPECT_GT(far_plane.w, 0.0);
}

TEST(CameraFromLookAt, KeepsItsFarPlaneWhereItIsHoweverSmallNearIs) {
  for (const double ratio : {1e3, 1e9, 1e12, 1e15}) {
    LookAt look;
    look.target = {0.3, 0.4, -1.0};
    look.znear_m = 1e-3;
    look.zfar_m = 1e-3 * ratio;
    const Camera camera = cameraFromLookAt(look, {}).value();
    const glm::dvec3 ahead = glm::normalize(look.target);
    const auto depthLeft = [&](double share) {
      return glm::dot(camera.far_cut_row, glm::dvec4(ahead * (share * *look.zfar_m), 1.0));
    };
    EXPECT_GT(depthLeft(1.0 - 1e-12), 0.0) << ratio;
    EXPECT_LT(depthLeft(1.0 + 1e-12), 0.0) << ratio;
  }
}

TEST(CameraFromLookAt, LooksAtItsTargetHoweverNearOrNearlyUpItIs) {
  LookAt look;
  look.target = {0.0, 1.0, -1e-10};
  const Camera steep = cameraFromLookAt(look, {}).value();
  EXPECT_NEAR(clip(steep, look.target).x / clip(steep, look.target).w, 0.0, 1e-13);
  look.target = {0.0, 3e-170, -3e-162};
  const Camera close = cameraFromLookAt(look, {}).value();
  EXPECT_NEAR(glm::length(glm::dvec3(close.w_row)), 1.0, 1e-15);
}

TEST(CameraFromMatrices, TurnsAboutTheViewsOriginEvenWhereTheEngineDoesNot) {
  glm::dmat4 projection(1.0);  // orthographic, near 100 m in front of the view's origin, far 300 m
  projection[2][2] = -0.01;
  projection[3][2] = -2.0;
  const Camera camera = cameraFromMatrices(glm::dmat4(1.0), projection, {}, {0.5, 0.01}).value();
  EXPECT_NEAR(camera.origin_world.z, -100.0, 1e-9);
  EXPECT_GE(camera.motion.radius_m, 0.5 + 2.0 * std::sin(0.005) * 100.0);
  EXPECT_LE(camera.motion.radius_m, 0.5 + 1.0 + 1e-6);
}

TEST(CameraFromLookAt, HasTheEyeAsItsOriginAndNoConstantTerms) {
  LookAt look;
  look.eye = {6.4e6, -1.0, 2.5};
  look.target = {6.4e6, 0.0, 1.0};
  const Camera camera = cameraFromLookAt(look, {}).value();
  EXPECT_EQ(camera.origin_world, look.eye);
  EXPECT_EQ(camera.x_row.w, 0.0);
  EXPECT_EQ(camera.y_row.w, 0.0);
  EXPECT_EQ(camera.w_row.w, 0.0);
}

TEST(Camera, NearnessFallsWithDistance) {
  const Camera perspective_camera = cameraFromLookAt({}, {}).value();
  EXPECT_GT(nearness(perspective_camera, {0, 0, -1}), nearness(perspective_camera, {0, 0, -2}));
  EXPECT_GT(nearness(perspective_camera, {0, 0, -1e12}), 0.0);
  for (bool reversed : {false, true}) {
    const Camera ortho = cameraFromMatrices(viewOf({0, 0, 0}, {0, 0, -1}, {0, 1, 0}),
                                            orthographic(2, 1, 1, 9, reversed), {})
                             .value();
    EXPECT_NEAR(nearness(ortho, {0, 0, -1}), 1.0, 1e-12) << reversed;
    EXPECT_NEAR(nearness(ortho, {0, 0, -9}), 0.0, 1e-12) << reversed;
    EXPECT_NEAR(nearness(ortho, {1, 1, -5}), 0.5, 1e-12) << reversed;
  }
}

TEST(CameraFromMatrices, KnowsOrthographicCameras) {
  for (bool reversed : {false, true}) {
    const glm::dmat4 view = viewOf({5, 6, 7}, {1, 2, -3}, {0, 1, 0});
    const glm::dmat4 projection = orthographic(20, 10, 0.5, 100, reversed);
    const Camera camera = cameraFromMatrices(view, projection, {}).value();
    EXPECT_FALSE(camera.perspective);
    EXPECT_EQ(camera.w_row, glm::dvec4(0, 0, 0, 1));
    // The origin is the middle of the near plane.
    const glm::dvec3 expected = glm::dvec3(5, 6, 7) + 0.5 * glm::normalize(glm::dvec3(1, 2, -3));
    EXPECT_NEAR(glm::length(camera.origin_world - expected), 0.0, 1e-12);
    for (const glm::dvec3& p : {glm::dvec3(0, 0, 0), glm::dvec3(10, -3, 2), glm::dvec3(5, 6, 7)}) {
      expectNear(clip(camera, p), projection * view * glm::dvec4(p, 1.0), 1e-12);
    }
  }
}

TEST(CameraFromMatrices, DividesAnOrthographicCameraByItsW) {
  const glm::dmat4 view = viewOf({0, 0, 0}, {0, 0, -1}, {0, 1, 0});
  const glm::dmat4 projection = orthographic(4, 4, 1, 9);
  const Camera once = cameraFromMatrices(view, projection, {}).value();
  const Camera thrice = cameraFromMatrices(view, 3.0 * projection, {}).value();
  expectNear(clip(once, {1, 2, -3}), clip(thrice, {1, 2, -3}), 1e-12);
}

TEST(CameraFromMatrices, KnowsReversedInfiniteAndOffCentreProjections) {
  const glm::dvec3 eye(3, -2, 8);
  const glm::dmat4 view = viewOf(eye, {0.3, -0.2, 1}, {0, 1, 0});
  for (double far : {50.0, kInf}) {
    for (double off : {0.0, 0.7}) {
      for (bool reversed : {false, true}) {
        const glm::dmat4 projection = perspective(1.0, 1.5, 0.1, far, off, reversed);
        const auto camera = cameraFromMatrices(view, projection, {});
        ASSERT_TRUE(camera.ok());
        EXPECT_NEAR(glm::length(camera.value().origin_world - eye), 0.0, 1e-12);
        const glm::dvec3 p(4, -1, 20);
        expectNear(clip(camera.value(), p), projection * view * glm::dvec4(p, 1.0), 1e-10);
      }
    }
  }
}

TEST(CameraFromMatrices, TakesMirroredViews) {
  glm::dmat4 view = viewOf({1, 2, 3}, {0, 0, -1}, {0, 1, 0});
  for (int column = 0; column < 4; ++column) view[column][0] = -view[column][0];
  const auto camera = cameraFromMatrices(view, perspective(1.0, 1.0, 0.1, 10.0), {});
  ASSERT_TRUE(camera.ok());
  EXPECT_NEAR(glm::length(camera.value().origin_world - glm::dvec3(1, 2, 3)), 0.0, 1e-12);
}

TEST(CameraFromMatrices, FindsTheEyeWithin10NanometresOnTheEarth) {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  double worst = 0.0;
  for (int n = 0; n < 2000; ++n) {
    const glm::dvec3 eye =
        6.4e6 * glm::normalize(glm::dvec3(unit(random), unit(random), unit(random)));
    const glm::dmat4 view =
        viewOf(eye, glm::dvec3(unit(random), unit(random), unit(random)), {0.1, 1, 0.2});
    const Camera camera = cameraFromMatrices(view, perspective(1.0, 1.7, 0.1, kInf), {}).value();
    worst = std::max(worst, glm::length(camera.origin_world - eye));
  }
  EXPECT_LE(worst, 1e-8);
}

TEST(CameraFromMatrices, TakesNarrowAndWideFieldsOfView) {
  for (double degrees : {0.01, 179.0}) {
    const double yfov = degrees * std::numbers::pi / 180.0;
    const glm::dmat4 view = viewOf({100, 0, 0}, {0, 0, -1}, {0, 1, 0});
    const auto camera = cameraFromMatrices(view, perspective(yfov, 1.0, 1e-3, 1e12), {});
    ASSERT_TRUE(camera.ok()) << degrees;
    EXPECT_NEAR(camera.value().origin_world.x, 100.0, 1e-8);
  }
}

struct BadLook {
  const char* message;
  std::function<void(LookAt&)> spoil;
};

TEST(CameraFromLookAt, NamesWhatIsWrong) {
  const BadLook cases[] = {
      {"camera: eye is not finite", [](LookAt& l) { l.eye.y = kNaN; }},
      {"camera: target is not finite", [](LookAt& l) { l.target.z = kInf; }},
      {"camera: up is not finite", [](LookAt& l) { l.up.x = kNaN; }},
      {"camera: yfov is not within (0, pi)", [](LookAt& l) { l.yfov_rad = 0.0; }},
      {"camera: yfov is not within (0, pi)", [](LookAt& l) { l.yfov_rad = std::numbers::pi; }},
      {"camera: yfov is not within (0, pi)", [](LookAt& l) { l.yfov_rad = kNaN; }},
      {"camera: aspect is not > 0", [](LookAt& l) { l.aspect = 0.0; }},
      {"camera: aspect is not > 0", [](LookAt& l) { l.aspect = kNaN; }},
      {"camera: aspect is not > 0", [](LookAt& l) { l.aspect = kInf; }},
      {"camera: znear is not > 0", [](LookAt& l) { l.znear_m = 0.0; }},
      {"camera: znear is not > 0", [](LookAt& l) { l.znear_m = -1.0; }},
      {"camera: znear is not > 0", [](LookAt& l) { l.znear_m = kNaN; }},
      {"camera: zfar is not a finite number > znear (null means infinite)",
       [](LookAt& l) { l.zfar_m = 0.1; }},
      {"camera: zfar is not a finite number > znear (null means infinite)",
       [](LookAt& l) { l.zfar_m = kInf; }},
      {"camera: zfar is not a finite number > znear (null means infinite)",
       [](LookAt& l) { l.zfar_m = kNaN; }},
      {"camera: target equals eye", [](LookAt& l) { l.target = l.eye; }},
      {"camera: up is zero", [](LookAt& l) { l.up = glm::dvec3(0.0); }},
      {"camera: up is parallel to the direction of view",
       [](LookAt& l) {
         l.up = {0, 0, 5};
       }},
  };
  for (const BadLook& bad : cases) {
    LookAt look;
    bad.spoil(look);
    const auto camera = cameraFromLookAt(look, {});
    ASSERT_FALSE(camera.ok()) << bad.message;
    EXPECT_EQ(camera.error().code, ErrorCode::kInvalidInput);
    EXPECT_EQ(camera.error().message, bad.message);
  }
}

TEST(Camera, NamesWhatIsWrongWithImageAndMotion) {
  struct Bad {
    const char* message;
    ImageSize image;
    MotionBound motion;
  };
  const Bad cases[] = {
      {"camera: image size is zero", {0, 720}, {}},
      {"camera: image size is zero", {1280, 0}, {}},
      {"camera: image side > 65536", {65537, 1}, {}},
      {"camera: motion radius is not a finite number >= 0", {}, {-1.0, 0.0}},
      {"camera: motion radius is not a finite number >= 0", {}, {kNaN, 0.0}},
      {"camera: motion radius is not a finite number >= 0", {}, {kInf, 0.0}},
      {"camera: motion angle is not a finite number >= 0", {}, {0.0, -0.1}},
      {"camera: motion angle is not a finite number >= 0", {}, {0.0, kNaN}},
  };
  const glm::dmat4 view(1.0), projection = perspective(1.0, 1.0, 0.1, 10.0);
  for (const Bad& bad : cases) {
    for (const auto& camera : {cameraFromLookAt({}, bad.image, bad.motion),
                               cameraFromMatrices(view, projection, bad.image, bad.motion)}) {
      ASSERT_FALSE(camera.ok()) << bad.message;
      EXPECT_EQ(camera.error().message, bad.message);
    }
  }
  EXPECT_TRUE(cameraFromLookAt({}, {1, 1}).ok());
  EXPECT_TRUE(cameraFromLookAt({}, {65536, 65536}).ok());
}

TEST(CameraFromMatrices, NamesWhatIsWrong) {
  const glm::dmat4 view(1.0), fine = perspective(1.0, 1.0, 0.1, 10.0);
  const auto messageOf = [](const glm::dmat4& v, const glm::dmat4& p) {
    const auto camera = cameraFromMatrices(v, p, {});
    return camera.ok() ? std::string("fine") : camera.error().message;
  };
  EXPECT_EQ(messageOf(view, fine), "fine");
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 4; ++row) {
      for (double odd : {kNaN, kInf, -kInf}) {
        glm::dmat4 v = view, p = fine;
        v[column][row] = odd;
        p[column][row] = odd;
        EXPECT_EQ(messageOf(v, fine), "camera: view matrix is not finite");
        EXPECT_EQ(messageOf(view, p), "camera: projection matrix is not finite");
      }
    }
  }
  const std::string singular = "camera: view or projection matrix is singular";
  EXPECT_EQ(messageOf(glm::dmat4(0.0), fine), "camera: last row of the view matrix is not 0 0 0 1");
  EXPECT_EQ(messageOf(view, glm::dmat4(0.0)),
            "camera: projection matrix is singular: w is not positive");
  glm::dmat4 flat_view = view;  // everything into the plane x = 0
  flat_view[0][0] = 0.0;
  EXPECT_EQ(messageOf(flat_view, fine), singular);
  EXPECT_EQ(messageOf(flat_view, orthographic(1, 1, 1, 2)), singular);
  glm::dmat4 flat = fine;  // no height
  flat[1][1] = 0.0;
  EXPECT_EQ(messageOf(view, flat), singular);
  glm::dmat4 no_depth = fine;
  no_depth[2][2] = no_depth[3][2] = 0.0;
  EXPECT_EQ(messageOf(view, no_depth), "camera: depth row is zero");
  glm::dmat4 negative = orthographic(1, 1, 1, 2);
  negative[3][3] = -1.0;
  EXPECT_EQ(messageOf(view, negative), "camera: projection matrix is singular: w is not positive");
  glm::dmat4 huge_view = view, huge = fine;
  huge_view[0][0] = huge[0][0] = 1e200;
  EXPECT_EQ(messageOf(huge_view, huge), "camera: matrix product is not finite");
}

TEST(CameraFromMatrices, RefusesAViewMatrixThatIsNotAffine) {
  for (int column = 0; column < 4; ++column) {
    glm::dmat4 view(1.0);
    view[column][3] = column == 3 ? 2.0 : 0.5;
    for (const glm::dmat4& projection :
         {perspective(1.0, 1.0, 0.1, 10.0), orthographic(1, 1, 1, 2)}) {
      const auto camera = cameraFromMatrices(view, projection, {});
      ASSERT_FALSE(camera.ok());
      EXPECT_EQ(camera.error().message, "camera: last row of the view matrix is not 0 0 0 1");
    }
  }
}

TEST(CameraFromMatrices, ForgivesRoundingInTheLastOneOfTheView) {
  glm::dmat4 view(1.0);
  view[3][3] = 1.0 - 0x1p-53;  // as a general matrix inversion leaves it
  EXPECT_TRUE(cameraFromMatrices(view, perspective(1.0, 1.0, 0.1, 10.0), {}).ok());
}

}  // namespace
}  // namespace culld
