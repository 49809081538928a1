#include "tests/durability/known_scene.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "culling/methods/frustum.h"
#include "culling/scene/gltf_loader.h"
#include "protocol/id_set.h"
#include "server/disk.h"
#include "server/translate.h"
#include "tests/scenes/row_glb.h"

namespace culld::testing {

using protocol::EditItem;
using protocol::EditKind;

std::string rowGlb(std::uint32_t objects) {
  const auto bytes = scenes::rowGlb(objects);
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

SnapshotPtr loaded(const std::string& glb) {
  auto scene = loadGltfBytes(std::as_bytes(std::span(glb.data(), glb.size())), "row", {});
  return scene ? std::move(scene).value() : nullptr;
}

SnapshotPtr applied(const SnapshotPtr& before, const std::vector<EditItem>& items) {
  auto edited = applyEdits(before, server::toEngine(items));
  return edited ? edited.value().snapshot : nullptr;
}

KnownEdit randomEdit(scenes::Random& random, const SnapshotPtr& before,
                     std::span<const std::uint32_t> objects) {
  KnownEdit edit;
  edit.after = before;
  const std::uint32_t count = 1 + random.below(8);
  for (std::uint32_t i = 0; i < count; ++i) {
    EditItem item;
    const auto all = static_cast<std::uint32_t>(edit.after->objectCount());
    item.object = objects.empty()
                      ? random.below(all)
                      : objects[random.below(static_cast<std::uint32_t>(objects.size()))];
    if (edit.after->instance(item.object).removed) continue;
    // More are added than removed: a scene is to last.
    item.kind = static_cast<EditKind>(std::min(random.below(objects.empty() ? 6 : 3), 4U));
    const double x = random.uniform(0, 50);
    item.world_from_mesh = {1, 0, 0, x, 0, 1, 0, random.unit(), 0, 0, 1, 0};
    edit.items.push_back(item);
    edit.after = applied(edit.after, {item});
  }
  // One version, not one for each item.
  if (!edit.items.empty()) edit.after = applied(before, edit.items);
  return edit;
}

ToldScene askScene(const Daemon& daemon, const std::string& name) {
  const HttpAnswer answer = daemon.ask("GET", "/v1/scenes/" + name);
  ToldScene told;
  told.status = answer.status;
  if (answer.status != 200) return told;
  const auto json = nlohmann::json::parse(answer.body, nullptr, false);
  told.version = json.value("version", std::uint64_t{0});
  told.objects = json.value("objects", std::uint64_t{0});
  told.hash = json.value("hash", "");
  return told;
}

bool same(const ToldScene& told, const SnapshotPtr& scene) {
  if (scene == nullptr) return told.status == 404;
  return told.status == 200 && told.version == scene->version() &&
         told.objects == scene->objectCount() && told.hash == server::hex16(scene->contentHash());
}

std::string describe(const SnapshotPtr& scene) {
  if (scene == nullptr) return "none";
  return "version " + std::to_string(scene->version()) + ", " +
         std::to_string(scene->objectCount()) + " objects, " + server::hex16(scene->contentHash());
}

bool answersAs(const Daemon& daemon, const std::string& name, const SnapshotPtr& scene) {
  const auto culler = frustumMethod().prepare(scene);
  LiveClient client(daemon.connect(), name);
  if (!culler || client.upgradeStatus() != 101 || !client.hello()) return false;
  if (!client.openView(1, "frustum")) return false;
  for (const double x : {0.0, 17.0, 40.0}) {
    protocol::LookAt look;
    look.eye = {x, 0, 5};
    look.target = {x, 0, 0};
    protocol::CameraUpdate update;
    update.view = 1;
    update.camera.pose = look;
    client.send(update, 5);
    const auto answer = client.await<protocol::Answer>();
    const auto camera = server::toEngine(update.camera);
    if (!answer || !camera) return false;
    ViewState state;
    const auto mine = culler.value()->cull(camera.value(), {}, state);
    const auto set =
        protocol::decodeSet(answer->encoding, answer->payload, answer->scene_objects, {});
    if (!set || set.value() != mine.visible) return false;
    if (answer->scene_version != scene->version()) return false;
  }
  return true;
}

}  // namespace culld::testing
