// Edits: each makes a new snapshot that shares all that did not change. Readers never wait.
#pragma once
#include <array>
#include <span>
#include <variant>
#include <vector>

#include "culling/core/result.h"
#include "culling/scene/scene_snapshot.h"

namespace culld {

struct MoveObject {
  ObjectId object = 0;
  std::array<double, 12> world_from_mesh{};  ///< rows; replaces the transform
};
struct HideObject {
  ObjectId object = 0;
};
struct ShowObject {
  ObjectId object = 0;
};
struct RemoveObject {
  ObjectId object = 0;
};
/// A further instance of the mesh of `like`; its id is the next free one. It carries the node of
/// `like`, with its own id as instance number: no loaded instance of that node has one that large.
struct AddInstance {
  ObjectId like = 0;
  std::array<double, 12> world_from_mesh{};
};

using Edit = std::variant<MoveObject, HideObject, ShowObject, RemoveObject, AddInstance>;

struct EditedScene {
  SnapshotPtr snapshot;
  std::vector<ObjectId> changed;  ///< ascending, unique; added objects too
};

/// All edits or none. ERROR: kInvalidInput naming the edit: unknown or removed object, transform
/// not finite. COST: O(edits * chunk) plus one pointer per chunk of the scene.
Result<EditedScene> applyEdits(const SnapshotPtr& scene, std::span<const Edit> edits);

/// applyEdits() for edits that were made before and are brought back: the scene gets the version
/// that it had then.
Result<EditedScene> restoreEdits(const SnapshotPtr& scene, std::span<const Edit> edits,
                                 std::uint64_t version);

}  // namespace culld
