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
#include "culling/spatial/frustum_walk.h"
#include "culling/spatial/wide_bvh.h"
#include "culling/spatial/wide_bvh_fit.h"

namespace culld {

/// A node or an object that may be on the image.
struct ImageItem {
  CellRect rect;
  float nearest;  ///< no point of it is nearer
  ChildRef ref;
  PlaneMask planes;  ///< still to be tested below a node
};

/// The order in which what is nearer comes first.
inline bool nearerFirst(const ImageItem& a, const ImageItem& b) noexcept {
  if (a.nearest != b.nearest) return a.nearest > b.nearest;
  return a.ref.objectId() < b.ref.objectId();
}

/// Of a heap whose top is the largest on the image.
inline bool smallerFirst(const ImageItem& a, const ImageItem& b) noexcept {
  return a.rect.cells() < b.rect.cells();
}

/// The cells that a box of world space may be on, and how near it may be. False: it is on none.
inline bool projectBox(const BoxView& view, const glm::dvec3& eye_world, const CellGrid& grid,
                       const Box& box, CellRect& rect, float& nearest) noexcept {
  Box boxes[kWideLanes];
  boxes[0] = box;
  WideNode node = emptyNode();
  fitNode(node, boxes);
  BoxRects rects;
  projectBoxes(view, originFrom(node, eye_world), node.offsets, rects);
  if ((rects.off_grid & 1U) != 0) return false;
  rect = cellRect(rects, 0, grid);
  nearest = rects.nearest[0];
  return true;
}

/// Keeps references to all that it is given.
class ImageWalk {
 public:
  ImageWalk(const Camera& camera, const WideBvh& bvh, const CellView& view)
      : bvh_(bvh),
        frustum_(camera, bvh),
        view_(view),
        box_view_(boxView(view)),
        origin_world_(camera.origin_world) {}

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

  /// Appends the objects in the frustum that are not hidden to `visible`, and once may_go_on() is
  /// false all that is left. A hidden node ends the walk; what is below it is only counted, so that
  /// an answer can say what occlusion brought. `stats`: a CullStats; `stack`: empty, for its
  /// memory.
  template <typename Stats, typename MayGoOn, typename Hidden>
  void appendUnhidden(std::vector<ImageItem>& stack, const MayGoOn& may_go_on, const Hidden& hidden,
                      Stats& stats, std::uint32_t& in_frustum,
                      std::vector<ObjectId>& visible) const {
    pushRoots(stack);
    while (!stack.empty()) {
      const ImageItem item = stack.back();
      stack.pop_back();
      if (!may_go_on()) {
        bvh_.appendObjects(item.ref.nodeIndex(), visible);
        continue;
      }
      ++stats.nodes_visited;
      forEachChild(item, [&](const ImageItem& child, bool /*blocks*/, bool inside) {
        const bool object = child.ref.isObject();
        if (object) ++stats.tested;
        if (!inside) {
          stats.outside += object ? 1U : 0U;
        } else if (hidden(child)) {
          stats.occluded += object ? 1U : 0U;
          in_frustum +=
              object ? 1U : countInFrustum(bvh_, frustum_, child.ref.nodeIndex(), child.planes);
        } else if (object) {
          ++in_frustum;
          visible.push_back(child.ref.objectId());
        } else {
          stack.push_back(child);
        }
      });
    }
  }

  /// forEachChild() for objects that are asked for by themselves. REQUIRES: active, with a bound.
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
    BoxRects rects;
    projectBoxes(box_view_, originFrom(node, origin_world_), node.offsets, rects);
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
