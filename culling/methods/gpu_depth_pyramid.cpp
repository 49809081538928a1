#include "culling/methods/gpu_depth_pyramid.h"

#include <algorithm>
#include <atomic>
#include <memory>
#include <string>
#include <utility>

#include "culling/box_answer.h"
#include "culling/gpu/backend.h"
#include "culling/gpu/unavailable.h"
#include "culling/methods/gpu_depth_pyramid_frame.h"
#include "culling/spatial/prepared_boxes.h"

namespace culld {
namespace {

using SharedOccluders = std::shared_ptr<const GpuOccluders>;

constexpr std::string_view kName = "gpu-depth-pyramid";
constexpr std::uint64_t kBytesPerObject = 32;  ///< of boxes on the GPU, about

std::uint64_t nextKey() {
  static std::atomic<std::uint64_t> last{0};
  return ++last;
}

class GpuDepthPyramidCuller final : public Culler {
 public:
  GpuDepthPyramidCuller(PreparedBoxes boxes, SharedOccluders occluders,
                        const GpuDepthPyramidParts& parts, const Clock& clock)
      : boxes_(std::move(boxes)), occluders_(std::move(occluders)), parts_(parts), clock_(clock) {}

  Answer cull(const Camera& camera, const Demand& demand, ViewState& view) const override {
    const auto start = clock_.now();
    const Deadline deadline(clock_, start, demand.time);
    Answer answer;
    if (!holdsInMotion(camera)) {
      answerFrustum(boxes_, camera, deadline,
                    "gpu-depth-pyramid: the camera may turn too far, occlusion is left out",
                    answer);
    } else if (auto done = onGpu(camera, demand, deadline, view, answer); !done) {
      answer = Answer{};
      answerFrustum(boxes_, camera, deadline, std::string(kName) + ": " + done.error().message,
                    answer);
    }
    completeAnswer(boxes_, kName, answer);
    answer.stats.time = clock_.now() - start;
    return answer;
  }

  Result<std::unique_ptr<Culler>> edited(SnapshotPtr next,
                                         std::span<const ObjectId> changed) const override {
    return around(boxes_.edited(std::move(next), changed), occluders_, parts_, clock_);
  }

  std::size_t preparedBytes() const noexcept override {
    return boxes_.bytes() + occluders_->bytes();
  }

  static Result<std::unique_ptr<Culler>> around(Result<PreparedBoxes> boxes,
                                                SharedOccluders occluders,
                                                const GpuDepthPyramidParts& parts,
                                                const Clock& clock) {
    if (!boxes) return std::move(boxes).error();
    return std::unique_ptr<Culler>(std::make_unique<GpuDepthPyramidCuller>(
        std::move(boxes).value(), std::move(occluders), parts, clock));
  }

 private:
  Result<void> onGpu(const Camera& camera, const Demand& demand, const Deadline& deadline,
                     ViewState& view, Answer& answer) const {
    gpu::Backend* backend = gpu::backend();
    if (backend == nullptr) return gpu::unavailable(gpu::whyNoBackend());
    const WideBvh& bvh = boxes_.bvh();
    if (bvh.nodeCount() * sizeof(gpu::BoxGroup) > backend->mostBufferBytes()) {
      return gpu::unavailable("more boxes than a buffer of this GPU holds");
    }
    GpuDepthPyramidFrame frame(*boxes_.scene(), bvh, *occluders_, parts_, camera, deadline, demand,
                               view.memory<GpuDepthPyramidMemory>());
    if (!frame.fits(backend->mostBufferBytes())) return gpu::unavailable("the image is too large");
    auto lease = backend->acquire();
    if (!lease) return lease.error();
    const gpu::GroupSource source{key_, bvh.nodeCount(), [&bvh](std::vector<gpu::BoxGroup>& out) {
                                    for (std::uint32_t i = 0; i < bvh.nodeCount(); ++i) {
                                      gpu::BoxGroup& group = out.emplace_back();
                                      std::copy_n(&bvh.node(i).offsets[0][0], group.size(),
                                                  group.begin());
                                    }
                                  }};
    return frame.run(lease.value(), source, answer);
  }

  PreparedBoxes boxes_;
  SharedOccluders occluders_;
  GpuDepthPyramidParts parts_;
  const Clock& clock_;
  std::uint64_t key_ = nextKey();  ///< of the boxes on the GPU
};

constexpr Setting kSettings[] = {
    {"coherence", "draws what the last frame found visible before all else"},
    {"refine", "finer levels of the pyramid that are asked where the first does not hide", 2, 0, 3},
    {"faces", "flat faces drawn of a mesh that is not made of convex pieces", 16, 0, 256},
};

class GpuDepthPyramidMethod final : public Method {
 public:
  explicit GpuDepthPyramidMethod(const GpuDepthPyramidParts& parts) : parts_(parts) {}

  MethodInfo info() const noexcept override {
    return {kName, "culld; two passes as in today's engines", Guarantee::kConservative,
            "OpenGL 4.5"};
  }
  Result<void> accepts(const SceneProfile& profile) const override {
    const gpu::Backend* backend = gpu::backend();
    if (backend == nullptr) {
      return Error{ErrorCode::kUnsupported, std::string(kName) + ": " + gpu::whyNoBackend()};
    }
    if (profile.objects * kBytesPerObject > backend->mostBufferBytes()) {
      return Error{ErrorCode::kUnsupported,
                   std::string(kName) + ": more objects than a buffer of this GPU holds"};
    }
    return Done{};
  }
  Result<std::unique_ptr<Culler>> prepare(SnapshotPtr scene, const Clock& clock) const override {
    auto occluders = std::make_shared<const GpuOccluders>(GpuOccluders::of(*scene, parts_.faces));
    return GpuDepthPyramidCuller::around(PreparedBoxes::of(std::move(scene)), std::move(occluders),
                                         parts_, clock);
  }
  std::span<const Setting> settings() const noexcept override { return kSettings; }
  std::unique_ptr<const Method> with(const SettingValues& values) const override {
    GpuDepthPyramidParts parts;
    parts.coherence = values.on("coherence");
    parts.refine = static_cast<std::uint32_t>(values.number("refine"));
    parts.faces = static_cast<std::uint32_t>(values.number("faces"));
    return std::make_unique<GpuDepthPyramidMethod>(parts);
  }

 private:
  GpuDepthPyramidParts parts_;
};

}  // namespace

const Method& gpuDepthPyramidMethod() noexcept {
  static const GpuDepthPyramidMethod method{GpuDepthPyramidParts{}};
  return method;
}

}  // namespace culld
