#include "culling/scene/gltf_uri.h"

#include <algorithm>
#include <cstdint>

#include "culling/scene/gltf_failure.h"

namespace culld::gltf {
namespace {

[[noreturn]] void refuse(const std::string& what) { fail(ErrorCode::kInvalidInput, what); }

/// 0..63, or -1.
int sextet(char c) noexcept {
  if (c >= 'A' && c <= 'Z') return c - 'A';
  if (c >= 'a' && c <= 'z') return c - 'a' + 26;
  if (c >= '0' && c <= '9') return c - '0' + 52;
  if (c == '+') return 62;
  return c == '/' ? 63 : -1;
}

OwnedBytes decodeBase64(std::string_view text) {
  for (int padding = 0; padding < 2 && text.ends_with('='); ++padding) text.remove_suffix(1);
  if (text.size() % 4 == 1) refuse("data URI: base64 is cut off");
  OwnedBytes bytes(text.size() * 3 / 4);
  std::size_t out = 0;
  std::uint32_t pending = 0;
  int bits = 0;
  for (const char c : text) {
    const int six = sextet(c);
    if (six < 0) refuse("data URI: not base64");
    pending = (pending << 6 | static_cast<std::uint32_t>(six)) & 0xFFFFU;
    bits += 6;
    if (bits < 8) continue;
    bits -= 8;
    bytes.data()[out++] = static_cast<std::byte>(pending >> bits & 0xFFU);
  }
  return bytes;
}

int hexDigit(char c) noexcept {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

std::string decodePercent(std::string_view text) {
  std::string decoded;
  decoded.reserve(text.size());
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      decoded += text[i];
      continue;
    }
    const int high = i + 2 < text.size() ? hexDigit(text[i + 1]) : -1;
    const int low = i + 2 < text.size() ? hexDigit(text[i + 2]) : -1;
    if (high < 0 || low < 0) refuse("URI: % without two hex digits");
    decoded += static_cast<char>(high * 16 + low);
    i += 2;
  }
  return decoded;
}

bool hasScheme(std::string_view uri) noexcept {
  const auto colon = uri.find(':');
  return colon != uri.npos && uri.substr(0, colon).find('/') == uri.npos;
}

}  // namespace

bool isDataUri(std::string_view uri) noexcept { return uri.starts_with("data:"); }

OwnedBytes decodeDataUri(std::string_view uri) {
  const auto comma = uri.find(',');
  if (comma == uri.npos) refuse("data URI without a comma");
  const std::string_view payload = uri.substr(comma + 1);
  if (uri.substr(0, comma).ends_with(";base64")) return decodeBase64(payload);
  const std::string text = decodePercent(payload);
  OwnedBytes bytes(text.size());
  std::transform(text.begin(), text.end(), bytes.data(),
                 [](char c) { return static_cast<std::byte>(c); });
  return bytes;
}

std::string relativePath(std::string_view uri) {
  if (hasScheme(uri)) refuse("URI with a scheme; only data: and relative paths are read");
  std::string path = decodePercent(uri);
  if (path.empty()) refuse("URI is empty");
  if (path.find('\0') != path.npos) refuse("URI with a NUL character");
  if (path.find('\\') != path.npos) refuse("URI with a backslash");
  if (path.front() == '/') refuse("absolute path; only paths inside the file's folder are read");
  for (std::size_t begin = 0; begin <= path.size();) {
    const std::size_t end = std::min(path.find('/', begin), path.size());
    if (path.compare(begin, end - begin, "..") == 0) {
      refuse("path with '..'; only paths inside the file's folder are read");
    }
    begin = end + 1;
  }
  return path;
}

}  // namespace culld::gltf
