#include "culling/gpu/item_pass.h"

#include <GL/glcorearb.h>

#include "culling/gpu/item_shaders.h"

namespace culld::gpu {
namespace {

// Bindings, locations and sizes, as the shaders say.
constexpr unsigned kItems = 0, kCounts = 1, kIds = 0, kPosition = 0;
constexpr int kFirst = 0, kNearerFactor = 1, kSize = 0;
constexpr std::uint32_t kSamplesPerInvocation = 16, kCountGroup = 64;
constexpr unsigned kClipDistances = 6;

// Asked surfaces are drawn nearer by what two depths of the same place may differ. A software
// renderer's were measured to be 153 units of the last place wrong, 2^-15.7 of them; and a vertex
// snaps to 1 / 256 of a pixel.
constexpr float kNearer = 1.0F + 0x1p-14F, kNearerSlopes = 0x1p-6F;

/// What drawing items needs, and what every other user of the context expects afterwards.
class DrawState {
 public:
  DrawState(const GlTable& gl, ItemPass::Stage stage) : gl_(gl) {
    gl.Enable(GL_DEPTH_TEST);
    for (unsigned i = 0; i < kClipDistances; ++i) gl.Enable(GL_CLIP_DISTANCE0 + i);
    gl.ClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
    gl.DepthFunc(GL_GREATER);
    if (stage == ItemPass::Stage::kNearest) return;
    gl.DepthFunc(GL_GEQUAL);
    gl.DepthMask(GL_FALSE);
    gl.Enable(GL_POLYGON_OFFSET_FILL);
    gl.PolygonOffset(kNearerSlopes, 0.0F);
  }
  DrawState(const DrawState&) = delete;
  DrawState& operator=(const DrawState&) = delete;
  ~DrawState() {
    gl_.Disable(GL_DEPTH_TEST);
    for (unsigned i = 0; i < kClipDistances; ++i) gl_.Disable(GL_CLIP_DISTANCE0 + i);
    gl_.ClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
    gl_.DepthFunc(GL_LESS);
    gl_.DepthMask(GL_TRUE);
    gl_.Disable(GL_POLYGON_OFFSET_FILL);
    gl_.Disable(GL_CULL_FACE);
    gl_.FrontFace(GL_CCW);
  }

  void face(Facing facing) const {
    (facing == Facing::kBoth ? gl_.Disable : gl_.Enable)(GL_CULL_FACE);
    gl_.FrontFace(facing == Facing::kClockwise ? GL_CW : GL_CCW);
  }

 private:
  const GlTable& gl_;
};

}  // namespace

ItemPass::ItemPass(const GlTable& gl, std::size_t contexts)
    : gl_(gl), ready_(Done{}), items_(gl), counts_(gl), meshes_(gl, kResidentBytes / contexts) {
  keep(Program::drawing(gl, kItemVertexShader, kNearestFragmentShader), nearest_, ready_);
  keep(Program::drawing(gl, kItemVertexShader, kAskedFragmentShader), asked_, ready_);
  keep(Program::compute(gl, kCountShader), counting_, ready_);
  gl.CreateFramebuffers(1, &whole_);
  gl.CreateFramebuffers(1, &depth_only_);
  gl.CreateVertexArrays(1, &vertex_array_);
  gl.EnableVertexArrayAttrib(vertex_array_, kPosition);
  gl.VertexArrayAttribFormat(vertex_array_, kPosition, 3, GL_FLOAT, GL_FALSE, 0);
}

ItemPass::~ItemPass() {
  gl_.DeleteVertexArrays(1, &vertex_array_);
  gl_.DeleteFramebuffers(1, &depth_only_);
  gl_.DeleteFramebuffers(1, &whole_);
  gl_.DeleteTextures(1, &depth_);
  gl_.DeleteTextures(1, &image_);
}

void ItemPass::resize(std::uint32_t width, std::uint32_t height) {
  if (width == width_ && height == height_) return;
  width_ = width;
  height_ = height;
  gl_.DeleteTextures(1, &depth_);
  gl_.DeleteTextures(1, &image_);
  gl_.CreateTextures(GL_TEXTURE_2D, 1, &image_);
  gl_.CreateTextures(GL_TEXTURE_2D, 1, &depth_);
  const int w = static_cast<int>(width), h = static_cast<int>(height);
  gl_.TextureStorage2D(image_, 1, GL_R32UI, w, h);
  gl_.TextureStorage2D(depth_, 1, GL_DEPTH_COMPONENT32F, w, h);
  gl_.NamedFramebufferTexture(whole_, GL_COLOR_ATTACHMENT0, image_, 0);
  gl_.NamedFramebufferTexture(whole_, GL_DEPTH_ATTACHMENT, depth_, 0);
  gl_.NamedFramebufferTexture(depth_only_, GL_DEPTH_ATTACHMENT, depth_, 0);
}

void ItemPass::begin(std::uint32_t width, std::uint32_t height, std::size_t numbers) {
  resize(width, height);
  const unsigned nobody = 0;
  const float farthest = 0.0F;
  gl_.ClearNamedFramebufferuiv(whole_, GL_COLOR, 0, &nobody);
  gl_.ClearNamedFramebufferfv(whole_, GL_DEPTH, 0, &farthest);
  numbers_ = numbers;
  counts_.reserve(numbers * sizeof(std::uint32_t));
  gl_.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);  // after what shaders counted for the last frame
  counts_.fill(numbers, 0);
}

