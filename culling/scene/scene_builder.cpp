#include "culling/scene/scene_builder.h"

#include <utility>

#include "culling/core/parallel.h"
#include "culling/scene/scene_hash.h"

namespace culld {

MeshId SceneBuilder::addMesh(Mesh mesh) {
  fixed_.meshes.push_back(std::move(mesh));
  return static_cast<MeshId>(fixed_.meshes.size() - 1);
}

ObjectId SceneBuilder::addInstance(MeshId mesh, const std::array<double, 12>& world_from_mesh,
                                   std::uint32_t node, std::uint32_t instance_number) {
  Instance instance;
  instance.mesh = mesh;
  instance.node = node;
  instance.instance_number = instance_number;
  place(instance, fixed_.meshes[mesh], world_from_mesh);
  if (instance.always_kept && !fixed_.meshes[mesh].unbounded && lost_++ == 0) {
    first_lost_node_ = node;
  }
  scene_->triangle_count_ += fixed_.meshes[mesh].triangles.size();
  scene_->instances_.push_back(instance);
  return static_cast<ObjectId>(scene_->instances_.size() - 1);
}

void SceneBuilder::warn(std::string line) { fixed_.warnings.push_back(std::move(line)); }

void SceneBuilder::warnOfLost() {
  if (lost_ == 0) return;
  const std::string more =
      lost_ == 1 ? "; it is" : ", nor is that of " + std::to_string(lost_ - 1) + " more; they are";
  warn("node " + std::to_string(first_lost_node_) + ": its object's place is not finite" + more +
       " always kept");
  lost_ = 0;
}

SnapshotPtr SceneBuilder::finish() {
  warnOfLost();
  SceneSnapshot& scene = *scene_;
  fixed_.meshes.shrink_to_fit();
  fixed_.warnings.shrink_to_fit();
  std::vector<std::uint64_t> mesh_hashes(fixed_.meshes.size());
  parallelFor(mesh_hashes.size(),
              [&](std::size_t i) { mesh_hashes[i] = hashMesh(fixed_.meshes[i]); });
  fixed_.meshes_hash = hashTogether(mesh_hashes);
  scene.fixed_ = std::make_shared<const SceneSnapshot::FixedParts>(std::move(fixed_));
  scene.instances_.shrinkToFit();
  scene.chunk_hashes_.resize(scene.instances_.chunkCount());
  parallelFor(scene.chunk_hashes_.size(), [&](std::size_t c) {
    scene.chunk_hashes_[c] = hashInstances(scene.instances_.chunk(c));
  });
  scene.content_hash_ = scene.combinedHash();
  SnapshotPtr done = std::move(scene_);
  scene_ = std::make_unique<SceneSnapshot>();
  fixed_ = {};
  return done;
}

}  // namespace culld
