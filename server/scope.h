// What somebody may do, from little to all: each scope holds those before it.
#pragma once
#include <cstdint>
#include <optional>
#include <string_view>

namespace culld::server {

enum class Scope : std::uint8_t {
  kRead,   ///< look at scenes, ask with cameras
  kEdit,   ///< and edit them
  kAdmin,  ///< and upload and remove them
};

constexpr const char* nameOf(Scope scope) noexcept {
  constexpr const char* kNames[] = {"read", "edit", "admin"};
  return kNames[static_cast<std::size_t>(scope)];
}

constexpr std::optional<Scope> scopeNamed(std::string_view name) noexcept {
  for (const Scope scope : {Scope::kRead, Scope::kEdit, Scope::kAdmin}) {
    if (name == nameOf(scope)) return scope;
  }
  return std::nullopt;
}

}  // namespace culld::server
