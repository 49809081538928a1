#include "culling/methods/item_buffer.h"

#include <algorithm>
#include <memory>
#include <string>
#include <utility>

#include "culling/box_answer.h"
#include "culling/gpu/backend.h"
#include "culling/gpu/unavailable.h"
#include "culling/methods/item_buffer_frame.h"
#include "culling/methods/item_buffer_meshes.h"
#include "culling/spatial/prepared_boxes.h"

namespace culld {
namespace {

using SharedMeshes = std::shared_ptr<const ItemMeshes>;

constexpr std::string_view kName = "item-buffer";

std::string noteOf(std::string_view what) { return std::string(kName) + ": " + std::string(what); }

/// Per object of answer.visible, which is ascending: its pixels, 0 of what was not drawn.
std::vector<float> inOrder(const std::vector<ObjectId>& visible, const ItemPixels& pixels) {
  std::vector<float> out(visible.size(), 0.0F);
  std::size_t at = 0;
  for (const auto& [id, count] : pixels) {
    at = static_cast<std::size_t>(
        std::lower_bound(visible.begin() + static_cast<std::ptrdiff_t>(at), visible.end(), id) -
        visible.begin());
    out[at] = count;
  }
  return out;
}

class ItemBufferCuller final : public Culler {
 public:
  ItemBufferCuller(PreparedBoxes boxes, SharedMeshes meshes, const ItemBufferParts& parts,
                   const Clock& clock)
      : boxes_(std::move(boxes)), meshes_(std::move(meshes)), parts_(parts), clock_(clock) {}

  Answer cull(const Camera& camera, const Demand& demand, ViewState& /*view*/) const override {
    const auto start = clock_.now();
    const Deadline deadline(clock_, start, demand.time);
    Answer answer;
    answerFrustum(boxes_, camera, deadline, "", answer);
    const bool in_time = !answer.out_of_budget;
    const auto pixels = in_time ? onGpu(camera, demand, deadline, answer) : ItemPixels{};
    if (!pixels) answer.note = noteOf(pixels.error().message);
    completeAnswer(boxes_, kName, answer);
    if (pixels && !answer.out_of_budget) promise(camera, pixels.value(), answer);
    answer.stats.time = clock_.now() - start;
    return answer;
  }

  Result<std::unique_ptr<Culler>> edited(SnapshotPtr next,
                                         std::span<const ObjectId> changed) const override {
    return around(boxes_.edited(std::move(next), changed), meshes_, parts_, clock_);
  }

  std::size_t preparedBytes() const noexcept override { return boxes_.bytes() + meshes_->bytes(); }

  static Result<std::unique_ptr<Culler>> around(Result<PreparedBoxes> boxes, SharedMeshes meshes,
                                                const ItemBufferParts& parts, const Clock& clock) {
    if (!boxes) return std::move(boxes).error();
    return std::unique_ptr<Culler>(std::make_unique<ItemBufferCuller>(
        std::move(boxes).value(), std::move(meshes), parts, clock));
  }

 private:
  Result<ItemPixels> onGpu(const Camera& camera, const Demand& demand, const Deadline& deadline,
                           Answer& answer) const {
    if (demand.guarantee < Guarantee::kSampled) {
      return gpu::unavailable("samples are no proof, and " +
                              std::string(guaranteeName(demand.guarantee)) +
                              " answers are demanded: occlusion is left out");
    }
    if (!camera.motion.still()) {
      return gpu::unavailable("the camera may move between samples, occlusion is left out");
    }
    gpu::Backend* backend = gpu::backend();
    if (backend == nullptr) return gpu::unavailable(gpu::whyNoBackend());
    if (!ItemBufferFrame::fits(camera, parts_.lattice)) {
      return gpu::unavailable("the image is too large");
    }
    if (meshes_->uploadedBytes() > gpu::ItemPass::kResidentBytes) {
      return gpu::unavailable("the meshes are larger than the memory for them");
    }
    auto lease = backend->acquire();
    if (!lease) return lease.error();
    ItemBufferFrame frame(*boxes_.scene(), *meshes_, parts_, camera, deadline, demand.work);
    return frame.run(lease.value(), answer);
  }

  void promise(const Camera& camera, const ItemPixels& pixels, Answer& answer) const {
    answer.guarantee = Guarantee::kSampled;
    answer.note = noteOf("sampled(" + std::to_string(camera.width_px) + ", " +
                         std::to_string(camera.height_px) + ", " +
                         std::to_string(parts_.lattice * parts_.lattice) + ")");
    answer.pixels = inOrder(answer.visible, pixels);
  }

  PreparedBoxes boxes_;
  SharedMeshes meshes_;
  ItemBufferParts parts_;
  const Clock& clock_;
};

constexpr ItemBufferParts kStandard{};

constexpr Setting kSettings[] = {
    {"lattice", "samples along each side of a pixel", kStandard.lattice, 1, 4},
    {"ties", "answers surfaces at the depth of what hides them too"},
};

class ItemBufferMethod final : public Method {
 public:
  explicit ItemBufferMethod(const ItemBufferParts& parts) : parts_(parts) {}

  MethodInfo info() const noexcept override {
    return {kName, "Weghorst, Hooper, Greenberg 1984", Guarantee::kSampled, "OpenGL 4.5"};
  }
  Result<void> accepts(const SceneProfile& /*profile*/) const override {
    if (gpu::backend() != nullptr) return Done{};
    return Error{ErrorCode::kUnsupported, noteOf(gpu::whyNoBackend())};
  }
  Result<std::unique_ptr<Culler>> prepare(SnapshotPtr scene, const Clock& clock) const override {
    auto meshes = std::make_shared<const ItemMeshes>(*scene);
    return ItemBufferCuller::around(PreparedBoxes::of(std::move(scene)), std::move(meshes), parts_,
                                    clock);
  }
  std::span<const Setting> settings() const noexcept override { return kSettings; }
  std::unique_ptr<const Method> with(const SettingValues& values) const override {
    ItemBufferParts parts;
    parts.lattice = static_cast<std::uint32_t>(values.number("lattice"));
    parts.ties = values.on("ties");
    return std::make_unique<ItemBufferMethod>(parts);
  }

 private:
  ItemBufferParts parts_;
};

}  // namespace

const Method& itemBufferMethod() noexcept {
  static const ItemBufferMethod method{ItemBufferParts{}};
  return method;
}

}  // namespace culld
