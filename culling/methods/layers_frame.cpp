#include "culling/methods/layers_frame.h"

#include <algorithm>

#include "culling/raster/rounding.h"

namespace culld {
namespace {

// Nanoseconds of counted work, as in the other methods that draw (docs/planner.md).
constexpr std::uint64_t kFrameNs = 20'000, kNodeNs = 150, kCellNs = 400;

}  // namespace

LayersFrame::LayersFrame(const LayersScene& scene, const LayersOptions& options,
                         const Camera& camera, const Deadline& deadline, const Demand& demand,
                         LayersMemory& memory)
    : scene_(scene),
      options_(options),
      camera_(camera),
      budget_(deadline, demand.work),
      memory_(memory),
      view_(cellView(camera, gridFor(camera))),
      walk_(camera, scene.bvh, view_),
      drawing_(scene.scene, scene.occluders, view_, camera.origin_world, deadline, memory.occluder),
      accepted_px_(acceptedLossPx(camera, demand, options.accepted_px)),
      // What a demand accepts is kept to, whatever that takes.
      most_triangles_(demand.accepted_missed_px > 0.0F ? 0 : options.most_triangles),
      polygons_left_(options.most_polygons) {
  memory_.projected.assign(scene.scene.objectCount(), 0);
  memory_.cells.reset(view_.grid);
  memory_.stack.clear();
}

std::uint64_t LayersFrame::countedNs() const {
  return kFrameNs + kNodeNs * stats_.nodes_visited + kCellNs * cells_projected_;
}

/// Those that have not been projected yet, and are there with a bound.
void LayersFrame::freshObjects(std::span<const ObjectId> ids) {
  memory_.fresh.clear();
  for (const ObjectId id : ids) {
    if (memory_.projected[id] != 0) continue;
    memory_.projected[id] = 1;
    const Instance& instance = scene_.scene.instance(id);
    if (instance.active() && laneClassOf(instance) == LaneClass::kLane) {
      memory_.fresh.push_back(id);
    }
  }
}

void LayersFrame::project(std::span<const ObjectId> ids, Answer& answer) {
  freshObjects(ids);
  walk_.forEachObject(scene_.scene, memory_.fresh,
                      [&](const ImageItem& item, bool /*blocks*/, bool inside) {
                        ++stats_.tested;
                        if (!inside) {
                          ++stats_.outside;
                          return;
                        }
                        const ObjectId id = item.ref.objectId();
                        answer.visible.push_back(id);
                        const MeshId mesh = scene_.scene.instance(id).mesh;
                        triangles_answered_ += scene_.scene.mesh(mesh).triangles.size();
                      });
}

/// Cell by cell until the front shows no more than was accepted, or the budget is used up.
void LayersFrame::projectAll(Answer& answer) {
  LayersOrder order(scene_.grid, camera_, options_.solidity, memory_.order);
  project(scene_.grid.loose(), answer);
  std::size_t cell = 0;
  while (mayGoOn() && order.frontPx() > accepted_px_ && order.next(cell)) {
    ++cells_projected_;
    project(scene_.grid.objects(cell), answer);
    const bool used_up = most_triangles_ != 0 && triangles_answered_ >= most_triangles_;
    if (used_up) break;
  }
  answer.guarantee = Guarantee::kApproximate;
  answer.proven = false;
  answer.missed_px = floatUp(order.frontPx());
}

void LayersFrame::drawObject(const ImageItem& item) {
  const Instance& instance = scene_.scene.instance(item.ref.objectId());
  const OccluderMesh& mesh = scene_.occluders.mesh(instance.mesh);
  if (mesh.polygons() > polygons_left_ || !worthDrawing(item.rect, mesh) || hidden(item)) return;
  polygons_left_ -= mesh.polygons();
  const DrawnOccluder drawn =
      drawing_.draw(instance, item.nearest, budget_.leftNs(countedNs()), memory_.cells);
  ++stats_.occluders_drawn;
  stats_.triangles_drawn += drawn.triangles;
  budget_.drew(drawn);
}

void LayersFrame::draw(std::span<const ObjectId> ids) {
  freshObjects(ids);
  walk_.forEachObject(scene_.scene, memory_.fresh,
                      [&](const ImageItem& item, bool blocks, bool inside) {
                        if (blocks && inside && mayGoOn()) drawObject(item);
                      });
}

void LayersFrame::drawAll() {
  LayersOrder order(scene_.grid, camera_, options_.solidity, memory_.order);
  draw(scene_.grid.loose());
  std::size_t cell = 0;
  while (mayGoOn() && polygons_left_ != 0 && order.next(cell)) {
    ++cells_projected_;
    draw(scene_.grid.objects(cell));
  }
}

void LayersFrame::run(Answer& answer) {
  if (accepted_px_ > 0.0) projectAll(answer);
  if (accepted_px_ == 0.0 || budget_.stopped()) {  // all of it; once time is up, whatever it is
    answer.visible.clear();
    answer.guarantee = Guarantee::kConservative;
    answer.proven = true;
    answer.missed_px = 0.0F;
    if (!budget_.stopped()) drawAll();
    walk_.appendUnhidden(
        memory_.stack, [this] { return mayGoOn(); },
        [this](const ImageItem& item) { return hidden(item); }, stats_, in_frustum_,
        answer.visible);
    if (!budget_.stopped()) stats_.in_frustum = in_frustum_;
  }
  answer.out_of_budget = budget_.stopped();
  stats_.work = budget_.work(countedNs());
  answer.stats = stats_;
}

}  // namespace culld
