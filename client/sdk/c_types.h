// The structs of culld/client.h as the SDK's types, and back.
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstring>
#include <type_traits>
#include <vector>

#include "culld/client.h"
#include "culld/connection.h"

namespace culld::client {

culld_code codeOf(ErrorCode code);

/// As much of a struct as both sides know. REQUIRES: its first member is its size.
template <typename T>
T taken(const T* given, const T& defaults) {
  static_assert(std::is_trivially_copyable_v<T> && offsetof(T, size) == 0);
  T known = defaults;
  if (given == nullptr) return known;
  std::memcpy(&known, given, std::min(given->size, sizeof(T)));
  return known;
}

/// As much of `source` as `size` bytes of `target` hold; null is given nothing.
template <typename T>
void given(T* target, std::size_t size, T source) {
  if (target == nullptr) return;
  source.size = std::min(size, sizeof(T));
  std::memcpy(target, &source, source.size);
}

culld_options defaultOptions();
ConnectOptions optionsOf(const culld_options& o);

culld_camera defaultCamera();
/// ERROR: kInvalidInput: of no kind.
Result<Camera> cameraOf(const culld_camera* asked);

culld_demand defaultDemand();
/// ERROR: kInvalidInput: no such guarantee.
Result<Demand> demandOf(const culld_demand* asked);

culld_scene_info infoOf(const SceneInfo& scene);

/// ERROR: kInvalidInput: of no kind.
Result<std::vector<EditItem>> editsOf(const culld_edit_item* items, std::size_t count);

/// ERROR: kInvalidInput: NULL where there are some.
Result<std::vector<Place>> placesOf(const culld_place* places, std::size_t count);

}  // namespace culld::client
