#include "culling/scene/gltf_json.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace culld::gltf {
namespace {

using Json = nlohmann::json;

const Json& of(const void* value) { return *static_cast<const Json*>(value); }

/// Deepest nesting of brackets outside strings.
std::size_t nestingOf(std::string_view text) {
  std::size_t depth = 0;
  std::size_t deepest = 0;
  bool in_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_string) {
      if (c == '\\') ++i;
      if (c == '"') in_string = false;
    } else if (c == '"') {
      in_string = true;
    } else if (c == '[' || c == '{') {
      deepest = std::max(deepest, ++depth);
    } else if ((c == ']' || c == '}') && depth > 0) {
      --depth;
    }
  }
  return deepest;
}

/// One line, without the library's own prefix and without bytes that would break a terminal.
std::string printable(std::string_view text) {
  std::string line;
  for (const char c : text) {
    const bool plain =
        static_cast<unsigned char>(c) >= 0x20 && static_cast<unsigned char>(c) < 0x7F;
    line += plain ? c : '?';
  }
  if (line.size() > 160) line.resize(160);
  return line;
}

[[noreturn]] void wrongType(const Place& place, const char* key, const char* wanted) {
  fail(place, std::string(key) + " is not " + wanted);
}

/// The exact integer of a number such as 8 or 8e0, which glTF allows for integers.
bool wholeNumber(const Json& value, std::uint64_t& whole) {
  if (value.is_number_unsigned()) {
    whole = value.get<std::uint64_t>();
    return true;
  }
  if (!value.is_number_float()) return false;
  const double number = value.get<double>();
  if (!(number >= 0.0 && number <= 9007199254740992.0) || number != std::floor(number))
    return false;
  whole = static_cast<std::uint64_t>(number);
  return true;
}

}  // namespace

bool JsonView::isObject() const noexcept { return value_ != nullptr && of(value_).is_object(); }
bool JsonView::isArray() const noexcept { return value_ != nullptr && of(value_).is_array(); }

JsonView JsonView::operator[](const char* key) const {
  if (!isObject()) return {};
  const auto found = of(value_).find(key);
  return found == of(value_).end() ? JsonView() : JsonView(&*found);
}

std::size_t JsonView::size() const noexcept { return isArray() ? of(value_).size() : 0; }

JsonView JsonView::at(std::size_t i) const { return JsonView(&of(value_)[i]); }

std::vector<std::pair<std::string, JsonView>> JsonView::members() const {
  std::vector<std::pair<std::string, JsonView>> all;
  if (!isObject()) return all;
  for (auto it = of(value_).begin(); it != of(value_).end(); ++it) {
    all.emplace_back(it.key(), JsonView(&it.value()));
  }
  return all;
}

JsonView JsonView::object(const Place& place, const char* key) const {
  const JsonView member = (*this)[key];
  if (member && !member.isObject()) wrongType(place, key, "an object");
  return member;
}

JsonView JsonView::array(const Place& place, const char* key) const {
  const JsonView member = (*this)[key];
  if (member && !member.isArray()) wrongType(place, key, "an array");
  return member;
}

std::uint64_t JsonView::asCount(const Place& place, const char* key) const {
  std::uint64_t whole = 0;
  if (!wholeNumber(of(value_), whole)) wrongType(place, key, "a whole number from 0");
  return whole;
}

std::uint64_t JsonView::count(const Place& place, const char* key) const {
  const JsonView member = (*this)[key];
  if (!member) fail(place, std::string(key) + " is missing");
  return member.asCount(place, key);
}

std::uint64_t JsonView::countOr(const Place& place, const char* key,
                                std::uint64_t otherwise) const {
  const JsonView member = (*this)[key];
  return member ? member.asCount(place, key) : otherwise;
}

bool JsonView::flagOr(const Place& place, const char* key, bool otherwise) const {
  const JsonView member = (*this)[key];
  if (!member) return otherwise;
  if (!of(member.value_).is_boolean()) wrongType(place, key, "true or false");
  return of(member.value_).get<bool>();
}

std::string JsonView::asText(const Place& place, const char* key) const {
  if (!of(value_).is_string()) wrongType(place, key, "a string");
  return of(value_).get<std::string>();
}

std::string JsonView::text(const Place& place, const char* key) const {
  const JsonView member = (*this)[key];
  return member ? member.asText(place, key) : std::string();
}

std::uint32_t JsonView::asIndex(const Place& place, const char* key, std::size_t size,
                                const char* what) const {
  const std::uint64_t i = asCount(place, key);
  if (i >= size) {
    fail(place,
         std::string(key) + " " + std::to_string(i) + " >= " + std::to_string(size) + " " + what);
  }
  return static_cast<std::uint32_t>(i);
}

std::uint32_t JsonView::index(const Place& place, const char* key, std::size_t size,
                              const char* what) const {
  const JsonView member = (*this)[key];
  return member ? member.asIndex(place, key, size, what) : kNone;
}

bool JsonView::numbers(const Place& place, const char* key, std::span<double> numbers) const {
  const JsonView member = array(place, key);
  if (!member) return false;
  if (member.size() != numbers.size()) {
    fail(place, std::string(key) + " has " + std::to_string(member.size()) +
                    " numbers instead of " + std::to_string(numbers.size()));
  }
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const Json& value = of(member.at(i).value_);
    if (!value.is_number()) wrongType(place, key, "an array of numbers");
    numbers[i] = value.get<double>();
  }
  return true;
}

struct JsonDocument::Parsed {
  Json json;
};

JsonDocument::JsonDocument(std::string_view text) {
  if (nestingOf(text) > kMaxJsonDepth) {
    fail(ErrorCode::kLimit, "JSON: nested deeper than " + std::to_string(kMaxJsonDepth));
  }
  // The library takes a zero byte for the end of the text, and would not see what follows it.
  if (const auto zero = text.find('\0'); zero != text.npos) {
    fail("JSON", "a zero byte at byte " + std::to_string(zero));
  }
  try {
    parsed_ = std::make_unique<Parsed>(Parsed{Json::parse(text)});
  } catch (const Json::exception& e) {
    std::string_view what = e.what();
    if (const auto prefix = what.find("] "); prefix != what.npos) what.remove_prefix(prefix + 2);
    fail("JSON", printable(what));
  }
}

JsonDocument::~JsonDocument() = default;

JsonView JsonDocument::root() const noexcept { return JsonView(&parsed_->json); }

}  // namespace culld::gltf
