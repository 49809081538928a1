#include "culling/methods/gpu_depth_pyramid_frame.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "culling/raster/box_cells.h"
#include "culling/raster/object_rows.h"

namespace culld {
namespace {

// Choices of what to draw: they cost or save time and never change what is promised. They look at
// the object and the camera alone, so that answers do not depend on what was drawn first.
constexpr std::uint32_t kLeastOccluderSide = 3;  ///< cells; smaller ones rarely fill any

// Nanoseconds of counted work: rough, and of the CPU's part.
constexpr std::uint64_t kFrameNs = 200'000, kNodeNs = 150, kPieceNs = 1200;

float largestOf(const BoxView& view) {
  float largest = 0.0F;
  for (const auto* row : {&view.u, &view.v, &view.w, &view.n}) {
    for (const float x : *row) largest = std::max(largest, std::isfinite(x) ? std::abs(x) : 1e38F);
  }
  return largest;
}

bool worthDrawing(const BoxRects& rects, std::size_t lane, const CellGrid& grid) {
  if ((rects.off_grid >> lane & 1U) != 0) return false;
  const CellRect rect = cellRect(rects, lane, grid);
  return rect.x1 - rect.x0 + 1 >= kLeastOccluderSide && rect.y1 - rect.y0 + 1 >= kLeastOccluderSide;
}

}  // namespace

GpuDepthPyramidFrame::GpuDepthPyramidFrame(const SceneSnapshot& scene, const WideBvh& bvh,
                                           const GpuOccluders& occluders,
                                           const GpuDepthPyramidParts& parts, const Camera& camera,
                                           const Deadline& deadline, const Demand& demand,
                                           GpuDepthPyramidMemory& memory)
    : scene_(scene),
      bvh_(bvh),
      occluders_(occluders),
      parts_(parts),
      budget_(deadline, demand.work),
      memory_(memory),
      frustum_(camera, bvh),
      view_(cellView(camera, gridFor(camera))),
      box_view_(boxView(view_)),
      eye_world_(camera.origin_world),
      largest_row_(largestOf(box_view_)),
      // Answers limited by work must not hang on what was drawn first.
      coherent_(parts.coherence && camera.motion.still() && demand.work.count() == 0) {}

bool GpuDepthPyramidFrame::fits(std::size_t most_buffer_bytes) const noexcept {
  constexpr std::uint32_t kMost = gpu::DepthPass::kMostSide;
  if (view_.grid.width > kMost || view_.grid.height > kMost) return false;
  return gpu::pyramidLayout(view_.grid).words <= most_buffer_bytes / sizeof(std::uint32_t);
}

Result<void> GpuDepthPyramidFrame::run(gpu::ContextPool::Lease& gpu, const gpu::GroupSource& source,
                                       Answer& answer) {
  auto& pass = gpu.data<gpu::DepthPass>();
  if (!pass.ready()) {  // another context may do better
    gpu.drop(pass.ready().error().message);
    return pass.ready().error();
  }
  if (memory_.kept_in.size() < scene_.objectCount()) memory_.kept_in.resize(scene_.objectCount());
  collect(answer);
  if (!memory_.queries.empty() && !budget_.stopped()) {
    pass.begin(view_.grid);
    const std::uint32_t last = memory_.frame;
    const auto was_visible = [&](ObjectId id) { return memory_.kept_in[id] == last; };
    if (coherent_ && last != 0 && drawOccluders(pass, was_visible) > 0) testAll(pass, source);
    const std::uint32_t more = drawOccluders(pass, [](ObjectId) { return true; });
    if (more > 0) testTheRest(pass, source);
  }
  if (auto fine = gpu.check(); !fine) return fine;
  answerTheRest(answer);
  return Done{};
}

std::uint64_t GpuDepthPyramidFrame::countedNs() const {
  return kFrameNs + kNodeNs * stats_.nodes_visited + kPieceNs * pieces_;
}

/// The objects in the frustum, as queries of whole nodes.
void GpuDepthPyramidFrame::collect(Answer& answer) {
  memory_.queries.clear();
  memory_.lanes.clear();
  memory_.batch.clear();  // of a frame that an exception ended
  std::vector<std::pair<std::uint32_t, PlaneMask>> stack;
  for (auto root = static_cast<std::uint32_t>(bvh_.rootCount()); root-- > 0;) {
    stack.emplace_back(root, frustum_.planes());
  }
  while (!stack.empty()) {
    const auto [index, planes] = stack.back();
    stack.pop_back();
    if (!mayGoOn()) {
      bvh_.appendObjects(index, answer.visible);
      continue;
    }
    ++stats_.nodes_visited;
    const WideNode& node = bvh_.node(index);
    const LaneVerdicts verdicts = frustum_.test(node, planes);
    std::uint32_t objects = 0;
    for (std::uint32_t left = node.live; left != 0; left &= left - 1) {
      const auto lane = static_cast<std::uint32_t>(std::countr_zero(left));
      const bool inside = (verdicts.may_intersect >> lane & 1U) != 0;
      if (node.child[lane].isObject()) {
        ++stats_.tested;
        (inside ? stats_.in_frustum : stats_.outside) += 1;
        if (inside) objects |= 1U << lane;
      } else if (inside) {
        stack.emplace_back(node.child[lane].nodeIndex(), verdicts.planesLeft(lane));
      }
    }
    if (objects != 0) addQuery(index, node, objects);
  }
  constexpr std::size_t kPerWord = gpu::DepthPass::kQueriesPerWord;
  memory_.hidden.assign((memory_.queries.size() + kPerWord - 1) / kPerWord, 0);
}

/// A box whose numbers could overflow is not asked.
void GpuDepthPyramidFrame::addQuery(std::uint32_t index, const WideNode& node,
                                    std::uint32_t objects) {
  gpu::GroupQuery query{index, 0, {}, 0};
  const auto origin = originFrom(node, eye_world_);
  float reach = 1.0F;
  for (std::size_t i = 0; i < 3; ++i) {
    query.origin[i] = static_cast<float>(origin[i]);
    reach += std::abs(query.origin[i]);
  }
  for (std::uint32_t left = objects; left != 0; left &= left - 1) {
    const auto lane = static_cast<std::size_t>(std::countr_zero(left));
    float sum = reach;
    for (const auto& row : node.offsets) sum += std::abs(row[lane]);
    if (sum * largest_row_ < gpu::DepthPass::kLargestTerm) query.lanes |= 1U << lane;
  }
  memory_.queries.push_back(query);
  memory_.lanes.push_back(
      {static_cast<std::uint8_t>(objects), static_cast<std::uint8_t>(node.blocking & objects), 0});
}

std::uint32_t GpuDepthPyramidFrame::hiddenLanes(std::size_t query) const {
  constexpr std::size_t kPerWord = gpu::DepthPass::kQueriesPerWord;
  return memory_.hidden[query / kPerWord] >> (8 * (query % kPerWord)) & 0xFFU;
}

/// Draws what is wanted of the occluders not drawn so far and not hidden. Returns how many.
template <typename Wanted>
std::uint32_t GpuDepthPyramidFrame::drawOccluders(gpu::DepthPass& pass, const Wanted& wanted) {
  std::uint32_t count = 0;
  for (std::size_t q = 0; q < memory_.queries.size(); ++q) {
    const gpu::GroupQuery& query = memory_.queries[q];
    const WideNode& node = bvh_.node(query.group);
    std::uint32_t left = memory_.lanes[q].blocking & ~memory_.lanes[q].drawn & ~hiddenLanes(q);
    BoxRects rects;
    bool projected = false;
    for (; left != 0; left &= left - 1) {
      const auto lane = static_cast<std::uint32_t>(std::countr_zero(left));
      const ObjectId id = node.child[lane].objectId();
      if (!wanted(id)) continue;
      if (!mayGoOn()) break;
      memory_.lanes[q].drawn = static_cast<std::uint8_t>(memory_.lanes[q].drawn | 1U << lane);
      if (!projected) projectBoxes(box_view_, originFrom(node, eye_world_), node.offsets, rects);
      projected = true;
      if (!worthDrawing(rects, lane, view_.grid)) continue;
      drawObject(pass, id);
      ++count;
    }
  }
  flush(pass);
  stats_.occluders_drawn += count;
  return count;
}

void GpuDepthPyramidFrame::drawObject(gpu::DepthPass& pass, ObjectId id) {
  const Instance& instance = scene_.instance(id);
  const int wanted = static_cast<int>(view_.front_sign * handedness(instance.world_from_mesh));
  const std::size_t pieces = occluders_.pieceCount(instance.mesh);
  if (wanted == 0 || pieces == 0) return;
  const ObjectRows rows = objectRows(view_, instance.world_from_mesh, eye_world_,
                                     glm::dvec3(occluders_.largest(instance.mesh)));
  ConvexOutline outline;
  for (std::size_t i = 0; i < pieces; ++i) {
    if (!mayGoOn()) return;
    ++pieces_;
    const OutlineVerdict verdict = outlineOf(occluders_.piece(instance.mesh, i), rows, view_.grid,
                                             view_.perspective, wanted, outline);
    if (verdict != OutlineVerdict::kDraw) continue;
    stats_.triangles_drawn += outline.triangles;
    memory_.batch.add(outline, view_.grid);
    if (memory_.batch.full()) flush(pass);
  }
}

void GpuDepthPyramidFrame::flush(gpu::DepthPass& pass) {
  pass.draw(memory_.batch);
  memory_.batch.clear();
}

void GpuDepthPyramidFrame::testAll(gpu::DepthPass& pass, const gpu::GroupSource& source) {
  pass.buildPyramid();
  pass.test(box_view_, source, memory_.queries, parts_.refine, memory_.hidden);
}

/// Only what the first pass has not hidden.
void GpuDepthPyramidFrame::testTheRest(gpu::DepthPass& pass, const gpu::GroupSource& source) {
  memory_.left.clear();
  memory_.left_of.clear();
  for (std::size_t q = 0; q < memory_.queries.size(); ++q) {
    gpu::GroupQuery query = memory_.queries[q];
    query.lanes &= ~hiddenLanes(q);
    if (query.lanes == 0) continue;
    memory_.left.push_back(query);
    memory_.left_of.push_back(static_cast<std::uint32_t>(q));
  }
  if (memory_.left.empty()) return;
  pass.buildPyramid();
  pass.test(box_view_, source, memory_.left, parts_.refine, memory_.hidden_after);
  constexpr std::size_t kPerWord = gpu::DepthPass::kQueriesPerWord;
  for (std::size_t i = 0; i < memory_.left.size(); ++i) {
    const std::uint32_t lanes = memory_.hidden_after[i / kPerWord] >> (8 * (i % kPerWord)) & 0xFFU;
    const std::size_t q = memory_.left_of[i];
    memory_.hidden[q / kPerWord] |= lanes << (8 * (q % kPerWord));
  }
}

void GpuDepthPyramidFrame::answerTheRest(Answer& answer) {
  if (++memory_.frame == 0) {  // after 2^32 frames old marks could be mistaken for this frame's
    std::fill(memory_.kept_in.begin(), memory_.kept_in.end(), 0U);
    memory_.frame = 1;
  }
  for (std::size_t q = 0; q < memory_.queries.size(); ++q) {
    const WideNode& node = bvh_.node(memory_.queries[q].group);
    const std::uint32_t hidden = hiddenLanes(q);
    stats_.occluded += static_cast<std::uint32_t>(std::popcount(hidden));
    for (std::uint32_t left = memory_.lanes[q].objects & ~hidden; left != 0; left &= left - 1) {
      const ObjectId id = node.child[std::countr_zero(left)].objectId();
      memory_.kept_in[id] = memory_.frame;
      answer.visible.push_back(id);
    }
  }
  if (budget_.stopped()) stats_.in_frustum = 0;  // not counted to the end
  stats_.work = budget_.work(countedNs());
  answer.out_of_budget = budget_.stopped();
  answer.stats = stats_;
}

}  // namespace culld
