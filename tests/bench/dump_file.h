// Benchmark dumps: occluder meshes, boxes to be culled and cameras in one flat file, and beside it
// which boxes samples of the image saw. Little endian, tightly packed; the layouts are in
// docs/bench.md.
#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "culling/core/result.h"

namespace culld::bench {

struct DumpMesh {
  std::uint32_t first_index, index_count, first_vertex, vertex_count;
  std::array<float, 3> box_min, box_max;
};

struct DumpBox {
  std::array<float, 3> min, max;
};

/// Matrices column-major, OpenGL clip space.
struct DumpCamera {
  std::array<float, 16> view, projection, view_projection;
  std::array<float, 3> eye;
  float near_m, far_m, yfov_rad, aspect, padding;
};

/// World space, metres.
struct Dump {
  std::vector<std::array<float, 3>> vertices;
  std::vector<std::uint32_t> indices;  ///< of all vertices; triangles, CCW seen from outside
  std::vector<DumpMesh> meshes;        ///< one occluder each
  std::vector<DumpBox> objects;
  std::vector<DumpCamera> cameras;
};

/// What a camera saw at some samples of its image.
struct TruthFrame {
  std::uint32_t camera = 0;
  std::uint32_t objects_in_frustum = 0;
  std::vector<std::array<std::uint32_t, 2>> seen;  ///< object, samples
};

struct Truth {
  std::uint32_t width = 0, height = 0;  ///< samples
  std::vector<TruthFrame> frames;
};

/// ERROR: names the file and what is wrong: unreadable, not a dump, cut short, too long, an index
/// out of range.
Result<Dump> readDump(const std::string& file);
/// ERROR: as readDump; a camera or an object that `dump` does not have.
Result<Truth> readTruth(const std::string& file, const Dump& dump);

void writeDump(const std::string& file, const Dump& dump);
void writeTruth(const std::string& file, const Truth& truth);

}  // namespace culld::bench
