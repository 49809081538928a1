#include <dlfcn.h>

#include <array>

#include "culling/gpu/platform.h"
#include "culling/gpu/unavailable.h"

namespace culld::gpu {
namespace {

// Mesa's off-screen interface. Debian ships its header only with that of the old GL; these few
// lines have not changed since 2015 and will not, as Mesa 25.1 dropped OSMesa.
using OsMesaContext = struct osmesa_context*;
constexpr int kFormat = 0x22, kDepthBits = 0x30, kStencilBits = 0x31, kAccumBits = 0x32,
              kProfile = 0x33, kCoreProfile = 0x34, kMajor = 0x36, kMinor = 0x37;
constexpr int kRgba = 0x1908;
constexpr unsigned kUnsignedByte = 0x1401;

struct OsMesa {
  OsMesaContext (*CreateContextAttribs)(const int* attributes, OsMesaContext shared) = nullptr;
  void (*DestroyContext)(OsMesaContext context) = nullptr;
  unsigned char (*MakeCurrent)(OsMesaContext context, void* buffer, unsigned type, int width,
                               int height) = nullptr;
  GlProc (*GetProcAddress)(const char* name) = nullptr;
  std::string missing;
};

OsMesa openLibrary() {
  OsMesa mesa;
  void* library = nullptr;
  for (const char* name : {"libOSMesa.so.8", "libOSMesa.so.6"}) {
    library = dlopen(name, RTLD_NOW | RTLD_LOCAL);
    if (library != nullptr) break;
    const char* why = dlerror();
    if (mesa.missing.empty()) mesa.missing = why == nullptr ? "cannot be loaded" : why;
  }
  if (library == nullptr) return mesa;
  mesa.missing.clear();
  const auto find = [&](const char* name, auto& function) {
    function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(dlsym(library, name));
    if (function == nullptr) mesa.missing = std::string("libOSMesa lacks ") + name;
  };
  find("OSMesaCreateContextAttribs", mesa.CreateContextAttribs);
  find("OSMesaDestroyContext", mesa.DestroyContext);
  find("OSMesaMakeCurrent", mesa.MakeCurrent);
  find("OSMesaGetProcAddress", mesa.GetProcAddress);
  return mesa;
}

const OsMesa& library() {
  static const OsMesa mesa = openLibrary();
  return mesa;
}

GlProc findByOsMesa(const char* name) { return library().GetProcAddress(name); }

class OffscreenContext final : public NativeContext {
 public:
  explicit OffscreenContext(OsMesaContext context) : context_(context) {}
  OffscreenContext(const OffscreenContext&) = delete;
  OffscreenContext& operator=(const OffscreenContext&) = delete;
  ~OffscreenContext() override { library().DestroyContext(context_); }

  bool makeCurrent() override {
    return library().MakeCurrent(context_, pixels_.data(), kUnsignedByte, kSide, kSide) != 0;
  }
  void release() override { library().MakeCurrent(nullptr, nullptr, 0, 0, 0); }

 private:
  static constexpr int kSide = 4;
  OsMesaContext context_;
  alignas(16) std::array<unsigned char, kSide * kSide * 4> pixels_{};  ///< it insists on some
};

class OffscreenPlatform final : public Platform {
 public:
  Result<std::unique_ptr<NativeContext>> createContext() override {
    constexpr int kWanted[] = {kFormat, kRgba,      kDepthBits, 0,        kStencilBits,
                               0,       kAccumBits, 0,          kProfile, kCoreProfile,
                               kMajor,  4,          kMinor,     5,        0};
    const OsMesaContext context = library().CreateContextAttribs(kWanted, nullptr);
    if (context == nullptr) {
      return unavailable("OSMesaCreateContextAttribs failed for OpenGL 4.5 core");
    }
    return std::unique_ptr<NativeContext>(std::make_unique<OffscreenContext>(context));
  }
  GlProc (*finder() const)(const char*) override { return findByOsMesa; }
};

}  // namespace

Result<std::shared_ptr<Platform>> openOsMesa() {
  if (!library().missing.empty()) return unavailable(library().missing);
  return std::shared_ptr<Platform>(std::make_shared<OffscreenPlatform>());
}

}  // namespace culld::gpu
