// The table of all methods. Explicit: a static library drops objects that register themselves.
// `auto` comes last: it chooses among the others.
#include "culling/culler.h"
#include "culling/methods/backface_clusters.h"
#include "culling/methods/frustum.h"
#include "culling/methods/gpu_depth_pyramid.h"
#include "culling/methods/horizon.h"
#include "culling/methods/item_buffer.h"
#include "culling/methods/layers.h"
#include "culling/methods/occluder_volumes.h"
#include "culling/methods/occlusion_map.h"
#include "culling/methods/polygon_tiling.h"
#include "culling/methods/portals.h"
#include "culling/methods/raster.h"
#include "culling/methods/z_pyramid.h"
#include "culling/planner/auto_method.h"

namespace culld {

std::span<const Method* const> allMethods() noexcept {
  static const Method* const volumes[] = {&occluderVolumesMethod()};
  static ConfiguredMethods configured(volumes);
  // Hulls are most of what volumes cost to prepare, and seldom what hides.
  static const Method* const stages[] = {&frustumMethod(), &rasterMethod(), &horizonMethod(),
                                         &portalsMethod(),
                                         configured.find("occluder-volumes:hulls=off").value()};
  static const AutoMethod automatic(stages);
  static const Method* const methods[] = {
      stages[0],
      stages[1],
      &occluderVolumesMethod(),
      &occlusionMapMethod(),
      &zPyramidMethod(),
      &polygonTilingMethod(),
      &layersMethod(),
      &horizonMethod(),
      &backfaceClustersMethod(),
      &gpuDepthPyramidMethod(),
      &itemBufferMethod(),
      &portalsMethod(),
      &automatic,
  };
  return methods;
}

const Method* findMethod(std::string_view name) noexcept { return findMethod(allMethods(), name); }

}  // namespace culld
