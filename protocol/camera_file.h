// The cameras file (docs/clients.md): a JSON list of poses, read by every program that takes
// --cameras. What a pose means is the engine's business; here only its spelling is checked.
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/messages.h"
#include "protocol/result.h"

namespace culld::protocol {

inline constexpr std::size_t kMaxCameraFileBytes = std::size_t{64} << 20;
inline constexpr std::size_t kMaxFileCameras = 100'000;

/// For cameras of the file that do not give their own.
struct ImageSize {
  std::uint32_t width_px = 1280, height_px = 720;
};

/// Every number returned is finite. Fields that culld does not know are skipped.
/// ERROR: one line `NAME: camera 3: "yfov" is not a number`. COST: O(text), no recursion.
Result<std::vector<Camera>> parseCameras(std::string_view text, const std::string& name,
                                         ImageSize image = {});

/// ERROR: as above, or "NAME: cannot read: No such file or directory", or larger than allowed.
Result<std::vector<Camera>> readCameraFile(const std::string& path, ImageSize image = {});

}  // namespace culld::protocol
