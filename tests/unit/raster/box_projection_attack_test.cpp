// Attacks docs/error-model.md §5: no point of a box may project outside its rectangle or be nearer
// than its nearness, at any scale and distance; judged in 113-bit arithmetic.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "culling/raster/box_kernels.h"

namespace culld {
namespace {

__extension__ typedef __float128 Quad;

struct Boxes {
  float offsets[6][kBoxLanes];
};

Quad rowAt(const glm::dvec4& row, const Quad* p) {
  return Quad(row.x) * p[0] + Quad(row.y) * p[1] + Quad(row.z) * p[2] + Quad(row.w);
}

class BoxProjectionAttack : public ::testing::Test {
 protected:
  double real(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }

  Camera camera() {
    if (random_() % 4 == 0) {
      glm::dmat4 projection(1.0);
      projection[0][0] = std::exp2(real(-12.0, 2.0));
      projection[1][1] = projection[0][0];
      projection[2][2] = -std::exp2(real(-14.0, 0.0));
      return cameraFromMatrices(glm::dmat4(1.0), projection, {}).value();
    }
    LookAt look;
    look.eye = {real(-1.0, 1.0), real(-1.0, 1.0), real(-1.0, 1.0)};
    look.target = look.eye + glm::dvec3(real(-1.0, 1.0), real(-0.9, 0.9), -1.0);
    look.yfov_rad = random_() % 3 == 0 ? std::exp2(real(-12.0, 1.0)) : 1.0;
    return cameraFromLookAt(look, {}).value();
  }

  Boxes boxes(double scale) {
    Boxes b;
    for (std::size_t lane = 0; lane < kBoxLanes; ++lane) {
      for (std::size_t i = 0; i < 3; ++i) {
        const auto low = static_cast<float>(scale * real(-1.0, 1.0));
        const auto size =
            static_cast<float>(scale * (random_() % 3 == 0 ? 0.0 : std::exp2(real(-20.0, 0.0))));
        b.offsets[i][lane] = low;
        b.offsets[i + 3][lane] = low + size;
      }
    }
    return b;
  }

  void checkPoint(const CellView& view, const Quad* p, const BoxRects& rects, std::size_t lane) {
    const Quad w = rowAt(view.w, p);
    if (!(w > 0)) return;
    const Quad u = rowAt(view.u, p) / w, v = rowAt(view.v, p) / w, n = rowAt(view.n, p) / w;
    const bool on_image = u >= 0 && v >= 0 && u <= view.grid.width && v <= view.grid.height;
    if (!on_image) return;
    ++on_image_;
    ASSERT_FALSE(rects.off_grid >> lane & 1U);
    ASSERT_LE(Quad(rects.x0[lane]), u);
    ASSERT_GE(Quad(rects.x1[lane]), u);
    ASSERT_LE(Quad(rects.y0[lane]), v);
    ASSERT_GE(Quad(rects.y1[lane]), v);
    if (!std::isinf(rects.nearest[lane])) {
      ASSERT_GE(Quad(rects.nearest[lane]), n);
    }
  }

  /// A pose within the bound that has `p` in its frustum: then the rectangle must tell of it.
  void checkSeenFromElsewhere(const Camera& cam, const CellView& view, const Quad* p,
                              const BoxRects& rects, std::size_t lane) {
    const glm::dvec3 way(real(-1.0, 1.0), real(-1.0, 1.0), real(-1.0, 1.0));
    const glm::dvec3 d = (cam.motion.radius_m * (1.0 - 0x1p-50)) * glm::normalize(way);
    const glm::dvec3 axis = glm::normalize(glm::dvec3(way.y, -way.x, 0.1));
    const Quad c = std::cos(cam.motion.angle_rad), s = std::sin(cam.motion.angle_rad);
    const Quad q[3] = {p[0] - d.x, p[1] - d.y, p[2] - d.z};
    const Quad along = axis.x * q[0] + axis.y * q[1] + axis.z * q[2];
    const Quad seen[3] = {
        c * q[0] + s * (axis.y * q[2] - axis.z * q[1]) + (1 - c) * along * axis.x,
        c * q[1] + s * (axis.z * q[0] - axis.x * q[2]) + (1 - c) * along * axis.y,
        c * q[2] + s * (axis.x * q[1] - axis.y * q[0]) + (1 - c) * along * axis.z};
    const Quad x = rowAt(cam.x_row, seen), y = rowAt(cam.y_row, seen), w = rowAt(cam.w_row, seen);
    if (!(w > 0) || x < -w || x > w || y < -w || y > w) return;
    ++on_image_;
    ASSERT_FALSE(rects.off_grid >> lane & 1U);
    if (std::isinf(rects.nearest[lane])) return;  // it is kept
    checkPoint(view, p, rects, lane);
    const Quad own_w = rowAt(view.w, p);
    ASSERT_GT(own_w, Quad(0));
    const Quad u = rowAt(view.u, p) / own_w, v = rowAt(view.v, p) / own_w;
    ASSERT_TRUE(u >= 0 && v >= 0 && u <= view.grid.width && v <= view.grid.height);
  }

