// Down the hierarchy as an image sees it: each child with the rectangle of cells it may be on and
// how near it may be. For methods that decide themselves in which order to go.
#pragma once
#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "culling/raster/box_cells.h"
#include "culling/raster/box_kernels.h"
#include "culling/raster/cell_view.h"
#include "culling/spatial/frustum_test.h"
#include "culling/spatial/wide_bvh.h"
#include "culling/spatial/wide_bvh_fit.h"

namespace culld {

/// A node or an object that may be on the image.
struct ImageItem {
  CellRect rect;
  float nearest;  ///< no point of it is nearer
  ChildRef ref;
  PlaneMask planes;  ///< still to be tested below a node
  std::uint64_t area() const noexcept {
    return std::uint64_t{rect.x1 - rect.x0 + 1} * (rect.y1 - rect.y0 + 1);
  }
};

/// Keeps references to all that it is given.
class ImageWalk {
 public:
  ImageWalk(const Camera& camera, const WideBvh& bvh, const CellView& view)
      : bvh_(bvh),
        frustum_(camera, bvh),
        view_(view),
        box_view_(boxView(view)),
        origin_world_(camera.origin_world) {}

  const FrustumTest& frustum() const noexcept { return frustum_; }

  void pushRoots(std::vector<ImageItem>& items) const {
    for (auto root = static_cast<std::uint32_t>(bvh_.rootCount()); root-- > 0;) {
      items.push_back({everyCell(view_.grid), std::numeric_limits<float>::infinity(),
                       ChildRef::node(root), frustum_.planes()});
    }
  }

  /// Calls take(child, blocks, in_frustum) for each live child of a node. A child that is not in
  /// the frustum has no rectangle. REQUIRES: a node.
  template <typename Take>
  void forEachChild(const ImageItem& item, const Take& take) const {
    forEachLane(bvh_.node(item.ref.nodeIndex()), item.planes, take);
  }

  /// The same for objects that are asked for by themselves. REQUIRES: active, with a bound.
  template <typename Take>
  void forEachObject(const SceneSnapshot& scene, std::span<const ObjectId> ids,
                     const Take& take) const {
    for (std::size_t first = 0; first < ids.size(); first += kWideLanes) {
      WideNode node = emptyNode();
      for (std::size_t l = 0; l < std::min(kWideLanes, ids.size() - first); ++l) {
        node.child[l] = ChildRef::object(ids[first + l]);
      }
      fitNode(node, scene, [&](std::uint32_t) -> const WideNode& { return node; });
      forEachLane(node, frustum_.planes(), take);
    }
  }

 private:
  template <typename Take>
  void forEachLane(const WideNode& node, PlaneMask planes, const Take& take) const {
    const LaneVerdicts verdicts = frustum_.test(node, planes);
    const std::array<double, 3> origin{node.origin[0] - origin_world_.x,
                                       node.origin[1] - origin_world_.y,
                                       node.origin[2] - origin_world_.z};
    BoxRects rects;
    projectBoxes(box_view_, origin, node.offsets, rects);
    const std::uint32_t on_image = verdicts.may_intersect & ~rects.off_grid;
    for (std::uint32_t lanes = node.live; lanes != 0; lanes &= lanes - 1) {
      const auto lane = static_cast<std::size_t>(std::countr_zero(lanes));
      const bool inside = (on_image >> lane & 1U) != 0;
      ImageItem child{{}, rects.nearest[lane], node.child[lane], 0};
      if (inside) child.rect = cellRect(rects, lane, view_.grid);
      if (child.ref.isNode()) child.planes = verdicts.planesLeft(lane);
      take(child, (node.blocking >> lane & 1U) != 0, inside);
    }
  }

  const WideBvh& bvh_;
  FrustumTest frustum_;
  const CellView& view_;
  BoxView box_view_;
  glm::dvec3 origin_world_;
};

}  // namespace culld
