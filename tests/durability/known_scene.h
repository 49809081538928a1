// What a scene must be: made here by the library from the same uploads and edits, and compared with
// what the daemon says and answers.
#pragma once
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "culling/scene/edit.h"
#include "protocol/messages.h"
#include "tests/durability/daemon.h"
#include "tests/scenes/random.h"

namespace culld::testing {

/// Triangles in a row, one per node.
std::string rowGlb(std::uint32_t objects);
/// As the daemon loads it.
SnapshotPtr loaded(const std::string& glb);

/// Edits of objects that are not removed, and what they make of the scene. `objects`: only these
/// may be chosen, and none is added or removed; empty: any. No items if only removed ones were hit.
struct KnownEdit {
  std::vector<protocol::EditItem> items;
  SnapshotPtr after;
};
KnownEdit randomEdit(scenes::Random& random, const SnapshotPtr& before,
                     std::span<const std::uint32_t> objects = {});
SnapshotPtr applied(const SnapshotPtr& before, const std::vector<protocol::EditItem>& items);

/// As GET /v1/scenes/NAME tells it.
struct ToldScene {
  int status = 0;
  std::uint64_t version = 0, objects = 0;
  std::string hash;
};
ToldScene askScene(const Daemon& daemon, const std::string& name);
/// Null stands for a scene that is not there.
bool same(const ToldScene& told, const SnapshotPtr& scene);
std::string describe(const SnapshotPtr& scene);

/// Do cameras get the answers that they get in this process?
bool answersAs(const Daemon& daemon, const std::string& name, const SnapshotPtr& scene);

}  // namespace culld::testing
