// `cullctl edit`: objects are named as answers files name them, by glTF node, and `:` instance.
#include <atomic>
#include <charconv>
#include <cmath>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <vector>

#include "client/cli/commands.h"
#include "culld/connection.h"
#include "culld/scenes.h"

namespace culld::client {
namespace {

using protocol::EditKind;
using protocol::invalidInput;

/// What a node of the file became.
struct Named {
  std::vector<std::uint32_t> objects;  ///< one per instance
  std::vector<std::uint32_t> instances;
};
using Names = std::map<std::uint32_t, Named>;

std::optional<std::uint32_t> wholeNumber(std::string_view text) {
  std::uint32_t value = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), value);
  if (read.ec != std::errc{} || read.ptr != text.data() + text.size()) return std::nullopt;
  return value;
}

/// Splits at commas and spaces; several in a row are one.
std::vector<std::string_view> words(std::string_view text) {
  std::vector<std::string_view> found;
  while (!text.empty()) {
    const auto end = std::min(text.find_first_of(", \t\n"), text.size());
    if (end > 0) found.push_back(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return found;
}

class Edits {
 public:
  Edits(const Names& names, bool by_object) : names_(names), by_object_(by_object) {}

  /// "12,13:2"
  Result<void> ids(EditKind kind, const char* option, const std::string& text) {
    const auto found = words(text);
    if (found.empty()) return invalidInput(std::string(option) + " names no object");
    for (const std::string_view word : found) {
      const auto objects = objectsOf(option, word);
      if (!objects) return objects.error();
      for (const std::uint32_t object : objects.value()) items_.push_back({kind, object, {}});
    }
    return Done{};
  }

  /// "12=1,0,0,5, 0,1,0,0, 0,0,1,0"
  Result<void> placed(EditKind kind, const char* option, const std::string& text) {
    const auto equals = text.find('=');
    const std::string wrong = std::string(option) + " " + text + ": ";
    if (equals == std::string::npos) return invalidInput(wrong + "not ID=NUMBERS");
    const auto objects = objectsOf(option, std::string_view(text).substr(0, equals));
    if (!objects) return objects.error();
    if (objects.value().size() != 1) {
      return invalidInput(wrong + "the node has " + std::to_string(objects.value().size()) +
                          " instances; name one as NODE:INSTANCE");
    }
    EditItem item{kind, objects.value().front(), {}};
    const auto numbers = words(std::string_view(text).substr(equals + 1));
    if (numbers.size() != item.world_from_mesh.size()) {
      return invalidInput(wrong + "wants 12 numbers, not " + std::to_string(numbers.size()));
    }
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      const char* end = numbers[i].data() + numbers[i].size();
      const auto read = std::from_chars(numbers[i].data(), end, item.world_from_mesh[i]);
      if (read.ec != std::errc{} || read.ptr != end || !std::isfinite(item.world_from_mesh[i])) {
        return invalidInput(wrong + "\"" + std::string(numbers[i]) + "\" is not a finite number");
      }
    }
    items_.push_back(item);
    return Done{};
  }

  std::vector<EditItem>& items() { return items_; }

 private:
  Result<std::vector<std::uint32_t>> objectsOf(const char* option, std::string_view word) const {
    const std::string what = std::string(option) + " " + std::string(word);
    const auto colon = word.find(':');
    const auto node = wholeNumber(word.substr(0, colon));
    if (!node || (by_object_ && colon != std::string_view::npos)) {
      return invalidInput(what +
                          (by_object_ ? ": not an object id" : ": not a node, or NODE:INSTANCE"));
    }
    if (by_object_) return std::vector<std::uint32_t>{*node};
    const auto at = names_.find(*node);
    if (at == names_.end()) return invalidInput(what + ": no object of the scene is of that node");
    if (colon == std::string_view::npos) return at->second.objects;
    const auto instance = wholeNumber(word.substr(colon + 1));
    for (std::size_t i = 0; instance && i < at->second.instances.size(); ++i) {
      if (at->second.instances[i] == *instance) {
        return std::vector<std::uint32_t>{at->second.objects[i]};
      }
    }
    return invalidInput(what + ": the node has no such instance");
  }

  const Names& names_;
  const bool by_object_;
  std::vector<EditItem> items_;
};

Result<Names> namesOf(const Server& server, const std::string& scene) {
  const auto table = Scenes(server.address, server.access).objects(scene);
  if (!table) return table.error();
  Names names;
  for (std::uint32_t id = 0; id < table.value().names.size(); ++id) {
    const protocol::ObjectName& name = table.value().names[id];
    names[name.node].objects.push_back(id);
    names[name.node].instances.push_back(name.instance);
  }
  return names;
}

Result<void> collect(const EditArguments& a, Edits& edits) {
  for (const std::string& text : a.set) {
    if (auto done = edits.placed(EditKind::kMove, "--set", text); !done) return done;
  }
  for (const std::string& text : a.add) {
    if (auto done = edits.placed(EditKind::kAdd, "--add", text); !done) return done;
  }
  const std::pair<EditKind, const std::vector<std::string>*> lists[] = {
      {EditKind::kHide, &a.hide}, {EditKind::kShow, &a.show}, {EditKind::kRemove, &a.remove}};
  constexpr const char* kOptions[] = {"--hide", "--show", "--remove"};
  for (std::size_t i = 0; i < 3; ++i) {
    for (const std::string& text : *lists[i].second) {
      if (auto done = edits.ids(lists[i].first, kOptions[i], text); !done) return done;
    }
  }
  if (edits.items().empty()) {
    return invalidInput("nothing to do: give --set, --add, --hide, --show or --remove");
  }
  return Done{};
}

void print(const EditArguments& a, const EditOutcome& outcome) {
  if (a.json) {
    const nlohmann::json line{
        {"scene", a.scene}, {"version", outcome.scene_version}, {"added", outcome.added}};
    std::cout << line.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) << '\n';
    return;
  }
  std::cout << a.scene << ": version " << outcome.scene_version;
  const char* before = "; added objects ";
  for (const std::uint32_t id : outcome.added) std::cout << std::exchange(before, ", ") << id;
  std::cout << '\n';
}

}  // namespace

int runEdit(const Server& server, const EditArguments& arguments) {
  auto opened = Connection::open(server.address, arguments.scene, server.once());
  if (!opened) return fail(opened.error());
  Connection& connection = *opened.value();
  std::atomic<bool> replaced = false;
  connection.onSceneChanged(
      [&replaced](const SceneInfo&, bool other) { replaced = replaced || other; });
  // Only now: from here on the daemon tells of a scene that is replaced, and of its ids.
  Names names;
  if (!arguments.by_object) {
    auto read = namesOf(server, arguments.scene);
    if (!read) return fail(read.error());
    names = std::move(read).value();
  }
  Edits edits(names, arguments.by_object);
  if (const auto done = collect(arguments, edits); !done) return fail(done.error());
  if (replaced) return fail(kFailed, "scene " + arguments.scene + " was replaced meanwhile");
  const auto outcome = connection.edit(std::move(edits.items()), arguments.expected_version);
  const bool other_version = !outcome && connection.state() == ConnectionState::kConnected &&
                             outcome.error().code == ErrorCode::kUnavailable;
  if (other_version) return fail(kFailed, outcome.error().message);
  if (!outcome) return fail(outcome.error());
  if (replaced) return fail(kFailed, "scene " + arguments.scene + " was replaced meanwhile");
  print(arguments, outcome.value());
  return kFine;
}

}  // namespace culld::client
