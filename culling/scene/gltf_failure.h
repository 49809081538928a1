// How the files of the loader give up: they throw LoadFailure, and gltf_loader.cpp turns it into an
// Error. It never leaves this room.
#pragma once
#include <cstdint>
#include <exception>
#include <string>
#include <utility>

#include "culling/core/result.h"

namespace culld::gltf {

class LoadFailure : public std::exception {
 public:
  explicit LoadFailure(Error error) : error_(std::move(error)) {}
  const Error& error() const noexcept { return error_; }
  const char* what() const noexcept override { return error_.message.c_str(); }

 private:
  Error error_;
};

/// Where in the file: "mesh 3 primitive 1", or "asset" alone. Cheap to pass; the text is made only
/// when it is needed.
struct Place {
  static constexpr std::uint64_t kAlone = ~std::uint64_t{0};
  const char* kind = "";
  std::uint64_t index = kAlone;
  const char* inner_kind = nullptr;
  std::uint64_t inner_index = 0;

  std::string text() const {
    std::string line = kind;
    if (index != kAlone) line.append(" ").append(std::to_string(index));
    if (inner_kind != nullptr) {
      line.append(" ").append(inner_kind).append(" ").append(std::to_string(inner_index));
    }
    return line;
  }
};

[[noreturn]] inline void fail(ErrorCode code, std::string message) {
  throw LoadFailure({code, std::move(message)});
}
[[noreturn]] inline void fail(const Place& place, const std::string& what) {
  fail(ErrorCode::kInvalidInput, place.text() + ": " + what);
}
[[noreturn]] inline void fail(const std::string& place, const std::string& what) {
  fail(ErrorCode::kInvalidInput, place + ": " + what);
}

}  // namespace culld::gltf
