#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <dlfcn.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <string_view>

#include "culling/gpu/platform.h"
#include "culling/gpu/unavailable.h"

namespace culld::gpu {
namespace {

// Asked for by name, as there is nothing to link.
struct Egl {
  decltype(&eglGetProcAddress) GetProcAddress = nullptr;
  decltype(&eglGetError) GetError = nullptr;
  decltype(&eglQueryString) QueryString = nullptr;
  decltype(&eglInitialize) Initialize = nullptr;
  decltype(&eglBindAPI) BindAPI = nullptr;
  decltype(&eglCreateContext) CreateContext = nullptr;
  decltype(&eglDestroyContext) DestroyContext = nullptr;
  decltype(&eglMakeCurrent) MakeCurrent = nullptr;
  PFNEGLGETPLATFORMDISPLAYEXTPROC GetPlatformDisplay = nullptr;
  PFNEGLQUERYDEVICESEXTPROC QueryDevices = nullptr;            ///< may be missing
  PFNEGLQUERYDEVICESTRINGEXTPROC QueryDeviceString = nullptr;  ///< may be missing
  std::string missing;  ///< why the others are not to be used; empty if they are
};

/// A word of a list with spaces between them: some extensions' names begin others'.
bool lists(const char* words, std::string_view wanted) {
  std::string_view rest = words == nullptr ? "" : words;
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find(' '), rest.size());
    if (rest.substr(0, end) == wanted) return true;
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return false;
}

Egl openLibrary() {
  Egl egl;
  void* library = dlopen("libEGL.so.1", RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) {
    const char* why = dlerror();
    egl.missing = why == nullptr ? "libEGL.so.1 cannot be loaded" : why;
    return egl;
  }
  const auto find = [&](const char* name, auto& function) {
    function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(dlsym(library, name));
    if (function == nullptr) egl.missing = std::string("libEGL.so.1 lacks ") + name;
  };
  find("eglGetProcAddress", egl.GetProcAddress);
  find("eglGetError", egl.GetError);
  find("eglQueryString", egl.QueryString);
  find("eglInitialize", egl.Initialize);
  find("eglBindAPI", egl.BindAPI);
  find("eglCreateContext", egl.CreateContext);
  find("eglDestroyContext", egl.DestroyContext);
  find("eglMakeCurrent", egl.MakeCurrent);
  if (!egl.missing.empty()) return egl;
  const auto extension = [&](const char* name, auto& function) {
    function =
        reinterpret_cast<std::remove_reference_t<decltype(function)>>(egl.GetProcAddress(name));
  };
  extension("eglGetPlatformDisplayEXT", egl.GetPlatformDisplay);
  extension("eglQueryDevicesEXT", egl.QueryDevices);
  extension("eglQueryDeviceStringEXT", egl.QueryDeviceString);
  const char* client = egl.QueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
  if (!lists(client, "EGL_EXT_platform_base") || egl.GetPlatformDisplay == nullptr) {
    egl.missing = "EGL_EXT_platform_base is not supported";
  }
  return egl;
}

const Egl& library() {
  static const Egl egl = openLibrary();
  return egl;
}

Error failed(const char* call) {
  std::array<char, 16> code{};
  std::snprintf(code.data(), code.size(), "0x%04X", static_cast<unsigned>(library().GetError()));
  return unavailable(std::string(call) + " failed with " + code.data());
}

GlProc findByEgl(const char* name) {
  return reinterpret_cast<GlProc>(library().GetProcAddress(name));
}

class EglContext final : public NativeContext {
 public:
  EglContext(EGLDisplay display, EGLContext context) : display_(display), context_(context) {}
  EglContext(const EglContext&) = delete;
  EglContext& operator=(const EglContext&) = delete;
  ~EglContext() override { library().DestroyContext(display_, context_); }

  bool makeCurrent() override {
    const Egl& egl = library();  // the API bound is the thread's
    return egl.BindAPI(EGL_OPENGL_API) == EGL_TRUE &&
           egl.MakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) == EGL_TRUE;
  }
  void release() override {
    library().MakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  }

 private:
  EGLDisplay display_;
  EGLContext context_;
};

/// The display is never terminated: EGL has one per device and process.
class EglPlatform final : public Platform {
 public:
  explicit EglPlatform(EGLDisplay display) : display_(display) {}

