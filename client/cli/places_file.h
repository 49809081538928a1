// A file of places: a JSON list of points {"at": [x, y, z]} and boxes {"min": [x, y, z], "max":
// [x, y, z]}, each with a "radius" of motion if it has one. Metres, world space.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "protocol/messages.h"
#include "protocol/result.h"

namespace culld::client {

/// ERROR: kInvalidInput: `NAME: place 3: "at" is not a list of 3 numbers`.
protocol::Result<std::vector<protocol::Place>> parsePlaces(std::string_view text,
                                                           const std::string& name);
/// ERROR: as above; a file that cannot be read or is larger than 16 MiB.
protocol::Result<std::vector<protocol::Place>> readPlacesFile(const std::string& path);

}  // namespace culld::client
