#include "culling/methods/occlusion_map_frame.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "culling/raster/box_cells.h"
#include "culling/raster/object_rows.h"
#include "culling/raster/rounding.h"

namespace culld {
namespace {

// Nanoseconds of counted work, after those of `raster`: rough.
constexpr std::uint64_t kFrameNs = 20'000, kNodeNs = 150, kTexelNs = 5, kBlockNs = 6;

}  // namespace

OcclusionMapFrame::OcclusionMapFrame(const OcclusionMapScene& scene,
                                     const OcclusionMapOptions& options, const Camera& camera,
                                     const Deadline& deadline, const Demand& demand,
                                     OcclusionMapMemory& memory)
    : scene_(scene),
      options_(options),
      budget_(deadline, demand.work),
      memory_(memory),
      view_(cellView(camera, gridFor(camera))),
      origin_world_(camera.origin_world),
      walk_(camera, scene.bvh, view_),
      drawing_(scene.scene, scene.occluders, view_, origin_world_, deadline, memory.occluder),
      image_px_(static_cast<double>(camera.width_px) * camera.height_px),
      accepted_px_(acceptedLossPx(camera, demand, options.accepted_px)),
      polygons_left_(options.most_polygons) {
  if (accepted_px_ > 0.0) hole_ = negligibleHole(options.opacity);
  memory_.cells.reset(view_.grid);
  memory_.depth.reset(view_.grid, options.depth_regions);
  memory_.queue.clear();
  memory_.chosen.clear();
  memory_.stack.clear();
}

std::uint64_t OcclusionMapFrame::countedNs() const {
  return kFrameNs + kNodeNs * stats_.nodes_visited + kTexelNs * texels_ +
         kBlockNs * view_.grid.blocks();
}

/// Largest on the image first: a node is opened only while something below it may be as large as
/// the next occluder.
void OcclusionMapFrame::chooseOccluders() {
  std::vector<ImageItem>& queue = memory_.queue;
  walk_.pushRoots(queue);
  std::make_heap(queue.begin(), queue.end(), smallerFirst);
  while (!queue.empty() && mayGoOn()) {
    std::pop_heap(queue.begin(), queue.end(), smallerFirst);
    const ImageItem item = queue.back();
    queue.pop_back();
    if (item.ref.isObject()) {
      if (!choose(item)) return;
      continue;
    }
    ++stats_.nodes_visited;
    walk_.forEachChild(item, [&](const ImageItem& child, bool blocks, bool inside) {
      if (!blocks || !inside || !largeEnough(child.rect)) return;
      if (child.ref.isObject() && !scene_.database.holds(child.ref.objectId())) return;
      queue.push_back(child);
      std::push_heap(queue.begin(), queue.end(), smallerFirst);
    });
  }
}

/// False once the budget is used up.
bool OcclusionMapFrame::choose(const ImageItem& item) {
  if (memory_.chosen.size() >= options_.most_occluders) return false;
  const Instance& instance = scene_.scene.instance(item.ref.objectId());
  const OccluderMesh& mesh = scene_.occluders.mesh(instance.mesh);
  // One that reaches the eye would be anywhere on the image, as far back as its far end.
  if (!options_.depth_of_cells && !std::isfinite(item.nearest)) return true;
  // Of those left out, a simpler one may still fit.
  if (mesh.polygons() > polygons_left_ || !worthDrawing(item.rect, mesh)) return true;
  polygons_left_ -= mesh.polygons();
  memory_.chosen.push_back(item);
  return true;
}

/// Front to back: what is hidden by then adds nothing to the map.
void OcclusionMapFrame::drawOccluders() {
  std::sort(memory_.chosen.begin(), memory_.chosen.end(), nearerFirst);
  for (const ImageItem& item : memory_.chosen) {
    if (!mayGoOn()) return;
    if (memory_.cells.certainlyHidden(item.rect, item.nearest)) continue;
    const Instance& instance = scene_.scene.instance(item.ref.objectId());
    const DrawnOccluder drawn =
        drawing_.draw(instance, item.nearest, budget_.leftNs(countedNs()), memory_.cells);
    ++stats_.occluders_drawn;
    stats_.triangles_drawn += drawn.triangles;
    budget_.drew(drawn);
    if (!options_.depth_of_cells) memory_.depth.add(item.rect, farthestOf(instance));
  }
}

float OcclusionMapFrame::farthestOf(const Instance& instance) const {
  const Mesh& mesh = scene_.scene.mesh(instance.mesh);
  const glm::dvec3 largest = glm::max(glm::abs(mesh.bounds.min), glm::abs(mesh.bounds.max));
  return farthestNearness(objectRows(view_, instance.world_from_mesh, origin_world_, largest),
                          mesh.bounds, view_.perspective);
}

/// Where holes are accepted, they are for objects of which all blocks: in one place, one of them at
/// most can be seen. What is see-through, and nodes that may hold such, are held to the proof.
std::uint32_t OcclusionMapFrame::holeFor(const ImageItem& item) const {
  if (hole_ == 0 || scene_.all_block) return hole_;
  if (item.ref.isNode()) return 0;
  const MeshId mesh = scene_.scene.instance(item.ref.objectId()).mesh;
  return scene_.see_through[mesh] != 0 ? 0 : hole_;
}

bool OcclusionMapFrame::hidden(const ImageItem& item) {
  if (!memory_.depth.behind(item.rect, item.nearest)) return false;
  const std::uint32_t hole = holeFor(item);
  const Overlap overlap = memory_.map.overlap(item.rect, {hole, options_.give_up});
  texels_ += overlap.texels;
  return overlap.covered && (hole == 0 || memory_.ledger.take(item.rect));
}

void OcclusionMapFrame::run(Answer& answer) {
  chooseOccluders();
  drawOccluders();
  memory_.map.build(memory_.cells, options_.levels);
  if (options_.depth_of_cells) memory_.depth.addCells(memory_.cells);
  memory_.ledger.reset(memory_.map, image_px_, accepted_px_);
  walk_.appendUnhidden(
      memory_.stack, [this] { return mayGoOn(); },
      [this](const ImageItem& item) { return hidden(item); }, stats_, in_frustum_, answer.visible);
  if (accepted_px_ > 0.0) {
    answer.guarantee = Guarantee::kApproximate;
    answer.missed_px = floatUp(memory_.ledger.lostPx());
  }
  answer.out_of_budget = budget_.stopped();
  if (!budget_.stopped()) stats_.in_frustum = in_frustum_;
  stats_.work = budget_.work(countedNs());
  answer.stats = stats_;
}

}  // namespace culld
