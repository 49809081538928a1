#include "culling/gpu/self_test.h"

#include <GL/glcorearb.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

#include "culling/gpu/depth_reference.h"
#include "culling/gpu/program.h"
#include "culling/gpu/unavailable.h"

namespace culld::gpu {
namespace {

constexpr std::uint32_t kTerms = 4096;
constexpr std::uint32_t kGroup = 64;

// a * x + (c + b * y), the form of every line and plane, without fused multiply-add.
constexpr const char* kArithmetic = R"(#version 450 core
layout(local_size_x = 64) in;
layout(std430, binding = 0) readonly buffer In { float given[]; };
layout(std430, binding = 1) writeonly buffer Out { float sums[]; };
void main() {
  uint i = gl_GlobalInvocationID.x;
  precise float far = given[5u * i + 2u] + given[5u * i + 1u] * given[5u * i + 4u];
  precise float sum = given[5u * i] * given[5u * i + 3u] + far;
  sums[i] = sum;
}
)";

/// Diamonds before each other, with a slope each.
OutlineBatch diamonds(const CellGrid& grid) {
  OutlineBatch batch;
  for (std::uint32_t i = 0; i < 12; ++i) {
    ConvexOutline outline;
    const double x = 7.3 * i, y = 5.0 + 11.7 * (i % 4), radius = 6.0 + i;
    outline.side_count = 4;
    for (std::uint32_t s = 0; s < 4; ++s) {
      const double a = s % 2 == 0 ? 0.5 : -0.5, b = s < 2 ? 0.5 : -0.5;
      outline.sides[s] = {a, b, radius - a * x - b * y, 1e-6};
    }
    outline.plane_count = 1;
    outline.planes[0] = {1e-3, -2e-3, 0.2 + 0.01 * i, true};
    outline.depth_floor = 0.125F;
    outline.cells = {0, grid.width - 1, 0, grid.height - 1};
    batch.add(outline, grid);
  }
  return batch;
}

/// Boxes in rows, nearer and nearer.
BoxGroup boxes() {
  BoxGroup group;
  for (std::uint32_t lane = 0; lane < kBoxLanes; ++lane) {
    const auto step = static_cast<float>(lane);
    const float low[3] = {0.7F * step - 3.0F, -0.3F * step, -6.0F - step};
    for (std::uint32_t axis = 0; axis < 3; ++axis) {
      group[axis * kBoxLanes + lane] = low[axis];
      group[(axis + 3) * kBoxLanes + lane] = low[axis] + 0.375F;
    }
  }
  return group;
}

BoxView straightAhead(const CellGrid& grid) {
  BoxView view;
  view.width = static_cast<float>(grid.width);
  view.height = static_cast<float>(grid.height);
  view.u = {view.width, 0.0F, -0.5F * view.width, 0.0F};
  view.v = {0.0F, view.height, -0.5F * view.height, 0.0F};
  view.w = {0.0F, 0.0F, -1.0F, 0.0F};
  view.n = {0.0F, 0.0F, 0.0F, 1.0F};
  return view;
}

/// Numbers of every magnitude that culling meets, from a fixed sequence.
std::vector<float> givenNumbers() {
  std::vector<float> out;
  std::uint64_t state = 0x9E3779B97F4A7C15ULL;
  const auto next = [&] {
    state ^= state << 13U;
    state ^= state >> 7U;
    state ^= state << 17U;
    return state;
  };
  for (std::uint32_t i = 0; i < 5 * kTerms; ++i) {
    const std::uint64_t bits = next();
    const float mantissa = 1.0F + static_cast<float>(bits >> 41U) * 0x1p-23F;
    const int exponent = static_cast<int>(bits % 41U) - 20;
    const float value = std::ldexp(mantissa, exponent);
    out.push_back((bits >> 40U & 1U) != 0 ? -value : value);
  }
  return out;
}

}  // namespace

Result<void> testArithmetic(const GlTable& gl) {
  auto program = Program::compute(gl, kArithmetic);
  if (!program) return program.error();
  const std::vector<float> given = givenNumbers();
  std::vector<float> sums(kTerms);
  {
    Buffer in(gl), out(gl);
    in.upload<float>(given);
    out.reserve(kTerms * sizeof(float));
    in.bind(0);
    out.bind(1);
    gl.UseProgram(program.value().name());
    gl.DispatchCompute(kTerms / kGroup, 1, 1);
    gl.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    out.read(sums.data(), kTerms * sizeof(float));
  }
  if (const std::string error = takeGlError(gl); !error.empty()) return unavailable(error);
  for (std::uint32_t i = 0; i < kTerms; ++i) {
    const float* g = given.data() + 5 * i;
    const float expected = g[0] * g[3] + (g[2] + g[1] * g[4]);
    if (std::bit_cast<std::uint32_t>(expected) != std::bit_cast<std::uint32_t>(sums[i])) {
      return unavailable("its shaders do not round as IEEE 754 does");
    }
  }
  return Done{};
}

Result<void> testDepthPass(DepthPass& pass) {
  if (!pass.ready()) return pass.ready();
  const CellGrid grid = gridOf(83, 47);
  const OutlineBatch batch = diamonds(grid);
  const BoxView view = straightAhead(grid);
  const std::vector<BoxGroup> groups{boxes()};
  std::vector<GroupQuery> queries;
  for (std::uint32_t i = 0; i < 9; ++i) {
    queries.push_back({0, 0xFF, {0.25F * static_cast<float>(i), 0.5F, 0.0F}, 0});
  }
  constexpr std::uint32_t kRefine = 2;
  DepthReference reference;
  reference.begin(grid);
  reference.draw(batch);
  reference.buildPyramid();
  std::vector<std::uint32_t> expected, hidden;
  reference.test(view, groups, queries, kRefine, expected);

  pass.begin(grid);
  pass.draw(batch);
  pass.buildPyramid();
  const GroupSource source{0, groups.size(), [&](std::vector<BoxGroup>& out) { out = groups; }};
  pass.test(view, source, queries, kRefine, hidden);
  std::vector<float> pyramid;
  pass.readPyramid(pyramid);
  const auto truth = reference.pyramid();
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const bool same =
        std::bit_cast<std::uint32_t>(truth[i]) == std::bit_cast<std::uint32_t>(pyramid[i]);
    if (!same && !std::isnan(truth[i])) return unavailable("it draws other depths than the CPU");
  }
  if (hidden != expected) return unavailable("it hides other boxes than the CPU");
  return Done{};
}

}  // namespace culld::gpu
