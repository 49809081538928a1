// Runs a test body once on every SIMD target of this machine, best first, and names the target.
#pragma once
#include <gtest/gtest.h>

#include <string>

#include "culling/core/simd.h"

namespace culld {

template <typename Body>
void onEveryTarget(Body&& body) {
  for (const std::string& target : simdTargets()) {
    SCOPED_TRACE(target);
    ASSERT_TRUE(forceSimdTarget(target).ok());
    body();
  }
  ASSERT_TRUE(forceSimdTarget("auto").ok());
}

}  // namespace culld