  Result<std::unique_ptr<NativeContext>> createContext() override {
    const Egl& egl = library();
    if (egl.BindAPI(EGL_OPENGL_API) != EGL_TRUE) return failed("eglBindAPI");
    constexpr EGLint kPlain[] = {EGL_CONTEXT_MAJOR_VERSION,
                                 4,
                                 EGL_CONTEXT_MINOR_VERSION,
                                 5,
                                 EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                 EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                 EGL_NONE};
    constexpr EGLint kRobust[] = {EGL_CONTEXT_MAJOR_VERSION,
                                  4,
                                  EGL_CONTEXT_MINOR_VERSION,
                                  5,
                                  EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                  EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                  EGL_CONTEXT_OPENGL_ROBUST_ACCESS,
                                  EGL_TRUE,
                                  EGL_CONTEXT_OPENGL_RESET_NOTIFICATION_STRATEGY,
                                  EGL_LOSE_CONTEXT_ON_RESET,
                                  EGL_NONE};
    EGLContext context = EGL_NO_CONTEXT;
    for (const EGLint* wanted : {kRobust, kPlain}) {
      context = egl.CreateContext(display_, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, wanted);
      if (context != EGL_NO_CONTEXT) break;
    }
    if (context == EGL_NO_CONTEXT) return failed("eglCreateContext for OpenGL 4.5 core");
    return std::unique_ptr<NativeContext>(std::make_unique<EglContext>(display_, context));
  }
  GlProc (*finder() const)(const char*) override { return findByEgl; }

 private:
  EGLDisplay display_;
};

Result<std::shared_ptr<Platform>> onDisplay(EGLDisplay display) {
  const Egl& egl = library();
  if (display == EGL_NO_DISPLAY) return failed("eglGetPlatformDisplayEXT");
  EGLint major = 0, minor = 0;
  if (egl.Initialize(display, &major, &minor) != EGL_TRUE) return failed("eglInitialize");
  const char* extensions = egl.QueryString(display, EGL_EXTENSIONS);
  for (const char* needed : {"EGL_KHR_no_config_context", "EGL_KHR_surfaceless_context"}) {
    if (!lists(extensions, needed)) {
      return unavailable(std::string(needed) + " is not supported");
    }
  }
  return std::shared_ptr<Platform>(std::make_shared<EglPlatform>(display));
}

Result<std::vector<EGLDeviceEXT>> enumerate() {
  const Egl& egl = library();
  if (!egl.missing.empty()) return unavailable(egl.missing);
  const char* client = egl.QueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
  const bool listed =
      lists(client, "EGL_EXT_device_base") || lists(client, "EGL_EXT_device_enumeration");
  if (!listed || !lists(client, "EGL_EXT_platform_device") || egl.QueryDevices == nullptr) {
    return unavailable("EGL_EXT_platform_device is not supported");
  }
  EGLint count = 0;
  if (egl.QueryDevices(0, nullptr, &count) != EGL_TRUE) return failed("eglQueryDevicesEXT");
  std::vector<EGLDeviceEXT> devices(static_cast<std::size_t>(count));
  if (egl.QueryDevices(count, devices.data(), &count) != EGL_TRUE) {
    return failed("eglQueryDevicesEXT");
  }
  devices.resize(static_cast<std::size_t>(count));
  return devices;
}

}  // namespace

Result<std::vector<EglDevice>> eglDevices() {
  const auto devices = enumerate();
  if (!devices) return devices.error();
  std::vector<EglDevice> out;
  for (const EGLDeviceEXT device : devices.value()) {
    EglDevice found{static_cast<std::uint32_t>(out.size()), false, {}};
    if (const auto ask = library().QueryDeviceString; ask != nullptr) {
      const char* extensions = ask(device, EGL_EXTENSIONS);
      found.software = lists(extensions, "EGL_MESA_device_software");
      const bool has_file = lists(extensions, "EGL_EXT_device_drm");
      const char* file = has_file ? ask(device, EGL_DRM_DEVICE_FILE_EXT) : nullptr;
      if (file != nullptr) found.file = file;
    }
    out.push_back(std::move(found));
  }
  return out;
}

Result<std::shared_ptr<Platform>> openEglDevice(std::uint32_t index) {
  const auto devices = enumerate();
  if (!devices) return devices.error();
  if (index >= devices.value().size()) {
    return unavailable("there are " + std::to_string(devices.value().size()) + " EGL devices");
  }
  return onDisplay(
      library().GetPlatformDisplay(EGL_PLATFORM_DEVICE_EXT, devices.value()[index], nullptr));
}

Result<std::shared_ptr<Platform>> openEglSurfaceless() {
  const Egl& egl = library();
  if (!egl.missing.empty()) return unavailable(egl.missing);
  if (!lists(egl.QueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS), "EGL_MESA_platform_surfaceless")) {
    return unavailable("EGL_MESA_platform_surfaceless is not supported");
  }
  return onDisplay(
      egl.GetPlatformDisplay(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr));
}

bool anyGpuDeviceFile() {
  std::error_code ignored;
  for (const char* folder : {"/dev/dri", "/dev"}) {
    const bool all = std::string_view(folder) == "/dev/dri";
    for (const auto& entry : std::filesystem::directory_iterator(folder, ignored)) {
      const std::string name = entry.path().filename().string();
      if (all ? name.starts_with("render") || name.starts_with("card")
              : name.starts_with("nvidia") || name.starts_with("mali") || name == "kgsl-3d0") {
        return true;
      }
    }
  }
  return false;
}

}  // namespace culld::gpu
