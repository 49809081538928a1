#include "culling/scene/gltf_loader.h"

#include <algorithm>
#include <exception>
#include <mutex>
#include <new>
#include <optional>
#include <vector>

#include "culling/core/parallel.h"
#include "culling/scene/gltf_container.h"
#include "culling/scene/gltf_data.h"
#include "culling/scene/gltf_meshes.h"
#include "culling/scene/gltf_nodes.h"
#include "culling/scene/scene_builder.h"

namespace culld {
namespace {

using namespace gltf;  // NOLINT: this file is the door of that namespace

/// Parsed JSON and the structs made of it take at most about this much per byte of text.
constexpr std::uint64_t kBytesPerJsonByte = 80;

/// Tells the caller how far loading is. THREADS: any.
class Progress {
 public:
  Progress(const LoadOptions& options, std::size_t total) : options_(options), total_(total) {}
  void step() {
    if (!options_.progress) return;
    const std::lock_guard lock(mutex_);
    options_.progress(++done_, total_);
  }

 private:
  const LoadOptions& options_;
  std::size_t total_;
  std::size_t done_ = 0;
  std::mutex mutex_;
};

struct Plan {
  std::vector<PlacedNode> placed;
  std::vector<std::uint32_t> meshes;     ///< those used, ascending
  std::vector<std::uint32_t> accessors;  ///< those used
};

std::uint64_t instancesOf(const Document& document, const Node& node) {
  return node.instancing == kNone ? 1 : document.instancings[node.instancing].count;
}

void checkObjectCount(const Document& document, const std::vector<PlacedNode>& placed,
                      std::uint64_t limit) {
  std::uint64_t objects = 0;
  for (const PlacedNode& p : placed) {
    const std::uint64_t more = instancesOf(document, document.nodes[p.node]);
    if (more > limit || objects > limit - more) {
      fail(ErrorCode::kLimit,
           Place{"node", p.node}.text() + ": more than " + std::to_string(limit) + " objects");
    }
    objects += more;
  }
}

Plan makePlan(const Document& document, const LoadLimits& limits) {
  Plan plan;
  plan.placed = placeNodes(document);
  checkObjectCount(document, plan.placed, std::min<std::uint64_t>(limits.max_objects, kNone));
  std::vector<bool> used(document.meshes.size());
  for (const PlacedNode& p : plan.placed) {
    const Node& node = document.nodes[p.node];
    used[node.mesh] = true;
    if (node.instancing == kNone) continue;
    const Instancing& instancing = document.instancings[node.instancing];
    for (const std::uint32_t a : {instancing.translation, instancing.rotation, instancing.scale}) {
      if (a != kNone) plan.accessors.push_back(a);
    }
  }
  for (std::uint32_t m = 0; m < used.size(); ++m) {
    if (!used[m]) continue;
    plan.meshes.push_back(m);
    const std::vector<std::uint32_t> more = accessorsOf(document.meshes[m]);
    plan.accessors.insert(plan.accessors.end(), more.begin(), more.end());
  }
  return plan;
}

std::vector<Mesh> decodeMeshes(const DataSource& data, const std::vector<std::uint32_t>& used,
                               const LoadOptions& options, Budget& budget, Progress& progress) {
  std::vector<Mesh> meshes(used.size());
  std::vector<std::exception_ptr> failures(used.size());
  parallelFor(
      used.size(),
      [&](std::size_t i) {
        try {
          meshes[i] = decodeMesh(data, used[i], budget);
        } catch (...) {
          failures[i] = std::current_exception();
        }
        progress.step();
      },
      options.threads);
  for (const std::exception_ptr& failure : failures) {
    if (failure) std::rethrow_exception(failure);  // the first mesh's, whichever came first
  }
  return meshes;
}

/// Gives meshes to the builder as nodes ask for them.
class MeshTable {
 public:
  MeshTable(const Document& document, const Plan& plan, std::vector<Mesh> meshes,
            SceneBuilder& builder)
      : builder_(builder),
        document_(document),
        meshes_(document.meshes.size()),
        ids_(2 * document.meshes.size(), kNone),
        wanted_(2 * document.meshes.size()) {
    for (const PlacedNode& p : plan.placed) wanted_[slotOf(document, p)] = true;
    for (std::size_t i = 0; i < meshes.size(); ++i) meshes_[plan.meshes[i]] = std::move(meshes[i]);
  }

  MeshId idFor(const PlacedNode& placed) {
    const std::size_t slot = slotOf(document_, placed);
    if (ids_[slot] == kNone) ids_[slot] = builder_.addMesh(take(slot));
    return ids_[slot];
  }

 private:
  /// A mesh that restless nodes use is another one than the same mesh standing still.
  static std::size_t slotOf(const Document& document, const PlacedNode& placed) {
    return 2 * std::size_t{document.nodes[placed.node].mesh} + (placed.restless ? 1 : 0);
  }

  Mesh take(std::size_t slot) {
    const std::size_t number = slot / 2;
    const bool restless = slot % 2 != 0;
    const bool other_wants_it = wanted_[slot ^ 1U] && ids_[slot ^ 1U] == kNone;
    Mesh mesh = other_wants_it ? meshes_[number] : std::move(meshes_[number]);
    if (mesh.non_finite_vertices > 0 && !restless) {
      builder_.warn(Place{"mesh", number}.text() + ": " + std::to_string(mesh.non_finite_vertices) +
                    " non-finite vertices; its objects are always kept");
    }
    mesh.unbounded = mesh.unbounded || restless;
    return mesh;
  }

