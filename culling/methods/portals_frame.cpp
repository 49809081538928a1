#include "culling/methods/portals_frame.h"

#include <algorithm>

namespace culld {
namespace {

// Nanoseconds of counted work, after those of `raster`: rough.
constexpr std::uint64_t kFrameNs = 20'000, kNodeNs = 150;

}  // namespace

PortalsFrame::PortalsFrame(const WideBvh& bvh, const SolidOccluders& solids,
                           std::uint32_t most_boxes, const Camera& camera, const Deadline& deadline,
                           const Demand& demand, PortalsMemory& memory)
    : solids_(solids),
      most_boxes_(most_boxes),
      budget_(deadline, demand.work),
      memory_(memory),
      view_(cellView(camera, gridFor(camera))),
      walk_(camera, bvh, view_),
      solid_walk_(camera, solids.drawn().bvh(), view_),
      drawing_(*solids.drawn().scene(), solids.occluders(), view_, camera.origin_world, deadline,
               memory.occluder) {
  memory_.cells.reset(view_.grid);
  memory_.queue.clear();
  memory_.chosen.clear();
  memory_.stack.clear();
}

std::uint64_t PortalsFrame::countedNs() const { return kFrameNs + kNodeNs * stats_.nodes_visited; }

/// Largest on the image first: a node is opened only while a box below it may be as large as the
/// next one.
void PortalsFrame::chooseBoxes() {
  std::vector<ImageItem>& queue = memory_.queue;
  solid_walk_.pushRoots(queue);
  std::make_heap(queue.begin(), queue.end(), smallerFirst);
  while (!queue.empty() && memory_.chosen.size() < most_boxes_ && mayGoOn()) {
    std::pop_heap(queue.begin(), queue.end(), smallerFirst);
    const ImageItem item = queue.back();
    queue.pop_back();
    if (item.ref.isObject()) {
      memory_.chosen.push_back(item);
      continue;
    }
    ++stats_.nodes_visited;
    solid_walk_.forEachChild(item, [&](const ImageItem& child, bool /*blocks*/, bool inside) {
      if (!inside || !largeEnough(child.rect)) return;
      queue.push_back(child);
      std::push_heap(queue.begin(), queue.end(), smallerFirst);
    });
  }
}

/// Front to back: what is hidden by then hides nothing more.
void PortalsFrame::drawBoxes() {
  std::sort(memory_.chosen.begin(), memory_.chosen.end(), nearerFirst);
  for (const ImageItem& item : memory_.chosen) {
    if (!mayGoOn()) return;
    if (memory_.cells.certainlyHidden(item.rect, item.nearest)) continue;
    const Instance& box = solids_.drawn().scene()->instance(item.ref.objectId());
    const DrawnOccluder drawn =
        drawing_.draw(box, item.nearest, budget_.leftNs(countedNs()), memory_.cells);
    ++stats_.occluders_drawn;
    stats_.triangles_drawn += drawn.triangles;
    budget_.drew(drawn);
  }
}

void PortalsFrame::run(Answer& answer) {
  chooseBoxes();
  drawBoxes();
  walk_.appendUnhidden(
      memory_.stack, [&] { return mayGoOn(); },
      [&](const ImageItem& item) { return memory_.cells.certainlyHidden(item.rect, item.nearest); },
      stats_, in_frustum_, answer.visible);
  answer.out_of_budget = budget_.stopped();
  if (!budget_.stopped()) stats_.in_frustum = in_frustum_;
  stats_.work = budget_.work(countedNs());
  answer.stats = stats_;
}

}  // namespace culld
