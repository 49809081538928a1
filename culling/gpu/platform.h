// Ways to an OpenGL 4.5 context without a window: an EGL device, Mesa's surfaceless EGL, OSMesa.
// Libraries are opened when asked for and stay: their threads and thread-local state do not survive
// being unloaded. EGL and OSMesa share state inside Mesa, so a process uses one of them only.
#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "culling/core/result.h"
#include "culling/gpu/gl_table.h"

namespace culld::gpu {

/// An OpenGL context. Current in at most one thread at a time.
class NativeContext {
 public:
  virtual ~NativeContext() = default;
  /// False: it cannot be.
  virtual bool makeCurrent() = 0;
  /// No context is current in this thread after it.
  virtual void release() = 0;
};

class Platform {
 public:
  virtual ~Platform() = default;
  /// OpenGL 4.5 core, told when the GPU was reset where the driver can. THREADS: any. ERROR:
  /// kUnavailable, says which call failed.
  virtual Result<std::unique_ptr<NativeContext>> createContext() = 0;
  /// REQUIRES: a context of this platform is current.
  virtual GlProc (*finder() const)(const char*) = 0;
};

struct EglDevice {
  std::uint32_t index = 0;  ///< as EGL enumerates them
  bool software = false;
  std::string file;  ///< "/dev/dri/card0"; may be empty
};

/// ERROR: kUnavailable, says why none can be asked for. May be empty.
Result<std::vector<EglDevice>> eglDevices();

Result<std::shared_ptr<Platform>> openEglDevice(std::uint32_t index);
Result<std::shared_ptr<Platform>> openEglSurfaceless();
Result<std::shared_ptr<Platform>> openOsMesa();

/// True if this machine shows a device file that a GPU driver makes. COST: microseconds; nothing is
/// loaded.
bool anyGpuDeviceFile();

}  // namespace culld::gpu
