#include "client/sdk/refusal.h"

#include <nlohmann/json.hpp>

#include "protocol/text.h"

namespace culld::client {
namespace {

using protocol::ErrorCode;

std::string wordsOf(const std::string& body) {
  constexpr std::size_t kLongest = 1000;
  const auto json = nlohmann::json::parse(body, nullptr, false);
  if (!json.is_object()) return {};
  const auto error = json.find("error");
  if (error == json.end() || !error->is_string()) return {};
  return protocol::oneLine(error->get<std::string>().substr(0, kLongest));
}

ErrorCode codeOf(unsigned status) {
  switch (status) {
    case 400:
    case 422:
      return ErrorCode::kInvalidInput;
    case 401:
    case 403:
      return ErrorCode::kForbidden;
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
  const ErrorCode code = codeOf(status);
  if (words.empty()) {
    return {code, toString(address) + ": HTTP status " + std::to_string(status)};
  }
  // What a server refuses for its own sake is about the server, not about what was asked for.
  const bool of_server = code == ErrorCode::kUnavailable || code == ErrorCode::kForbidden;
  return {code, of_server ? toString(address) + ": " + words : words};
}

}  // namespace culld::client
