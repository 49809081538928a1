// The shaders of depth_pass.cpp. `precise` keeps sums and products apart, as proofs count their
// roundings one by one (docs/error-model/gpu.md); self_test.h checks that it does.
#pragma once

namespace culld::gpu {

// An outline's rectangle of cells. Which fragments come is up to the rasterizer: one that is
// missing hides less.
inline constexpr const char* kOutlineVertexShader = R"(#version 450 core
struct Head { uint x0, y0, x1, y1, first, sides, planes; float floor_nearness; };
layout(std430, binding = 0) readonly buffer Heads { Head heads[]; };
layout(location = 0) uniform vec2 grid;
flat out uint outline;
void main() {
  Head head = heads[gl_InstanceID];
  bool right = gl_VertexID == 1 || gl_VertexID == 2 || gl_VertexID == 4;
  bool top = gl_VertexID == 2 || gl_VertexID >= 4;
  vec2 corner = vec2(right ? head.x1 : head.x0, top ? head.y1 : head.y0);
  outline = uint(gl_InstanceID);
  gl_Position = vec4(2.0 * corner / grid - 1.0, 0.0, 1.0);
}
)";

inline constexpr const char* kOutlineFragmentShader = R"(#version 450 core
struct Head { uint x0, y0, x1, y1, first, sides, planes; float floor_nearness; };
layout(std430, binding = 0) readonly buffer Heads { Head heads[]; };
layout(std430, binding = 1) readonly buffer Lines { vec4 lines[]; };
layout(std430, binding = 2) coherent buffer Cells { uint cells[]; };
layout(location = 1) uniform uint stride;
flat in uint outline;
void main() {
  Head head = heads[outline];
  uvec2 cell = uvec2(gl_FragCoord.xy);
  // What the sides say holds in the rectangle only.
  if (cell.x < head.x0 || cell.x >= head.x1 || cell.y < head.y0 || cell.y >= head.y1) return;
  float i = float(cell.x), j = float(cell.y);
  for (uint s = 0u; s < head.sides; ++s) {
    vec4 side = lines[head.first + s];
    precise float rest = side.z + side.y * j;
    precise float value = side.x * i + rest;
    if (!(value > side.w)) return;  // strictly: zeros, read where there is no line, cover nothing
  }
  float nearness = head.floor_nearness;
  if (head.planes > 0u) {
    float least = 3.0e38;
    for (uint p = 0u; p < head.planes; ++p) {
      vec4 plane = lines[head.first + head.sides + p];
      precise float rest = plane.z + plane.y * j;
      precise float value = plane.x * i + rest;
      if (!(value >= least)) least = value;
    }
    if (least > nearness) nearness = least;
  }
  if (!(nearness >= uintBitsToFloat(0x00800000u))) return;  // denormals may count as 0
  uint bits = floatBitsToUint(nearness);  // positive floats are ordered as their bits
  uint at = cell.y * stride + cell.x;
  if (cells[at] < bits) atomicMax(cells[at], bits);
}
)";

// One level from the one below it. Cells past the grid do not count: no box is asked there.
inline constexpr const char* kReduceShader = R"(#version 450 core
layout(local_size_x = 8, local_size_y = 8) in;
layout(std430, binding = 2) buffer Cells { uint cells[]; };
layout(location = 0) uniform uvec4 below;  // first word, width, cells counted in x, in y
layout(location = 1) uniform uvec4 level;  // first word, width, height
void main() {
  uvec2 texel = gl_GlobalInvocationID.xy;
  if (texel.x >= level.y || texel.y >= level.z) return;
  uint least = 0xFFFFFFFFu;
  for (uint dy = 0u; dy < 2u; ++dy) {
    for (uint dx = 0u; dx < 2u; ++dx) {
      uvec2 from = 2u * texel + uvec2(dx, dy);
      if (from.x < below.z && from.y < below.w)
        least = min(least, cells[below.x + from.y * below.y + from.x]);
    }
  }
  cells[level.x + texel.y * level.y + texel.x] = least;
}
)";

// The rectangle of a box as in culling/raster/box_reference.cpp, then the pyramid. One invocation
// makes one word of 32 verdicts: four groups of eight boxes.
inline constexpr const char* kTestShader = R"(#version 450 core
layout(local_size_x = 64) in;
struct Query { uint group, lanes; float x, y, z; uint unused; };
layout(std430, binding = 0) readonly buffer Groups { float offsets[]; };
layout(std430, binding = 1) readonly buffer Queries { Query queries[]; };
layout(std430, binding = 2) readonly buffer Cells { uint cells[]; };
layout(std430, binding = 3) writeonly buffer Hidden { uint hidden[]; };
layout(location = 0) uniform uvec4 counts;    // queries, refine, levels, perspective
layout(location = 1) uniform vec4 sizes;      // width, height, beside
layout(location = 2) uniform vec4 rows[4];    // u, v, w, n
layout(location = 6) uniform uvec4 level[13]; // first word, width

// By their bits, as box_reference.cpp has them.
const float kRelative = uintBitsToFloat(0x35800000u);   // 2^-20
const float kAbsolute = uintBitsToFloat(0x03AA2425u);   // 1e-36
const float kSubnormal = uintBitsToFloat(0x00800000u);  // 2^-126
const float kPad = uintBitsToFloat(0x3A800000u);        // 2^-10
const float kLargest = 1.0e9;   // cells; with kLeastW and what callers promise nothing overflows
const float kLeastW = 1.0e-12;
const float kSlack = uintBitsToFloat(0x3F8147AEu);      // 1.01

