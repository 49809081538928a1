#include "client/sdk/refusal.h"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace culld::client {
namespace {

using protocol::ErrorCode;

std::string wordsOf(const std::string& body) {
  constexpr std::size_t kLongest = 1000;
  const auto json = nlohmann::json::parse(body, nullptr, false);
  if (!json.is_object()) return {};
  const auto error = json.find("error");
  if (error == json.end() || !error->is_string()) return {};
  std::string words = error->get<std::string>().substr(0, kLongest);
  std::replace_if(
      words.begin(), words.end(), [](char c) { return static_cast<unsigned char>(c) < ' '; }, ' ');
  return words;
}

ErrorCode codeOf(unsigned status) {
  switch (status) {
    case 400:
    case 422:
      return ErrorCode::kInvalidInput;
    case 404:
      return ErrorCode::kNotFound;
    case 413:
      return ErrorCode::kLimit;
    default:
      return ErrorCode::kUnavailable;
  }
}

}  // namespace

protocol::Error refusal(const Address& address, unsigned status, const std::string& body) {
  const std::string words = wordsOf(body);
  if (!words.empty()) return {codeOf(status), words};
  return {codeOf(status), toString(address) + ": HTTP status " + std::to_string(status)};
}

}  // namespace culld::client
