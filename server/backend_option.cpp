#include "server/backend_option.h"

#include "culling/gpu/backend.h"

namespace culld {

Result<void> openBackendNamed(const std::string& name) {
  const auto choice = gpu::backendNamed(name);
  if (!choice) return invalidInput("backend " + name + ": " + choice.error().message);
  auto opened = gpu::openBackend(choice.value());
  if (!opened) return Error{opened.error().code, "backend " + name + ": " + opened.error().message};
  return Done{};
}

std::string backendInUse() {
  const gpu::Backend* backend = gpu::backend();
  if (backend == nullptr) return "cpu";
  return backend->name() + " (" + backend->renderer() + ")";
}

}  // namespace culld