  std::mt19937_64 random_{5};
  int on_image_ = 0;
};

TEST_F(BoxProjectionAttack, WhatAnyPoseSeesIsOnTheGridWithinTheRectangleOrKept) {
  int finite = 0;
  for (int round = 0; round < 20000 && !HasFatalFailure(); ++round) {
    Camera cam = camera();
    const double scale = std::exp2(real(-20.0, 20.0));
    cam.motion.radius_m = scale * std::exp2(real(-8.0, 1.0));
    if (cam.perspective && random_() % 2 == 0) cam.motion.angle_rad = std::exp2(real(-9.0, -1.0));
    if (!holdsInMotion(cam)) continue;
    const CellView view = cellView(cam, gridFor(cam));
    const Boxes b = boxes(scale);
    const std::array<double, 3> origin{scale * real(-4.0, 4.0), scale * real(-2.0, 2.0),
                                       -scale * real(0.0, 8.0)};
    BoxRects rects;
    projectBoxes(boxView(view), origin, b.offsets, rects);
    for (std::size_t lane = 0; lane < kBoxLanes; ++lane) {
      finite += std::isinf(rects.nearest[lane]) ? 0 : 1;
      for (int k = 0; k < 12; ++k) {
        Quad p[3];
        for (std::size_t i = 0; i < 3; ++i) {
          const Quad low = Quad(origin[i]) + Quad(b.offsets[i][lane]);
          const Quad size = Quad(b.offsets[i + 3][lane]) - Quad(b.offsets[i][lane]);
          const double where = k < 8 ? (k >> i & 1) : real(0.0, 1.0);
          p[i] = low + size * Quad(where);
        }
        checkSeenFromElsewhere(cam, view, p, rects, lane);
      }
    }
  }
  EXPECT_GT(on_image_, 50000);
  EXPECT_GT(finite, 20000);
}

TEST_F(BoxProjectionAttack, NoPointLeavesItsRectangleOrComesNearer) {
  for (int round = 0; round < 20000 && !HasFatalFailure(); ++round) {
    const Camera cam = camera();
    const CellView view = cellView(cam, gridFor(cam));
    const double scale = std::exp2(real(-40.0, 40.0));
    const Boxes b = boxes(scale);
    const std::array<double, 3> origin{scale * real(-2.0, 2.0), scale * real(-2.0, 2.0),
                                       -scale * real(0.0, 8.0)};
    BoxRects rects;
    projectBoxes(boxView(view), origin, b.offsets, rects);
    for (std::size_t lane = 0; lane < kBoxLanes; ++lane) {
      for (int k = 0; k < 12; ++k) {
        Quad p[3];
        for (std::size_t i = 0; i < 3; ++i) {
          const Quad low = Quad(origin[i]) + Quad(b.offsets[i][lane]);
          const Quad size = Quad(b.offsets[i + 3][lane]) - Quad(b.offsets[i][lane]);
          const double where = k < 8 ? (k >> i & 1) : real(0.0, 1.0);
          p[i] = low + size * Quad(where);
        }
        checkPoint(view, p, rects, lane);
      }
    }
  }
  EXPECT_GT(on_image_, 100000);
}

}  // namespace
}  // namespace culld
