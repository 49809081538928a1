// Strict reading of JSON: what is missing, of the wrong type or out of range is an error with its
// place, never a silent default. Hides the JSON library.
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "culling/scene/gltf_failure.h"

namespace culld::gltf {

/// Marks "there is none" in index fields.
inline constexpr std::uint32_t kNone = 0xFFFFFFFFU;

/// Deeper nesting than any file needs; deeper ones are refused before parsing.
inline constexpr std::size_t kMaxJsonDepth = 256;

/// A value inside a JsonDocument, or nothing. Valid as long as the document lives.
class JsonView {
 public:
  JsonView() = default;
  explicit JsonView(const void* value) : value_(value) {}
  explicit operator bool() const noexcept { return value_ != nullptr; }

  bool isObject() const noexcept;
  bool isArray() const noexcept;
  /// The member of an object, or nothing.
  JsonView operator[](const char* key) const;
  /// Elements of an array; 0 for anything else.
  std::size_t size() const noexcept;
  /// REQUIRES: i < size().
  JsonView at(std::size_t i) const;
  /// Members of an object as (name, value).
  std::vector<std::pair<std::string, JsonView>> members() const;

  // The readers below fail with "PLACE: KEY ..." when the member has another type or range.
  JsonView object(const Place& place, const char* key) const;
  JsonView array(const Place& place, const char* key) const;
  std::uint64_t count(const Place& place, const char* key) const;  ///< must be there
  std::uint64_t countOr(const Place& place, const char* key, std::uint64_t otherwise) const;
  bool flagOr(const Place& place, const char* key, bool otherwise) const;
  std::string text(const Place& place, const char* key) const;  ///< "" if absent
  /// An index below `size` of a list of `what` ("meshes"), or kNone if absent.
  std::uint32_t index(const Place& place, const char* key, std::size_t size,
                      const char* what) const;
  /// Fills `numbers`; false if absent. The array must have exactly that many.
  bool numbers(const Place& place, const char* key, std::span<double> numbers) const;

  // The same of the value itself; `key` is for the message.
  std::uint64_t asCount(const Place& place, const char* key) const;
  std::uint32_t asIndex(const Place& place, const char* key, std::size_t size,
                        const char* what) const;
  std::string asText(const Place& place, const char* key) const;

 private:
  const void* value_ = nullptr;
};

class JsonDocument {
 public:
  /// Throws LoadFailure: not JSON, nested deeper than kMaxJsonDepth.
  explicit JsonDocument(std::string_view text);
  ~JsonDocument();
  JsonDocument(const JsonDocument&) = delete;
  JsonDocument& operator=(const JsonDocument&) = delete;
  JsonView root() const noexcept;

 private:
  struct Parsed;
  std::unique_ptr<Parsed> parsed_;
};

}  // namespace culld::gltf
