// Names for things in a scene. Dense 32-bit numbers: an answer is a list of them.
#pragma once
#include <cstdint>

namespace culld {

using ObjectId = std::uint32_t;  ///< index into a snapshot; never reused within a scene's history
using MeshId = std::uint32_t;    ///< index of a mesh of the snapshot

}  // namespace culld
