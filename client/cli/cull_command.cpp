#include "client/cli/camera_run.h"
#include "client/cli/commands.h"

namespace culld::client {

int runCull(const Server& server, const CullArguments& arguments) {
  CameraRun run;
  if (const int code = run.start(server, arguments); code != kFine) return code;
  for (std::size_t i = 0; i < run.cameras().size(); ++i) {
    if (run.cull(i) == nullptr) return run.exitCode();
  }
  return run.finish();
}

}  // namespace culld::client
