// Whether a context computes what proofs rest on: sums and products of floats rounded correctly,
// one by one (GLSL 4.50 §4.7.1 with `precise`), and a small frame of depth_pass.h. Golden: the CPU
// knows all of it to the bit.
#pragma once
#include "culling/core/result.h"
#include "culling/gpu/depth_pass.h"
#include "culling/gpu/gl_table.h"

namespace culld::gpu {

/// ERROR: kUnavailable, says what came out wrong. REQUIRES: the context is current.
Result<void> testArithmetic(const GlTable& gl);
/// The same; leaves `pass` warm for its first frame.
Result<void> testDepthPass(DepthPass& pass);

}  // namespace culld::gpu
