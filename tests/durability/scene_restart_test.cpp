// Scenes with their edits across restarts, replacements, removals and damage, in one process.
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "server/scene_seal.h"
#include "server/scene_store.h"
#include "tests/scenes/row_glb.h"
#include "tests/unit/server/fake_method.h"

namespace culld::server {
namespace {

namespace fs = std::filesystem;

class SceneRestartTest : public ::testing::Test {
 protected:
  SceneRestartTest() {
    fs::remove_all(folder);
    fs::create_directories(folder);
    open();
  }
  ~SceneRestartTest() override {
    store.reset();
    fs::remove_all(folder);
  }

  std::vector<std::string> open(const std::set<std::string>& given = {}) {
    store.reset();
    auto files = SceneFiles::open(data());
    EXPECT_TRUE(files.ok());
    auto edits = EditFolder::open(data() / "edits", files.value()->serials());
    EXPECT_TRUE(edits.ok());
    store = std::make_unique<SceneStore>(std::move(files).value(), std::move(edits).value(),
                                         Methods(table), 10, LoadOptions{});
    auto lines = store->loadAll(given);
    EXPECT_TRUE(lines.ok());
    return lines.value();
  }
  fs::path data() const { return folder / "data"; }
  void put(const std::string& name, std::uint32_t objects) {
    auto upload = store->beginUpload();
    ASSERT_TRUE(upload.ok());
    ASSERT_TRUE(upload.value().append(scenes::rowGlb(objects)).ok());
    const auto done = store->finishUpload(name, std::move(upload).value());
    ASSERT_TRUE(done.ok()) << done.error().message;
  }
  void edit(const std::string& name, std::vector<Edit> edits) {
    const auto done = editScene(*store->find(name), std::move(edits));
    ASSERT_TRUE(done.ok()) << done.error().message;
  }
  std::uint64_t version(const std::string& name) const {
    const auto scene = store->find(name);
    return scene == nullptr ? 0 : scene->current()->snapshot()->version();
  }
  std::string glbFile(std::uint32_t objects) const {
    const auto bytes = scenes::rowGlb(objects);
    const fs::path path = folder / "given.glb";
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
    return path.string();
  }
  std::vector<std::string> filesIn(const char* part) const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(data() / part)) {
      names.push_back(entry.path().filename().string());
    }
    return names;
  }

  const fs::path folder =
      fs::path(::testing::TempDir()) / ("culld_restart_" + std::to_string(::getpid()));
  FakeMethod fake;
  const Method* table[1] = {&fake};
  std::unique_ptr<SceneStore> store;
};

TEST_F(SceneRestartTest, EditsAreThereAfterARestart) {
  put("s", 5);
  edit("s", {HideObject{1}, AddInstance{2, {1, 0, 0, 9, 0, 1, 0, 0, 0, 0, 1, 0}}});
  edit("s", {RemoveObject{5}});
  const auto hash = store->find("s")->current()->snapshot()->contentHash();
  EXPECT_TRUE(open().empty());
  EXPECT_EQ(version("s"), 3U);
  EXPECT_EQ(store->find("s")->current()->snapshot()->contentHash(), hash);
  EXPECT_EQ(store->find("s")->current()->snapshot()->objectCount(), 6U);
}

TEST_F(SceneRestartTest, RequestsKeptTogetherSucceedAndFailEachForItself) {
  put("s", 5);
  const std::vector<EditRequest> requests{
      {{HideObject{1}}, 1}, {{HideObject{99}}, 0}, {{HideObject{2}}, 1}, {{RemoveObject{3}}, 2}};
  const auto outcomes = store->find("s")->edit(requests);
  ASSERT_EQ(outcomes.size(), 4U);
  ASSERT_TRUE(outcomes[0].ok());
  EXPECT_EQ(outcomes[0].value().version, 2U);
  EXPECT_EQ(outcomes[1].error().code, ErrorCode::kInvalidInput);
  EXPECT_EQ(outcomes[2].error().code, ErrorCode::kUnavailable) << "the first made it version 2";
  ASSERT_TRUE(outcomes[3].ok());
  EXPECT_EQ(outcomes[3].value().version, 3U);
  open();
  EXPECT_EQ(version("s"), 3U);
  const SnapshotPtr scene = store->find("s")->current()->snapshot();
  EXPECT_TRUE(scene->instance(1).hidden);
  EXPECT_FALSE(scene->instance(2).hidden);
  EXPECT_TRUE(scene->instance(3).removed);
}

TEST_F(SceneRestartTest, AReplacedSceneTakesItsEditsWithIt) {
  put("s", 5);
  edit("s", {HideObject{1}});
  put("s", 5);
  EXPECT_EQ(version("s"), 1U);
  EXPECT_TRUE(filesIn("edits").empty());
  EXPECT_TRUE(open().empty());
  EXPECT_EQ(version("s"), 1U) << "the same bytes again are another upload";
  edit("s", {HideObject{2}});
  open();
  EXPECT_EQ(version("s"), 2U);
}

TEST_F(SceneRestartTest, ARemovedSceneTakesItsEditsWithItAndTakesNoMore) {
  put("s", 5);
  edit("s", {HideObject{1}});
  const auto scene = store->find("s");
  ASSERT_TRUE(store->remove("s").ok());
  EXPECT_FALSE(editScene(*scene, {HideObject{2}}).ok());
  EXPECT_TRUE(filesIn("edits").empty());
  EXPECT_TRUE(filesIn("scenes").empty());
  EXPECT_TRUE(filesIn("uploads").empty());
  put("s", 5);
  open();
  EXPECT_EQ(version("s"), 1U);
}

