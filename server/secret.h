// Secrets as the server keeps them: never the words themselves, only their SHA-256.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace culld::server {

using TokenDigest = std::array<std::uint8_t, 32>;

TokenDigest sha256(std::string_view words) noexcept;
/// In a time that does not tell where they differ.
bool same(const TokenDigest& a, const TokenDigest& b) noexcept;
/// 64 hexadecimal digits, of either case.
std::optional<TokenDigest> digestFromHex(std::string_view digits) noexcept;

/// 128 bits from the system's source of randomness, as 32 hexadecimal digits. None: it has failed.
std::optional<std::string> freshSecret();

}  // namespace culld::server
