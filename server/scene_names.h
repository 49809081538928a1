// Tenants have names of their own for their scenes: the store keeps tenant T's NAME as "T:NAME",
// and the operator's as NAME. A colon is in neither (docs/adr/0012).
#pragma once
#include <string>
#include <string_view>

namespace culld::server {

std::string ownedName(std::string_view tenant, std::string_view name);
/// The name that its tenant knows.
std::string_view publicName(std::string_view stored) noexcept;
/// Empty: the operator.
std::string_view ownerOf(std::string_view stored) noexcept;
bool validOwnedName(std::string_view stored) noexcept;

}  // namespace culld::server