void ItemPass::draw(Stage stage, const MeshSource& meshes, std::span<const Item> items,
                    std::span<const ItemDraw> draws) {
  if (draws.empty()) return;
  const Buffer& mesh = meshes_.get<std::uint32_t>(meshes.key, meshes.words(), meshes.fill);
  constexpr std::size_t kVertexBytes = 3 * sizeof(float);
  gl_.VertexArrayVertexBuffer(vertex_array_, kPosition, mesh.name(), 0, kVertexBytes);
  gl_.VertexArrayElementBuffer(vertex_array_, mesh.name());
  gl_.BindVertexArray(vertex_array_);
  items_.upload<Item>(items);
  items_.bind(kItems);
  counts_.bind(kCounts);
  gl_.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
  gl_.BindFramebuffer(GL_FRAMEBUFFER, stage == Stage::kNearest ? whole_ : depth_only_);
  gl_.Viewport(0, 0, static_cast<int>(width_), static_cast<int>(height_));
  const unsigned program = (stage == Stage::kNearest ? nearest_ : asked_).name();
  gl_.UseProgram(program);
  gl_.ProgramUniform1f(program, kNearerFactor, stage == Stage::kNearest ? 1.0F : kNearer);
  const DrawState state(gl_, stage);
  for (const ItemDraw& d : draws) {
    state.face(d.facing);
    gl_.ProgramUniform1ui(program, kFirst, d.first_item);
    const std::size_t at =
        meshes.vertices * kVertexBytes + std::size_t{d.first_index} * sizeof(std::uint32_t);
    gl_.DrawElementsInstanced(GL_TRIANGLES, static_cast<int>(d.index_count), GL_UNSIGNED_INT,
                              reinterpret_cast<const void*>(at), static_cast<int>(d.item_count));
  }
}

void ItemPass::countTaken() {
  const std::uint32_t in_a_row = (width_ + kSamplesPerInvocation - 1) / kSamplesPerInvocation;
  gl_.UseProgram(counting_.name());
  gl_.ProgramUniform4ui(counting_.name(), kSize, width_, height_, in_a_row, 0);
  gl_.BindImageTexture(kIds, image_, 0, GL_FALSE, 0, GL_READ_ONLY, GL_R32UI);
  counts_.bind(kCounts);
  gl_.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
  gl_.DispatchCompute((in_a_row * height_ + kCountGroup - 1) / kCountGroup, 1, 1);
}

void ItemPass::read(std::vector<std::uint32_t>& counts) const {
  counts.resize(numbers_);
  gl_.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  counts_.read(counts.data(), numbers_ * sizeof(std::uint32_t));
}

}  // namespace culld::gpu
