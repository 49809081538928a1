// What `--backend` and the key `backend` name, for every command that culls.
#pragma once
#include <string>

#include "culling/core/result.h"

namespace culld {

inline constexpr const char* kBackendHelp =
    "what draws for methods on a GPU: auto, cpu, egl-device[:n], egl-surfaceless, osmesa";

/// Opens it for this process. ERROR: kInvalidInput: no such name; kUnavailable: it does not work,
/// every attempt and why it failed. REQUIRES: no other threads yet.
Result<void> openBackendNamed(const std::string& name);

/// "egl-device:0 (name of the GPU)", "cpu".
std::string backendInUse();

}  // namespace culld
