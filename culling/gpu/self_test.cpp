#include "culling/gpu/self_test.h"

#include <GL/glcorearb.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

#include "culling/gpu/program.h"

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

Error unavailable(std::string message) { return {ErrorCode::kUnavailable, std::move(message)}; }

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

Result<void> selfTest(const GlTable& gl) {
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

}  // namespace culld::gpu
