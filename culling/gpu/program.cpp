#include "culling/gpu/program.h"

#include <GL/glcorearb.h>

#include <algorithm>
#include <array>

#include "culling/gpu/unavailable.h"

namespace culld::gpu {
namespace {

using Log = std::array<char, 512>;

Error failed(const char* what, const Log& log) {
  std::string message = log.data();
  message.resize(std::min(message.find('\n'), message.size()));
  return unavailable(std::string(what) + ": " + message);
}

Result<unsigned> compiled(const GlTable& gl, unsigned type, const std::string& source) {
  const unsigned shader = gl.CreateShader(type);
  const char* text = source.c_str();
  gl.ShaderSource(shader, 1, &text, nullptr);
  gl.CompileShader(shader);
  int fine = 0;
  gl.GetShaderiv(shader, GL_COMPILE_STATUS, &fine);
  if (fine != 0) return shader;
  Log log{};
  gl.GetShaderInfoLog(shader, static_cast<int>(log.size()) - 1, nullptr, log.data());
  gl.DeleteShader(shader);
  return failed("a shader does not compile", log);
}

Result<unsigned> linked(const GlTable& gl, std::span<const unsigned> shaders) {
  const unsigned program = gl.CreateProgram();
  for (const unsigned shader : shaders) gl.AttachShader(program, shader);
  gl.LinkProgram(program);
  for (const unsigned shader : shaders) gl.DeleteShader(shader);  // the program keeps them
  int fine = 0;
  gl.GetProgramiv(program, GL_LINK_STATUS, &fine);
  if (fine != 0) return program;
  Log log{};
  gl.GetProgramInfoLog(program, static_cast<int>(log.size()) - 1, nullptr, log.data());
  gl.DeleteProgram(program);
  return failed("a program does not link", log);
}

}  // namespace

Result<Program> Program::compute(const GlTable& gl, const std::string& source) {
  const auto shader = compiled(gl, GL_COMPUTE_SHADER, source);
  if (!shader) return shader.error();
  const unsigned shaders[] = {shader.value()};
  const auto name = linked(gl, shaders);
  if (!name) return name.error();
  return Program(gl, name.value());
}

Result<Program> Program::drawing(const GlTable& gl, const std::string& vertex,
                                 const std::string& fragment) {
  const auto first = compiled(gl, GL_VERTEX_SHADER, vertex);
  if (!first) return first.error();
  const auto second = compiled(gl, GL_FRAGMENT_SHADER, fragment);
  if (!second) {
    gl.DeleteShader(first.value());
    return second.error();
  }
  const unsigned shaders[] = {first.value(), second.value()};
  const auto name = linked(gl, shaders);
  if (!name) return name.error();
  return Program(gl, name.value());
}

Program::~Program() {
  if (name_ != 0) gl_->DeleteProgram(name_);
}

void keep(Result<Program> made, Program& program, Result<void>& ready) {
  if (made) {
    program = std::move(made).value();
  } else if (ready) {
    ready = made.error();
  }
}

Buffer::Buffer(const GlTable& gl) : gl_(&gl) { gl.CreateBuffers(1, &name_); }

Buffer::~Buffer() {
  if (name_ != 0) gl_->DeleteBuffers(1, &name_);
}

void Buffer::reserve(std::size_t bytes) {
  if (bytes <= bytes_) return;
  bytes_ = bytes;
  gl_->NamedBufferData(name_, static_cast<std::ptrdiff_t>(bytes), nullptr, GL_DYNAMIC_DRAW);
}

void Buffer::write(const void* from, std::size_t bytes) {
  if (bytes != 0) gl_->NamedBufferSubData(name_, 0, static_cast<std::ptrdiff_t>(bytes), from);
}

void Buffer::read(void* into, std::size_t bytes) const {
  if (bytes != 0) gl_->GetNamedBufferSubData(name_, 0, static_cast<std::ptrdiff_t>(bytes), into);
}

void Buffer::fill(std::size_t words, std::uint32_t value) {
  gl_->ClearNamedBufferSubData(name_, GL_R32UI, 0, static_cast<std::ptrdiff_t>(words * 4),
                               GL_RED_INTEGER, GL_UNSIGNED_INT, &value);
}

void Buffer::bind(unsigned place) const {
  gl_->BindBufferBase(GL_SHADER_STORAGE_BUFFER, place, name_);
}

}  // namespace culld::gpu
