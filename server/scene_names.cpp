#include "server/scene_names.h"

#include "server/disk.h"

namespace culld::server {
namespace {

constexpr char kMark = ':';

}  // namespace

std::string ownedName(std::string_view tenant, std::string_view name) {
  std::string stored(tenant);
  if (!tenant.empty()) stored += kMark;
  return stored.append(name);
}

std::string_view publicName(std::string_view stored) noexcept {
  return stored.substr(stored.find(kMark) + 1);
}

std::string_view ownerOf(std::string_view stored) noexcept {
  const auto mark = stored.find(kMark);
  return mark == std::string_view::npos ? std::string_view() : stored.substr(0, mark);
}

bool validOwnedName(std::string_view stored) noexcept {
  const auto mark = stored.find(kMark);
  return validSceneName(publicName(stored)) &&
         (mark == std::string_view::npos || validSceneName(ownerOf(stored)));
}

}  // namespace culld::server