struct Row { float corner[8]; float error; };

Row evaluate(vec4 row, vec3 low, vec3 high, vec3 reach) {
  Row result;
  precise float x0 = row.x * low.x, x1 = row.x * high.x;
  precise float y0 = row.y * low.y, y1 = row.y * high.y;
  precise float z0 = row.z * low.z + row.w, z1 = row.z * high.z + row.w;
  for (int c = 0; c < 8; ++c) {
    precise float flat_part = ((c & 1) != 0 ? x1 : x0) + ((c & 2) != 0 ? y1 : y0);
    precise float value = flat_part + ((c & 4) != 0 ? z1 : z0);
    result.corner[c] = value;
  }
  precise float terms = (abs(row.x) * reach.x + abs(row.y) * reach.y) +
                        (abs(row.z) * reach.z + abs(row.w));
  precise float all_reach = (reach.x + reach.y) + reach.z;
  precise float error = terms * kRelative + (all_reach * kSubnormal + kAbsolute);
  result.error = error;
  return result;
}

// False: too large.
bool quotient(Row top, Row w, float w_low, out vec2 range) {
  float low = 3.4e38, high = -3.4e38;
  for (int c = 0; c < 8; ++c) {
    float value = top.corner[c] / w.corner[c];
    low = value < low ? value : low;
    high = value > high ? value : high;
  }
  float largest = max(abs(low), abs(high));
  range = vec2(0.0);
  if (!(largest <= kLargest)) return false;
  precise float error =
      ((top.error + largest * w.error) / w_low) * kSlack + (largest * kRelative + kPad);
  precise vec2 widened = vec2(low - error, high + error);
  range = widened;
  return true;
}

uint cellOf(float x, float side) { return uint(min(max(x, 0.0), side - 1.0)); }

// Every texel of one level that the rectangle is on is nearer.
bool hides(uint k, uvec4 rect, float nearest) {
  uint x0 = rect.x >> k, x1 = rect.y >> k, y0 = rect.z >> k, y1 = rect.w >> k;
  for (uint y = y0; y <= y1; ++y) {
    for (uint x = x0; x <= x1; ++x) {
      if (!(uintBitsToFloat(cells[level[k].x + y * level[k].y + x]) > nearest)) return false;
    }
  }
  return true;
}

bool isHidden(Query query, uint lane) {
  uint at = query.group * 48u + lane;
  vec3 first = vec3(offsets[at], offsets[at + 8u], offsets[at + 16u]);
  vec3 last = vec3(offsets[at + 24u], offsets[at + 32u], offsets[at + 40u]);
  vec3 origin = vec3(query.x, query.y, query.z);
  precise vec3 low = origin + first;
  precise vec3 high = origin + last;
  precise vec3 reach = abs(origin) + (abs(first) + abs(last));
  Row w = evaluate(rows[2], low, high, reach);
  float w_min = w.corner[0];
  for (int c = 1; c < 8; ++c) w_min = w.corner[c] < w_min ? w.corner[c] : w_min;
  precise float w_low = w_min - w.error;
  if (!(w_low > kLeastW)) return false;
  Row u = evaluate(rows[0], low, high, reach);
  Row v = evaluate(rows[1], low, high, reach);
  Row n = evaluate(rows[3], low, high, reach);
  float n_max = n.corner[0];
  for (int c = 1; c < 8; ++c) n_max = n.corner[c] > n_max ? n.corner[c] : n_max;
  vec2 x, y;
  if (!quotient(u, w, w_low, x) || !quotient(v, w, w_low, y)) return false;
  precise float by_w = (1.0 / w_low) * (1.0 + kRelative);
  precise float by_n = n_max + n.error;
  float nearest = counts.w != 0u ? by_w : by_n;
  bool sticks_out = x.x < 0.0 || x.y > sizes.x || y.x < 0.0 || y.y > sizes.y;
  if (sticks_out && nearest > sizes.z) return false;
  uvec4 rect = uvec4(cellOf(x.x, sizes.x), cellOf(x.y, sizes.x), cellOf(y.x, sizes.y),
                     cellOf(y.y, sizes.y));
  uint k = 0u;
  while (k + 1u < counts.z && ((rect.y >> k) - (rect.x >> k) > 1u ||
                               (rect.w >> k) - (rect.z >> k) > 1u)) ++k;
  for (uint finer = 0u; finer <= min(counts.y, k); ++finer) {
    if (hides(k - finer, rect, nearest)) return true;
  }
  return false;
}

void main() {
  uint word = gl_GlobalInvocationID.x;
  uint first = word * 4u;
  if (first >= counts.x) return;
  uint verdicts = 0u;
  for (uint q = 0u; q < 4u && first + q < counts.x; ++q) {
    Query query = queries[first + q];
    for (uint lane = 0u; lane < 8u; ++lane) {
      if ((query.lanes >> lane & 1u) != 0u && isHidden(query, lane)) {
        verdicts |= 1u << (8u * q + lane);
      }
    }
  }
  hidden[word] = verdicts;
}
)";

}  // namespace culld::gpu