  SceneBuilder& builder_;
  const Document& document_;
  std::vector<Mesh> meshes_;
  std::vector<std::uint32_t> ids_;
  std::vector<bool> wanted_;
};

/// One attribute of EXT_mesh_gpu_instancing; `otherwise` where it is not given.
template <std::size_t N>
class InstanceAttribute {
 public:
  InstanceAttribute(const DataSource& data, std::uint32_t accessor, const char* name,
                    const std::array<double, N>& otherwise, const Place& place, Budget& budget)
      : otherwise_(otherwise) {
    if (accessor == kNone) return;
    reader_.emplace(data, accessor, budget);
    if (reader_->width() != N || reader_->component() == Component::kUint32) {
      fail(place, std::string("accessor ") + std::to_string(accessor) + " holds no " + name);
    }
  }
  std::array<double, N> at(std::uint64_t i) const {
    if (!reader_) return otherwise_;
    std::array<double, N> value{};
    for (std::size_t part = 0; part < N; ++part) value[part] = double{reader_->floatAt(i, part)};
    return value;
  }

 private:
  std::array<double, N> otherwise_;
  std::optional<ElementReader> reader_;
};

void addInstances(const DataSource& data, const PlacedNode& placed, MeshId mesh, Budget& budget,
                  SceneBuilder& builder) {
  const Document& document = data.document();
  const Instancing& given = document.instancings[document.nodes[placed.node].instancing];
  const Place place{"node", placed.node};
  const InstanceAttribute<3> translation(data, given.translation, "TRANSLATION", {0, 0, 0}, place,
                                         budget);
  const InstanceAttribute<4> rotation(data, given.rotation, "ROTATION", {0, 0, 0, 1}, place,
                                      budget);
  const InstanceAttribute<3> scale(data, given.scale, "SCALE", {1, 1, 1}, place, budget);
  for (std::uint64_t i = 0; i < given.count; ++i) {
    const Affine node_from_mesh = composeTrs(translation.at(i), rotation.at(i), scale.at(i));
    builder.addInstance(mesh, multiply(placed.world_from_node, node_from_mesh), placed.node,
                        static_cast<std::uint32_t>(i));
  }
}

SnapshotPtr importScene(std::span<const std::byte> bytes, const std::optional<std::string>& folder,
                        const LoadOptions& options) {
  const LoadLimits& limits = options.limits;
  const Container container = openContainer(bytes);
  Budget budget(limits);
  budget.takeBytes(kBytesPerJsonByte * container.json.size());
  const Document document = readDocument(JsonDocument(container.json).root());
  const Plan plan = makePlan(document, limits);

  Progress progress(options, plan.meshes.size() + 2);
  DataSource data(document, container, folder, limits.max_file_bytes - bytes.size());
  data.prepare(plan.accessors, budget, options.threads);
  progress.step();

  SceneBuilder builder;
  MeshTable meshes(document, plan, decodeMeshes(data, plan.meshes, options, budget, progress),
                   builder);
  for (const PlacedNode& placed : plan.placed) {
    const Node& node = document.nodes[placed.node];
    const MeshId mesh = meshes.idFor(placed);
    if (node.instancing == kNone) {
      builder.addInstance(mesh, placed.world_from_node, placed.node);
    } else {
      addInstances(data, placed, mesh, budget, builder);
    }
  }
  SnapshotPtr scene = builder.finish();
  progress.step();
  return scene;
}

/// Runs `load`, which may throw; what it throws becomes "NAME: PLACE: what".
template <typename Load>
Result<SnapshotPtr> guarded(const std::string& name, const Load& load) {
  const std::string prefix = shown(name) + ": ";
  try {
    return load();
  } catch (const LoadFailure& failure) {
    return Error{failure.error().code, prefix + failure.error().message};
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::kLimit, prefix + "scene: more memory than there is"};
  } catch (const std::exception& e) {
    return Error{ErrorCode::kInvalidInput, prefix + "scene: " + shown(e.what())};
  }
}

}  // namespace

Result<SnapshotPtr> loadGltfBytes(std::span<const std::byte> bytes, const std::string& name,
                                  const LoadOptions& options) {
  return guarded(name, [&] {
    if (bytes.size() > options.limits.max_file_bytes) {
      fail(ErrorCode::kLimit, "file: " + std::to_string(bytes.size()) + " bytes > limit of " +
                                  std::to_string(options.limits.max_file_bytes));
    }
    return importScene(bytes, std::nullopt, options);
  });
}

Result<SnapshotPtr> loadGltfFile(const std::string& path, const LoadOptions& options) {
  return guarded(path, [&] {
    const OwnedBytes bytes = [&] {
      try {
        return readRegularFile(path, 0, options.limits.max_file_bytes);
      } catch (const LoadFailure& failure) {
        fail(failure.error().code, "file: " + failure.error().message);
      }
    }();
    const auto slash = path.rfind('/');
    const std::string folder = slash == path.npos ? "" : path.substr(0, slash + 1);
    return importScene(bytes.span(), folder, options);
  });
}

}  // namespace culld
