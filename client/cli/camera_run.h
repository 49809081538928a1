// One file of cameras sent through one view: what `cull` and `fly` have in common.
#pragma once
#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "client/cli/commands.h"
#include "culld/connection.h"
#include "culld/scenes.h"
#include "protocol/answer_file.h"

namespace culld::client {

class CameraRun {
 public:
  /// Checks the arguments, reads the cameras, connects, opens the view. Returns kFine, or the exit
  /// code after it has said what is wrong. REQUIRES: `arguments` outlives this.
  int start(const Server& server, const CullArguments& arguments);

  const std::vector<Camera>& cameras() const noexcept { return cameras_; }
  SceneInfo scene() const { return connection_->scene(); }
  const View& view() const noexcept { return *view_; }

  /// Null after it has said what is wrong; then exitCode().
  FramePtr cull(std::size_t camera);
  int exitCode() const noexcept { return exit_code_; }

  /// How many objects are not outside the frustum: a method that skips what is hidden never counts
  /// them, so a second view asks the method that only looks at the frustum.
  Result<std::size_t> inFrustum(std::size_t camera);

  /// Writes the answers to cull() calls since start(), if an output was asked for.
  int finish();

 private:
  int openView(const Server& server);
  FramePtr stop(int exit_code);
  bool record(std::size_t camera, const Frame& frame);

  const CullArguments* arguments_ = nullptr;
  std::vector<Camera> cameras_;
  Demand demand_;
  ObjectTable objects_;
  std::optional<protocol::AnswerWriter> writer_;
  protocol::AnswerHeader header_;
  std::atomic<bool> replaced_ = false;
  std::unique_ptr<Connection> connection_;
  std::optional<View> view_, frustum_view_;
  int exit_code_ = kFine;
};

}  // namespace culld::client
