#include "client/cli/camera_run.h"

#include <algorithm>
#include <utility>

#include "protocol/camera_file.h"

namespace culld::client {
namespace {

/// What a server says about a view, without the view's number and the words before the field: the
/// reader knows a file, not a wire.
std::string withoutView(std::string message) {
  for (const std::string_view prefix : {"view 1: ", "camera: "}) {
    if (message.rfind(prefix, 0) == 0) message.erase(0, prefix.size());
  }
  return message;
}

}  // namespace

int CameraRun::start(const Server& server, const CullArguments& arguments) {
  arguments_ = &arguments;
  const auto guarantee = protocol::guaranteeNamed(arguments.guarantee);
  if (!guarantee) return fail(guarantee.error());
  demand_ = arguments.demand;
  demand_.guarantee = guarantee.value();
  auto cameras =
      protocol::readCameraFile(arguments.cameras, {arguments.width_px, arguments.height_px});
  if (!cameras) return fail(kUsage, cameras.error().message);
  cameras_ = std::move(cameras).value();
  return openView(server);
}

int CameraRun::openView(const Server& server) {
  const CullArguments& a = *arguments_;
  auto connection = Connection::open(server.address, a.scene, server.once());
  if (!connection) return fail(connection.error());
  connection_ = std::move(connection).value();
  connection_->onSceneChanged([this](const SceneInfo&, bool replaced) {
    if (replaced) replaced_ = true;
  });
  // Only now: from here on the daemon tells of a scene that is replaced.
  if (!a.output.empty()) {
    auto objects = Scenes(server.address, server.access).objects(a.scene);
    if (!objects) return fail(objects.error());
    objects_ = std::move(objects).value();
    writer_.emplace(std::exchange(objects_.names, {}));
  }
  auto view = connection_->openView(a.method, true);
  if (!view) {
    if (view.error().code == ErrorCode::kUnavailable) return fail(view.error());
    return fail(kUsage, withoutView(view.error().message));
  }
  view_ = std::move(view).value();
  const SceneInfo scene = connection_->scene();
  header_ = {view_->method(), view_->guarantee(), scene.objects, scene.triangles};
  if (!protocol::satisfies(view_->guarantee(), demand_.guarantee)) {
    return fail(kUsage, "method " + header_.method + ": gives " +
                            protocol::guaranteeName(view_->guarantee()) + " answers, not the " +
                            a.guarantee + " ones demanded");
  }
  return kFine;
}

FramePtr CameraRun::cull(std::size_t camera) {
  auto frame = view_->cull(cameras_[camera], demand_);
  if (!frame) {
    const Error& error = frame.error();
    if (error.code == ErrorCode::kUnavailable) return stop(fail(error));
    const std::string what = withoutView(error.message);
    if (what.rfind("demand.", 0) == 0) return stop(fail(kUsage, what));  // the options' fault
    return stop(
        fail(kUsage, arguments_->cameras + ": camera " + std::to_string(camera) + ": " + what));
  }
  if (!protocol::satisfies(frame.value()->guarantee, demand_.guarantee)) {
    return stop(fail(kFailed, arguments_->cameras + ": camera " + std::to_string(camera) +
                                  ": the answer is " +
                                  protocol::guaranteeName(frame.value()->guarantee) + ", not " +
                                  arguments_->guarantee));
  }
  if (writer_ && !record(camera, *frame.value())) return nullptr;
  return std::move(frame).value();
}

Result<std::size_t> CameraRun::inFrustum(std::size_t camera) {
  if (!frustum_view_) {
    auto view = connection_->openView("frustum");
    if (!view) return std::move(view).error();
    frustum_view_ = std::move(view).value();
  }
  const auto frame = frustum_view_->cull(cameras_[camera]);
  if (!frame) return frame.error();
  return frame.value()->visible.size();
}

FramePtr CameraRun::stop(int exit_code) {
  exit_code_ = exit_code;
  return nullptr;
}

bool CameraRun::record(std::size_t camera, const Frame& frame) {
  if (replaced_ || frame.scene_version != objects_.version) {
    exit_code_ = fail(kFailed, "scene " + arguments_->scene + " was changed while it was culled");
    return false;
  }
  header_.method = frame.method;
  header_.guarantee = std::max(header_.guarantee, frame.guarantee);  // the weakest of all
  protocol::AnswerFrame answer;
  answer.camera = camera;
  answer.visible = frame.visible;
  answer.seen = frame.seen;
  answer.seconds = static_cast<double>(frame.stats.cull_ns) * 1e-9;
  answer.missed_px = frame.missed_px;
  answer.proven = frame.proven;
  answer.out_of_budget = frame.out_of_budget;
  answer.guarantee = frame.guarantee;
  answer.made_by = frame.made_by;
  const auto added = writer_->add(answer);
  if (!added) exit_code_ = fail(kFailed, arguments_->cameras + ": " + added.error().message);
  return added.ok();
}

int CameraRun::finish() {
  if (!writer_) return kFine;
  const auto written = protocol::writeTextFile(arguments_->output, writer_->text(header_));
  return written ? kFine : fail(kDisk, written.error().message);
}

}  // namespace culld::client
