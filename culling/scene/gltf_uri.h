// URIs of buffers: data URIs are decoded, relative paths stay inside the file's folder, all else is
// refused (RFC 3986, RFC 2397).
#pragma once
#include <string>
#include <string_view>

#include "culling/scene/gltf_bytes.h"

namespace culld::gltf {

bool isDataUri(std::string_view uri) noexcept;

/// Throws LoadFailure without a place. COST: O(length); at most as many bytes as the text has.
OwnedBytes decodeDataUri(std::string_view uri);

/// A relative path without "..", percent-decoded. Throws LoadFailure without a place.
std::string relativePath(std::string_view uri);

}  // namespace culld::gltf
