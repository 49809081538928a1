#include "culling/gpu/gl_table.h"

#define GL_GLEXT_PROTOTYPES 1
#include <GL/glcorearb.h>

#include <type_traits>

namespace culld::gpu {

// The table's types are those of the platform's headers.
#define CULLD_GL_SAME(name, result, parameters) \
  static_assert(std::is_same_v<decltype(GlTable::name), decltype(&gl##name)>);
CULLD_GL_FUNCTIONS(CULLD_GL_SAME)
#undef CULLD_GL_SAME

std::string fillTable(GlProc (*find)(const char*), GlTable& table) {
#define CULLD_GL_FIND(name, result, parameters)                             \
  table.name = reinterpret_cast<decltype(GlTable::name)>(find("gl" #name)); \
  if (table.name == nullptr) return "gl" #name;
  CULLD_GL_FUNCTIONS(CULLD_GL_FIND)
#undef CULLD_GL_FIND
  return {};
}

std::string takeGlError(const GlTable& gl) {
  constexpr int kMost = 16;  // a lost context may answer for ever
  std::string first;
  for (int i = 0; i < kMost; ++i) {
    const unsigned error = gl.GetError();
    if (error == GL_NO_ERROR) break;
    if (!first.empty()) continue;
    switch (error) {
      case GL_OUT_OF_MEMORY:
        first = "GL_OUT_OF_MEMORY";
        break;
      case GL_CONTEXT_LOST:
        first = "GL_CONTEXT_LOST";
        break;
      case GL_INVALID_OPERATION:
        first = "GL_INVALID_OPERATION";
        break;
      case GL_INVALID_VALUE:
        first = "GL_INVALID_VALUE";
        break;
      default:
        first = "GL error " + std::to_string(error);
    }
  }
  return first;
}

}  // namespace culld::gpu
