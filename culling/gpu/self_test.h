// Whether a context computes what proofs rest on: sums and products of floats rounded correctly,
// one by one (GLSL 4.50 §4.7.1 with `precise`), and exact maxima from many fragments. Golden: the
// CPU knows the answers.
#pragma once
#include "culling/core/result.h"
#include "culling/gpu/gl_table.h"

namespace culld::gpu {

/// ERROR: kUnavailable, says what came out wrong. REQUIRES: the context is current.
Result<void> selfTest(const GlTable& gl);

}  // namespace culld::gpu