TEST_F(SceneRestartTest, AProcessThatEndsBetweenReplacingAndSweepingLeavesNoOldEdits) {
  put("s", 5);
  edit("s", {HideObject{1}});
  const std::string old_edits = filesIn("edits").front();
  const std::string old_file = filesIn("scenes").front();
  fs::copy(data(), folder / "before", fs::copy_options::recursive);
  put("s", 6);
  // The new file is in place; the old one and its edits are still there.
  store.reset();
  fs::copy(folder / "before" / "edits" / old_edits, data() / "edits" / old_edits,
           fs::copy_options::recursive);
  fs::copy(folder / "before" / "scenes" / old_file, data() / "scenes" / old_file);
  EXPECT_TRUE(open().empty());
  EXPECT_EQ(version("s"), 1U);
  EXPECT_EQ(store->find("s")->current()->snapshot()->objectCount(), 6U);
  EXPECT_TRUE(filesIn("edits").empty());
  EXPECT_EQ(filesIn("scenes").size(), 1U);
}

TEST_F(SceneRestartTest, EditsOfAGivenFileLastAsLongAsItsContent) {
  ASSERT_EQ(store->addFile("g", glbFile(5)).value(), std::nullopt);
  edit("g", {HideObject{1}});
  open({"g"});
  ASSERT_EQ(store->addFile("g", glbFile(5)).value(), std::nullopt);
  EXPECT_EQ(version("g"), 2U);
  open({"g"});
  ASSERT_EQ(store->addFile("g", glbFile(6)).value(), std::nullopt);
  EXPECT_EQ(version("g"), 1U);
  open({"g"});
  ASSERT_EQ(store->addFile("g", glbFile(5)).value(), std::nullopt);
  EXPECT_EQ(version("g"), 1U) << "edits of an older content come back";
}

TEST_F(SceneRestartTest, AGivenFileShadowsAStoredSceneAndLeavesItsEditsAlone) {
  put("s", 5);
  edit("s", {HideObject{1}});
  open({"s"});
  ASSERT_EQ(store->addFile("s", glbFile(7)).value(), std::nullopt);
  EXPECT_EQ(store->find("s")->current()->snapshot()->objectCount(), 7U);
  open();
  EXPECT_EQ(version("s"), 2U);
  EXPECT_EQ(store->find("s")->current()->snapshot()->objectCount(), 5U);
}

TEST_F(SceneRestartTest, NoNameOfASceneLooksLikeAnUnfinishedStore) {
  for (const char* name : {"tmp", "uploads", "lock", "edits"}) {
    put(name, 5);
    edit(name, {HideObject{1}});
  }
  EXPECT_TRUE(open().empty());
  for (const char* name : {"tmp", "uploads", "lock", "edits"}) EXPECT_EQ(version(name), 2U) << name;
}

TEST_F(SceneRestartTest, DamagedEditsKeepTheirSceneFromBeingServedAndNoOther) {
  put("bad", 5);
  put("fine", 5);
  edit("bad", {HideObject{1}});
  edit("fine", {HideObject{1}});
  store.reset();
  for (const std::string& entry : filesIn("edits")) {
    if (entry.starts_with("bad~")) fs::resize_file(data() / "edits" / entry / "edits.db", 5000);
  }
  const auto lines = open();
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_NE(lines[0].find("stored scene \"bad\" is not served"), std::string::npos) << lines[0];
  EXPECT_EQ(store->find("bad"), nullptr);
  EXPECT_EQ(store->damaged(), std::set<std::string>{"bad"});
  EXPECT_EQ(version("fine"), 2U);
  EXPECT_EQ(filesIn("edits").size(), 2U) << "what is damaged is not deleted";
  put("bad", 6);
  EXPECT_TRUE(store->damaged().empty());
  EXPECT_TRUE(open().empty());
  EXPECT_EQ(version("bad"), 1U);
}

TEST_F(SceneRestartTest, ADamagedSceneCanBeRemoved) {
  put("bad", 5);
  edit("bad", {HideObject{1}});
  store.reset();
  fs::resize_file(data() / "scenes" / filesIn("scenes").front(), 100);
  EXPECT_EQ(open().size(), 1U);
  EXPECT_EQ(filesIn("edits").size(), 1U) << "its edits stay as long as it does";
  ASSERT_TRUE(store->remove("bad").ok());
  EXPECT_TRUE(open().empty());
  EXPECT_TRUE(filesIn("scenes").empty());
  EXPECT_TRUE(filesIn("edits").empty());
}

TEST_F(SceneRestartTest, ForeignFilesAreNamedAndLeftAlone) {
  std::ofstream(data() / "scenes" / "old.scene") << "glTF";
  std::ofstream(data() / "scenes" / "notes.txt") << "hello";
  const auto lines = open();
  ASSERT_EQ(lines.size(), 2U);
  EXPECT_NE(lines[0].find("notes.txt"), std::string::npos);
  EXPECT_EQ(filesIn("scenes").size(), 2U);
}

}  // namespace
}  // namespace culld::server
