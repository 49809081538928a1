// The shaders of item_pass.cpp.
#pragma once

namespace culld::gpu {

// In doubles up to the four numbers that the rasterizer gets: what is near the eye keeps its place
// however large its mesh or its world. `invariant`: both programs that have it put it there.
// Clip distances cut at the camera's own planes, and at the image's sides four times as far away:
// some rasterizers lose coverage a million images away.
inline constexpr const char* kItemVertexShader = R"(#version 450 core
struct Item { dvec4 x, y, z, w, near_cut, far_cut; uvec4 number; };
layout(std430, binding = 0) readonly buffer Items { Item items[]; };
layout(location = 0) in vec3 position;
layout(location = 0) uniform uint first;
layout(location = 1) uniform float nearer;
flat out uint number;
out gl_PerVertex { vec4 gl_Position; float gl_ClipDistance[6]; };
invariant gl_Position;
void main() {
  uint at = first + uint(gl_InstanceID);
  dvec4 p = dvec4(dvec3(position), 1.0);
  double x = dot(items[at].x, p), y = dot(items[at].y, p), w = dot(items[at].w, p);
  gl_Position = vec4(float(x), float(y), nearer * float(dot(items[at].z, p)), float(w));
  gl_ClipDistance[0] = float(dot(items[at].near_cut, p));
  gl_ClipDistance[1] = float(dot(items[at].far_cut, p));
  gl_ClipDistance[2] = float(4.0 * w + x);
  gl_ClipDistance[3] = float(4.0 * w - x);
  gl_ClipDistance[4] = float(4.0 * w + y);
  gl_ClipDistance[5] = float(4.0 * w - y);
  number = items[at].number.x;
}
)";

// The number plus one: 0 is where nothing is.
inline constexpr const char* kNearestFragmentShader = R"(#version 450 core
flat in uint number;
layout(location = 0) out uint id;
void main() { id = number + 1u; }
)";

inline constexpr const char* kAskedFragmentShader = R"(#version 450 core
layout(early_fragment_tests) in;
layout(std430, binding = 1) coherent buffer Counts { uint counts[]; };
flat in uint number;
void main() { atomicAdd(counts[number], 1u); }
)";

// Sixteen samples of a row by each invocation: neighbours mostly are of one item, and each run of
// equal ones is one addition.
inline constexpr const char* kCountShader = R"(#version 450 core
layout(local_size_x = 64) in;
layout(r32ui, binding = 0) readonly uniform uimage2D ids;
layout(std430, binding = 1) coherent buffer Counts { uint counts[]; };
layout(location = 0) uniform uvec4 size;  // width, height, invocations in a row
void main() {
  uint row = gl_GlobalInvocationID.x / size.z, from = gl_GlobalInvocationID.x % size.z * 16u;
  if (row >= size.y) return;
  uint last = 0u, run = 0u;
  for (uint x = from; x < min(from + 16u, size.x); ++x) {
    uint id = imageLoad(ids, ivec2(x, row)).x;
    if (id != last) {
      if (last != 0u) atomicAdd(counts[last - 1u], run);
      last = id;
      run = 0u;
    }
    ++run;
  }
  if (last != 0u) atomicAdd(counts[last - 1u], run);
}
)";

}  // namespace culld::gpu
