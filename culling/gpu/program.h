// Shader programs and buffers that delete themselves. REQUIRES throughout: the context they belong
// to is current.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>

#include "culling/core/result.h"
#include "culling/gpu/gl_table.h"

namespace culld::gpu {

class Program {
 public:
  Program() = default;
  /// ERROR: kUnavailable with the first line of the compiler's words.
  static Result<Program> compute(const GlTable& gl, const std::string& source);
  static Result<Program> drawing(const GlTable& gl, const std::string& vertex,
                                 const std::string& fragment);
  Program(Program&& other) noexcept { *this = std::move(other); }
  Program& operator=(Program&& other) noexcept {
    std::swap(gl_, other.gl_);
    std::swap(name_, other.name_);
    return *this;
  }
  ~Program();
  unsigned name() const noexcept { return name_; }

 private:
  Program(const GlTable& gl, unsigned name) : gl_(&gl), name_(name) {}
  const GlTable* gl_ = nullptr;
  unsigned name_ = 0;
};

/// Into `program`; or into `ready` why not, if nothing failed before.
void keep(Result<Program> made, Program& program, Result<void>& ready);

/// A buffer that shaders read and write as an array.
class Buffer {
 public:
  explicit Buffer(const GlTable& gl);
  Buffer(Buffer&& other) noexcept
      : gl_(other.gl_), name_(std::exchange(other.name_, 0U)), bytes_(other.bytes_) {}
  Buffer(const Buffer&) = delete;
  Buffer& operator=(const Buffer&) = delete;
  ~Buffer();

  /// At least so large; what it held is gone if it grows.
  void reserve(std::size_t bytes);
  template <typename T>
  void upload(std::span<const T> values) {
    reserve(values.size_bytes());
    write(values.data(), values.size_bytes());
  }
  /// REQUIRES: `bytes` of it are there.
  void read(void* into, std::size_t bytes) const;
  /// Each of the first words becomes `value`. REQUIRES: they are there.
  void fill(std::size_t words, std::uint32_t value);
  void bind(unsigned place) const;
  unsigned name() const noexcept { return name_; }
  std::size_t bytes() const noexcept { return bytes_; }

 private:
  void write(const void* from, std::size_t bytes);
  const GlTable* gl_;
  unsigned name_ = 0;
  std::size_t bytes_ = 0;
};

}  // namespace culld::gpu
