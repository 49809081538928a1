// Result<T> of this room: a value, or an Error that names the input. protocol and culling do not
// know each other, so each has its own (docs/adr/0004); the server translates.
#pragma once
#include <string>
#include <type_traits>
#include <utility>
#include <variant>

namespace culld::protocol {

/// What kind of failure; programs map it to an exit code, the server to a wire code.
enum class ErrorCode : unsigned char {
  kInvalidInput,  ///< bytes, file or argument are wrong
  kUnsupported,   ///< well-formed, but not something this side does
  kNotFound,      ///< a name that is not there
  kLimit,         ///< larger than a documented limit
  kIo,            ///< the operating system refused
  kUnavailable,   ///< try again later or elsewhere
  kForbidden,     ///< not with this token, or not without one
  kCancelled,     ///< taken back before it was done
  kDeadline,      ///< not begun in time, so not done
};

struct Error {
  ErrorCode code = ErrorCode::kInvalidInput;
  std::string message;  ///< one line, names the input and what is wrong with it
};

/// The empty value of Result<void>.
struct Done {};

template <typename T>
class [[nodiscard]] Result {
  using Value = std::conditional_t<std::is_void_v<T>, Done, T>;

 public:
  Result(Value value) : state_(std::in_place_index<0>, std::move(value)) {}
  Result(Error error) : state_(std::in_place_index<1>, std::move(error)) {}

  bool ok() const noexcept { return state_.index() == 0; }
  explicit operator bool() const noexcept { return ok(); }

  /// REQUIRES: ok().
  Value& value() & { return *std::get_if<0>(&state_); }
  const Value& value() const& { return *std::get_if<0>(&state_); }
  Value&& value() && { return std::move(*std::get_if<0>(&state_)); }

  /// REQUIRES: !ok().
  Error& error() & { return *std::get_if<1>(&state_); }
  const Error& error() const& { return *std::get_if<1>(&state_); }
  Error&& error() && { return std::move(*std::get_if<1>(&state_)); }

 private:
  std::variant<Value, Error> state_;
};

inline Error invalidInput(std::string message) {
  return {ErrorCode::kInvalidInput, std::move(message)};
}

}  // namespace culld::protocol
