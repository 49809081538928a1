#include "culling/methods/backface_clusters_frame.h"

#include <algorithm>

namespace culld {
namespace {

constexpr std::uint64_t kMostRegions = 4096;    ///< asked of an object at most: some 50 us
constexpr std::uint64_t kRegionsPerLook = 256;  ///< asked without a look at the clock

// Nanoseconds of counted work, after those of `raster`: rough.
constexpr std::uint64_t kFrameNs = 20'000, kNodeNs = 150, kEyeNs = 40, kRegionNs = 12;

}  // namespace

BackfaceClustersFrame::BackfaceClustersFrame(const BackfaceClustersScene& scene,
                                             const BackfaceClustersOptions& options,
                                             const Camera& camera, const Deadline& deadline,
                                             const Demand& demand, BackfaceClustersMemory& memory)
    : scene_(scene),
      options_(options),
      deadline_(deadline),
      budget_(deadline, demand.work),
      memory_(memory),
      view_(cellView(camera, gridFor(camera))),
      walk_(camera, scene.bvh, view_),
      eye_(volumeEye(camera)),
      triangles_left_(options.most_triangles) {
  memory_.cells.reset(view_.grid);
  memory_.stack.clear();
  memory_.occluders.clear();
}

std::uint64_t BackfaceClustersFrame::countedNs() const {
  return kFrameNs + kNodeNs * stats_.nodes_visited + kEyeNs * eyes_ + kRegionNs * regions_;
}

/// What blocks and is large enough on the image to fill a cell.
void BackfaceClustersFrame::gatherOccluders() {
  std::vector<ImageItem>& stack = memory_.stack;
  walk_.pushRoots(stack);
  while (!stack.empty() && mayGoOn()) {
    const ImageItem item = stack.back();
    stack.pop_back();
    ++stats_.nodes_visited;
    walk_.forEachChild(item, [&](const ImageItem& child, bool blocks, bool inside) {
      if (!blocks || !inside || !largeEnough(child.rect)) return;
      (child.ref.isObject() ? memory_.occluders : stack).push_back(child);
    });
  }
  stack.clear();
}

/// Front to back: what is hidden by then adds nothing.
void BackfaceClustersFrame::drawOccluders() {
  gatherOccluders();
  std::sort(memory_.occluders.begin(), memory_.occluders.end(), nearerFirst);
  for (const ImageItem& item : memory_.occluders) {
    if (!mayGoOn()) return;
    if (!memory_.cells.certainlyHidden(item.rect, item.nearest)) draw(item);
  }
}

void BackfaceClustersFrame::draw(const ImageItem& item) {
  const Instance& instance = scene_.scene.instance(item.ref.objectId());
  const Mesh& mesh = scene_.scene.mesh(instance.mesh);
  if (mesh.blocking_triangles / 2 > triangles_left_) return;  // about half of it turns away
  if (!worthDrawing(item.rect, mesh.positions.size(), mesh.blocking_triangles)) return;
  const FacingClusters& clusters = scene_.clusters[instance.mesh];
  SheetObject object =
      sheetObjectOf(scene_.scene, instance, item.nearest, SheetParts::kBlocking, memory_.surfaces);
  std::optional<MeshEye> eye;
  if (clusters.any()) {
    object.triangles = clusters.triangles();
    object.partners = clusters.partners();
    if (options_.clusters) eye = meshEye(instance.world_from_mesh, eye_);
    ++eyes_;
  }
  std::uint32_t triangles = mesh.blocking_triangles;
  if (eye) {
    memory_.surfaces.clear();
    triangles = clusters.appendFacing(mesh, *eye, options_.hierarchy, memory_.surfaces, regions_);
    object.surfaces = memory_.surfaces;
  }
  if (triangles == 0 || triangles > triangles_left_) return;  // a simpler one may still fit
  triangles_left_ -= triangles;
  const DrawnOccluder drawn =
      drawSheet(object, view_, eye_.origin_world, deadline_, memory_.sheets, memory_.cells);
  ++stats_.occluders_drawn;
  stats_.triangles_drawn += drawn.triangles;
  budget_.drew(drawn);
}

/// Can no eye of the motion bound see any of the object?
bool BackfaceClustersFrame::turnedAway(ObjectId id) {
  const Instance& instance = scene_.scene.instance(id);
  const FacingClusters& clusters = scene_.clusters[instance.mesh];
  if (!clusters.oneSided() || !mayGoOn()) return false;
  ++eyes_;
  const std::optional<MeshEye> eye = meshEye(instance.world_from_mesh, eye_);
  if (!eye) return false;
  const std::uint64_t before = regions_;
  const bool away = clusters.turnedAway(*eye, options_.hierarchy, kMostRegions, regions_);
  if (regions_ - before > kRegionsPerLook) budget_.lookNext();
  return away;
}

bool BackfaceClustersFrame::hidden(const ImageItem& item) {
  if (memory_.cells.certainlyHidden(item.rect, item.nearest)) return true;
  return options_.objects && item.ref.isObject() && turnedAway(item.ref.objectId());
}

void BackfaceClustersFrame::run(Answer& answer) {
  if (options_.occluders) drawOccluders();
  walk_.appendUnhidden(
      memory_.stack, [this] { return mayGoOn(); },
      [this](const ImageItem& item) { return hidden(item); }, stats_, in_frustum_, answer.visible);
  answer.out_of_budget = budget_.stopped();
  if (!budget_.stopped()) stats_.in_frustum = in_frustum_;
  stats_.plane_tests = regions_;
  stats_.work = budget_.work(countedNs());
  answer.stats = stats_;
}

}  // namespace culld
