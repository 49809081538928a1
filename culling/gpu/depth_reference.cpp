#include "culling/gpu/depth_reference.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "culling/raster/box_cells.h"

namespace culld::gpu {
namespace {

float valueAt(const OutlineLine& line, float i, float j) {
  return line.a * i + (line.c + line.b * j);
}

}  // namespace

void DepthReference::begin(const CellGrid& grid) {
  grid_ = grid;
  layout_ = pyramidLayout(grid);
  cells_.assign(layout_.words, 0.0F);
}

void DepthReference::draw(const OutlineBatch& batch) {
  for (const OutlineHead& head : batch.heads) {
    for (std::uint32_t y = head.y0; y < head.y1; ++y) {
      for (std::uint32_t x = head.x0; x < head.x1; ++x) raise(batch, head, x, y);
    }
  }
}

void DepthReference::raise(const OutlineBatch& batch, const OutlineHead& head, std::uint32_t x,
                           std::uint32_t y) {
  const auto i = static_cast<float>(x), j = static_cast<float>(y);
  const OutlineLine* line = batch.lines.data() + head.first_line;
  for (std::uint32_t s = 0; s < head.sides; ++s, ++line) {
    if (!(valueAt(*line, i, j) > line->least)) return;
  }
  float nearness = head.floor;
  if (head.planes > 0) {
    float least = 3.0e38F;
    for (std::uint32_t p = 0; p < head.planes; ++p, ++line) {
      const float value = valueAt(*line, i, j);
      if (!(value >= least)) least = value;
    }
    nearness = std::max(nearness, least);
  }
  if (!(nearness >= std::numeric_limits<float>::min())) return;  // denormals may count as 0
  float& cell = cells_[std::size_t{y} * layout_.width[0] + x];
  if (nearness > cell) cell = nearness;
}

void DepthReference::buildPyramid() {
  std::uint32_t across = grid_.width, down = grid_.height;
  for (std::uint32_t k = 1; k < layout_.levels; ++k) {
    for (std::uint32_t y = 0; y < layout_.height[k]; ++y) {
      for (std::uint32_t x = 0; x < layout_.width[k]; ++x) {
        float least = std::numeric_limits<float>::infinity();
        bool counts = false;
        for (std::uint32_t part = 0; part < 4; ++part) {
          const std::uint32_t fx = 2 * x + part % 2, fy = 2 * y + part / 2;
          if (fx >= across || fy >= down) continue;
          counts = true;
          least = std::min(least, cells_[layout_.first[k - 1] + fy * layout_.width[k - 1] + fx]);
        }
        cells_[layout_.first[k] + y * layout_.width[k] + x] =
            counts ? least : std::numeric_limits<float>::quiet_NaN();
      }
    }
    across = (across + 1) / 2;
    down = (down + 1) / 2;
  }
}

bool DepthReference::hides(std::uint32_t level, const CellRect& rect, float nearest) const {
  for (std::uint32_t y = rect.y0 >> level; y <= rect.y1 >> level; ++y) {
    for (std::uint32_t x = rect.x0 >> level; x <= rect.x1 >> level; ++x) {
      if (!(cells_[layout_.first[level] + y * layout_.width[level] + x] > nearest)) return false;
    }
  }
  return true;
}

void DepthReference::test(const BoxView& view, std::span<const BoxGroup> groups,
                          std::span<const GroupQuery> queries, std::uint32_t refine,
                          std::vector<std::uint32_t>& hidden) const {
  hidden.assign((queries.size() + DepthPass::kQueriesPerWord - 1) / DepthPass::kQueriesPerWord, 0);
  for (std::size_t q = 0; q < queries.size(); ++q) {
    const GroupQuery& query = queries[q];
    const auto offsets = reinterpret_cast<BoxOffsets>(groups[query.group].data());  // rows of eight
    BoxRects rects;
    projectBoxesReference(view, {query.origin[0], query.origin[1], query.origin[2]}, offsets,
                          rects);
    for (std::uint32_t lane = 0; lane < kBoxLanes; ++lane) {
      if ((query.lanes >> lane & 1U) == 0 || !std::isfinite(rects.nearest[lane])) continue;
      const CellRect rect = cellRect(rects, lane, grid_);
      std::uint32_t k = 0;
      while (k + 1 < layout_.levels &&
             ((rect.x1 >> k) - (rect.x0 >> k) > 1 || (rect.y1 >> k) - (rect.y0 >> k) > 1)) {
        ++k;
      }
      for (std::uint32_t finer = 0; finer <= std::min(refine, k); ++finer) {
        if (!hides(k - finer, rect, rects.nearest[lane])) continue;
        hidden[q / DepthPass::kQueriesPerWord] |= 1U
                                                  << (8 * (q % DepthPass::kQueriesPerWord) + lane);
        break;
      }
    }
  }
}

}  // namespace culld::gpu
