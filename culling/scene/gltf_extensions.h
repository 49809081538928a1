// Which extensions a file may require.
#pragma once
#include <string>
#include <vector>

namespace culld::gltf {

/// Throws LoadFailure (kUnsupported) naming the first one that culld cannot honour.
void checkRequiredExtensions(const std::vector<std::string>& required);

}  // namespace culld::gltf
