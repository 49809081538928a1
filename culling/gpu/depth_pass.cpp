#include "culling/gpu/depth_pass.h"

#include <GL/glcorearb.h>

#include <algorithm>
#include <bit>

#include "culling/gpu/depth_shaders.h"

namespace culld::gpu {
namespace {

constexpr std::uint32_t kReduceSide = 8, kTestGroup = 64;  ///< as the shaders say

// Bindings and locations, as the shaders say.
enum Binding : unsigned { kFirst = 0, kSecond = 1, kCells = 2, kOut = 3 };
enum Location : int {
  kGrid = 0,
  kStride = 1,
  kBelow = 0,
  kLevel = 1,
  kCounts = 0,
  kSizes = 1,
  kRows = 2,
  kLevels = 6
};

std::uint32_t groupsOf(std::size_t items, std::uint32_t size) {
  return static_cast<std::uint32_t>((items + size - 1) / size);
}

}  // namespace

PyramidLayout pyramidLayout(const CellGrid& grid) noexcept {
  PyramidLayout layout;
  std::uint32_t width = std::bit_ceil(grid.width), height = std::bit_ceil(grid.height);
  for (;;) {
    const std::uint32_t k = layout.levels++;
    layout.first[k] = layout.words;
    layout.width[k] = width;
    layout.height[k] = height;
    layout.words += width * height;
    if (width == 1 && height == 1) return layout;
    width = std::max(width / 2, 1U);
    height = std::max(height / 2, 1U);
  }
}

DepthPass::DepthPass(const GlTable& gl, std::size_t contexts)
    : gl_(gl),
      ready_(Done{}),
      heads_(gl),
      lines_(gl),
      pyramid_(gl),
      queries_(gl),
      hidden_(gl),
      scenes_(gl, kResidentBytes / contexts) {
  keep(Program::drawing(gl, kOutlineVertexShader, kOutlineFragmentShader), drawing_, ready_);
  keep(Program::compute(gl, kReduceShader), reducing_, ready_);
  keep(Program::compute(gl, kTestShader), testing_, ready_);
  gl.CreateFramebuffers(1, &framebuffer_);
  gl.CreateVertexArrays(1, &no_vertices_);
}

DepthPass::~DepthPass() {
  gl_.DeleteFramebuffers(1, &framebuffer_);
  gl_.DeleteVertexArrays(1, &no_vertices_);
}

void DepthPass::begin(const CellGrid& grid) {
  grid_ = grid;
  layout_ = pyramidLayout(grid);
  pyramid_.reserve(std::size_t{layout_.words} * sizeof(std::uint32_t));
  gl_.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);  // after what shaders wrote for the last frame
  pyramid_.fill(std::size_t{layout_.width[0]} * layout_.height[0], 0);
  // Nothing is attached: fragments write into the array.
  gl_.NamedFramebufferParameteri(framebuffer_, GL_FRAMEBUFFER_DEFAULT_WIDTH,
                                 static_cast<int>(grid.width));
  gl_.NamedFramebufferParameteri(framebuffer_, GL_FRAMEBUFFER_DEFAULT_HEIGHT,
                                 static_cast<int>(grid.height));
}

void DepthPass::draw(const OutlineBatch& batch) {
  if (batch.heads.empty()) return;
  heads_.upload<OutlineHead>(batch.heads);
  lines_.upload<OutlineLine>(batch.lines);
  gl_.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
  gl_.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  gl_.BindVertexArray(no_vertices_);
  gl_.Viewport(0, 0, static_cast<int>(grid_.width), static_cast<int>(grid_.height));
  gl_.UseProgram(drawing_.name());
  gl_.ProgramUniform2f(drawing_.name(), kGrid, static_cast<float>(grid_.width),
                       static_cast<float>(grid_.height));
  gl_.ProgramUniform1ui(drawing_.name(), kStride, layout_.width[0]);
  heads_.bind(kFirst);
  lines_.bind(kSecond);
  pyramid_.bind(kCells);
  constexpr int kTwoTriangles = 6;
  gl_.DrawArraysInstanced(GL_TRIANGLES, 0, kTwoTriangles, static_cast<int>(batch.heads.size()));
}

void DepthPass::buildPyramid() {
  gl_.UseProgram(reducing_.name());
  pyramid_.bind(kCells);
  std::uint32_t across = grid_.width, down = grid_.height;  // texels that count
  for (std::uint32_t k = 1; k < layout_.levels; ++k) {
    gl_.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    gl_.ProgramUniform4ui(reducing_.name(), kBelow, layout_.first[k - 1], layout_.width[k - 1],
                          across, down);
    gl_.ProgramUniform4ui(reducing_.name(), kLevel, layout_.first[k], layout_.width[k],
                          layout_.height[k], 0);
    gl_.DispatchCompute(groupsOf(layout_.width[k], kReduceSide),
                        groupsOf(layout_.height[k], kReduceSide), 1);
    across = (across + 1) / 2;
    down = (down + 1) / 2;
  }
  gl_.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
}

void DepthPass::test(const BoxView& view, const GroupSource& source,
                     std::span<const GroupQuery> queries, std::uint32_t refine,
                     std::vector<std::uint32_t>& hidden) {
  const std::size_t words = groupsOf(queries.size(), kQueriesPerWord);
  hidden.assign(words, 0);
  if (queries.empty()) return;
  const Buffer& groups = scenes_.get<BoxGroup>(source.key, source.count, source.fill);
  queries_.upload<GroupQuery>(queries);
  hidden_.reserve(words * sizeof(std::uint32_t));
  const unsigned program = testing_.name();
  gl_.UseProgram(program);
  gl_.ProgramUniform4ui(program, kCounts, static_cast<std::uint32_t>(queries.size()), refine,
                        layout_.levels, view.perspective ? 1 : 0);
  const float sizes[4] = {view.width, view.height, view.beside, 0.0F};
  gl_.ProgramUniform4fv(program, kSizes, 1, sizes);
  int row_at = kRows;
  for (const auto* row : {&view.u, &view.v, &view.w, &view.n}) {
    gl_.ProgramUniform4fv(program, row_at++, 1, row->data());
  }
  for (std::uint32_t k = 0; k < layout_.levels; ++k) {
    gl_.ProgramUniform4ui(program, kLevels + static_cast<int>(k), layout_.first[k],
                          layout_.width[k], 0, 0);
  }
  groups.bind(kFirst);
  queries_.bind(kSecond);
  pyramid_.bind(kCells);
  hidden_.bind(kOut);
  gl_.DispatchCompute(groupsOf(words, kTestGroup), 1, 1);
  gl_.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  hidden_.read(hidden.data(), words * sizeof(std::uint32_t));
}

void DepthPass::readPyramid(std::vector<float>& out) const {
  gl_.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  std::vector<std::uint32_t> bits(layout_.words);
  pyramid_.read(bits.data(), bits.size() * sizeof(std::uint32_t));
  out.resize(bits.size());
  std::transform(bits.begin(), bits.end(), out.begin(),
                 [](std::uint32_t word) { return std::bit_cast<float>(word); });
}

}  // namespace culld::gpu
