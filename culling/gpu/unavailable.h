// The one kind of failure that this room knows: it does not work here, or not now.
#pragma once
#include <string>
#include <utility>

#include "culling/core/result.h"

namespace culld::gpu {

inline Error unavailable(std::string message) {
  return {ErrorCode::kUnavailable, std::move(message)};
}

}  // namespace culld::gpu
