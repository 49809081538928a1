// The OpenGL 4.5 functions that culling uses, as pointers that one context's loader has filled.
// Nothing of OpenGL is linked: which library answers is decided at run time (docs/gpu.md), and
// tests put functions of their own into the table. gl_table.cpp holds every type here against
// Khronos' headers.
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>

namespace culld::gpu {

using GlProc = void (*)();

// clang-format off
#define CULLD_GL_FUNCTIONS(X) \
  X(AttachShader, void, (unsigned program, unsigned shader)) \
  X(BindBufferBase, void, (unsigned target, unsigned index, unsigned buffer)) \
  X(BindFramebuffer, void, (unsigned target, unsigned framebuffer)) \
  X(BindImageTexture, void, (unsigned unit, unsigned texture, int level, unsigned char layered, int layer, unsigned access, unsigned format)) \
  X(BindVertexArray, void, (unsigned array)) \
  X(ClearNamedBufferSubData, void, (unsigned buffer, unsigned internalformat, std::ptrdiff_t offset, std::ptrdiff_t size, unsigned format, unsigned type, const void* data)) \
  X(ClearNamedFramebufferfv, void, (unsigned framebuffer, unsigned buffer, int drawbuffer, const float* value)) \
  X(ClearNamedFramebufferuiv, void, (unsigned framebuffer, unsigned buffer, int drawbuffer, const unsigned* value)) \
  X(ClipControl, void, (unsigned origin, unsigned depth)) \
  X(CompileShader, void, (unsigned shader)) \
  X(CreateBuffers, void, (int n, unsigned* buffers)) \
  X(CreateFramebuffers, void, (int n, unsigned* framebuffers)) \
  X(CreateProgram, unsigned, ()) \
  X(CreateShader, unsigned, (unsigned type)) \
  X(CreateTextures, void, (unsigned target, int n, unsigned* textures)) \
  X(CreateVertexArrays, void, (int n, unsigned* arrays)) \
  X(DeleteBuffers, void, (int n, const unsigned* buffers)) \
  X(DeleteFramebuffers, void, (int n, const unsigned* framebuffers)) \
  X(DeleteProgram, void, (unsigned program)) \
  X(DeleteShader, void, (unsigned shader)) \
  X(DeleteTextures, void, (int n, const unsigned* textures)) \
  X(DeleteVertexArrays, void, (int n, const unsigned* arrays)) \
  X(DepthFunc, void, (unsigned func)) \
  X(DepthMask, void, (unsigned char flag)) \
  X(Disable, void, (unsigned capability)) \
  X(DispatchCompute, void, (unsigned x, unsigned y, unsigned z)) \
  X(DrawArraysInstanced, void, (unsigned mode, int first, int count, int instances)) \
  X(DrawElementsInstanced, void, (unsigned mode, int count, unsigned type, const void* indices, int instances)) \
  X(Enable, void, (unsigned capability)) \
  X(EnableVertexArrayAttrib, void, (unsigned array, unsigned index)) \
  X(FrontFace, void, (unsigned mode)) \
  X(GetError, unsigned, ()) \
  X(GetGraphicsResetStatus, unsigned, ()) \
  X(GetInteger64v, void, (unsigned pname, std::int64_t* data)) \
  X(GetNamedBufferSubData, void, (unsigned buffer, std::ptrdiff_t offset, std::ptrdiff_t size, void* data)) \
  X(GetProgramInfoLog, void, (unsigned program, int size, int* length, char* log)) \
  X(GetProgramiv, void, (unsigned program, unsigned pname, int* params)) \
  X(GetShaderInfoLog, void, (unsigned shader, int size, int* length, char* log)) \
  X(GetShaderiv, void, (unsigned shader, unsigned pname, int* params)) \
  X(GetString, const unsigned char*, (unsigned name)) \
  X(LinkProgram, void, (unsigned program)) \
  X(MemoryBarrier, void, (unsigned barriers)) \
  X(NamedBufferData, void, (unsigned buffer, std::ptrdiff_t size, const void* data, unsigned usage)) \
  X(NamedBufferSubData, void, (unsigned buffer, std::ptrdiff_t offset, std::ptrdiff_t size, const void* data)) \
  X(NamedFramebufferParameteri, void, (unsigned framebuffer, unsigned pname, int param)) \
  X(NamedFramebufferTexture, void, (unsigned framebuffer, unsigned attachment, unsigned texture, int level)) \
  X(PolygonOffset, void, (float factor, float units)) \
  X(ProgramUniform1f, void, (unsigned program, int location, float x)) \
  X(ProgramUniform1ui, void, (unsigned program, int location, unsigned x)) \
  X(ProgramUniform2f, void, (unsigned program, int location, float x, float y)) \
  X(ProgramUniform4fv, void, (unsigned program, int location, int count, const float* value)) \
  X(ProgramUniform4ui, void, (unsigned program, int location, unsigned x, unsigned y, unsigned z, unsigned w)) \
  X(ShaderSource, void, (unsigned shader, int count, const char* const* text, const int* lengths)) \
  X(TextureStorage2D, void, (unsigned texture, int levels, unsigned internalformat, int width, int height)) \
  X(UseProgram, void, (unsigned program)) \
  X(VertexArrayAttribFormat, void, (unsigned array, unsigned attribindex, int size, unsigned type, unsigned char normalized, unsigned relativeoffset)) \
  X(VertexArrayElementBuffer, void, (unsigned array, unsigned buffer)) \
  X(VertexArrayVertexBuffer, void, (unsigned array, unsigned bindingindex, unsigned buffer, std::ptrdiff_t offset, int stride)) \
  X(Viewport, void, (int x, int y, int width, int height))
// clang-format on

struct GlTable {
// NOLINTNEXTLINE(bugprone-macro-parentheses): a declarator has them where they may be
#define CULLD_GL_MEMBER(name, result, parameters) result(*name) parameters = nullptr;
  CULLD_GL_FUNCTIONS(CULLD_GL_MEMBER)
#undef CULLD_GL_MEMBER
};

/// Asks `find` for each function by its full name ("glUseProgram"). Returns the name of the first
/// that is not there, else "".
std::string fillTable(GlProc (*find)(const char*), GlTable& table);

/// "GL_OUT_OF_MEMORY" and so on; "" if the current context has none. Clears all of them.
std::string takeGlError(const GlTable& gl);

}  // namespace culld::gpu
