// The edit store by itself: what is loaded is what was committed, and damage is found.
#include "server/edit_store.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <random>

#include "tests/scenes/row_of_objects.h"

namespace culld::server {
namespace {

namespace fs = std::filesystem;

std::array<double, 12> at(double x, double y = 0) { return {1, 0, 0, x, 0, 1, 0, y, 0, 0, 1, 0}; }

class EditStoreTest : public ::testing::Test {
 protected:
  EditStoreTest() {
    fs::remove_all(folder);
    reopenFolder();
    reopen();
  }
  ~EditStoreTest() override {
    store.reset();
    fs::remove_all(folder);
  }

  void reopenFolder() {
    auto opened = EditFolder::open(folder, serials);
    ASSERT_TRUE(opened.ok()) << opened.error().message;
    edits = std::move(opened).value();
  }
  void reopen() { store = edits->storeOf("s", keyOfUpload(7)); }
  /// As after kill -9: nothing of the old store runs its end.
  void crash() {
    const fs::path copy = folder.string() + ".copy";
    fs::remove_all(copy);
    fs::copy(folder, copy, fs::copy_options::recursive);
    store.reset();
    fs::remove_all(folder);
    fs::rename(copy, folder);
    reopenFolder();
    reopen();
  }
  Result<void> apply(std::vector<Edit> more) {
    auto edited = applyEdits(now, more);
    EXPECT_TRUE(edited.ok()) << edited.error().message;
    auto kept = store->commit(*now, *edited.value().snapshot, more);
    if (kept) now = edited.value().snapshot;
    return kept;
  }
  void expectLoaded() {
    auto loaded = store->load(base);
    ASSERT_TRUE(loaded.ok()) << loaded.error().message;
    ASSERT_TRUE(loaded.value().has_value());
    expectSame(*loaded.value()->snapshot);
  }
  void expectSame(const SceneSnapshot& scene) const {
    EXPECT_EQ(scene.version(), now->version());
    EXPECT_EQ(scene.contentHash(), now->contentHash());
    EXPECT_EQ(scene.objectCount(), now->objectCount());
    EXPECT_EQ(scene.triangleCount(), now->triangleCount());
  }
  std::vector<std::string> entries() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder)) {
      names.push_back(entry.path().filename().string());
    }
    return names;
  }
  fs::path onlyStore() const {
    EXPECT_EQ(entries().size(), 1U);
    return folder / entries().front();
  }

  const fs::path folder =
      fs::path(::testing::TempDir()) / ("culld_edits_" + std::to_string(::getpid()));
  SnapshotPtr base = scenes::rowOfObjects(50);
  SnapshotPtr now = base;
  SerialSource serials{1};
  std::unique_ptr<EditFolder> edits;
  std::unique_ptr<EditStore> store;
};

TEST_F(EditStoreTest, HoldsNothingBeforeTheFirstEdit) {
  const auto loaded = store->load(base);
  ASSERT_TRUE(loaded.ok());
  EXPECT_FALSE(loaded.value().has_value());
  EXPECT_TRUE(entries().empty());
}

TEST_F(EditStoreTest, BringsBackEveryKindOfEdit) {
  ASSERT_TRUE(apply({MoveObject{3, at(9)}, HideObject{4}, RemoveObject{5}}).ok());
  ASSERT_TRUE(apply({AddInstance{3, at(1, 1)}, AddInstance{50, at(2, 2)}}).ok());
  // The added are alike to what goes now.
  ASSERT_TRUE(apply({RemoveObject{3}, MoveObject{51, at(3, 3)}, HideObject{51}}).ok());
  ASSERT_TRUE(apply({RemoveObject{50}, ShowObject{4}, HideObject{6}}).ok());
  crash();
  expectLoaded();
}

TEST_F(EditStoreTest, GoesOnAfterARestart) {
  for (int round = 0; round < 5; ++round) {
    ASSERT_TRUE(apply({AddInstance{1, at(round)}, MoveObject{2, at(7, round)}}).ok());
    crash();
    expectLoaded();
  }
  EXPECT_EQ(now->objectCount(), 55U);
}

TEST_F(EditStoreTest, BringsBackRandomHistories) {
  std::mt19937 random(1);
  for (int step = 0; step < 300; ++step) {
    const auto id = static_cast<ObjectId>(random() % now->objectCount());
    if (now->instance(id).removed) continue;
    const auto x = static_cast<double>(random() % 100);
    const std::array<Edit, 6> all{
        MoveObject{id, at(x)},     HideObject{id},           ShowObject{id}, RemoveObject{id},
        AddInstance{id, at(x, 1)}, AddInstance{id, at(x, 2)}};
    ASSERT_TRUE(apply({all[random() % all.size()]}).ok());
    if (step % 50 != 49) continue;
    crash();
    expectLoaded();
  }
}

TEST_F(EditStoreTest, KeepsTheNetStateOfAnObjectAndNotItsHistory) {
  constexpr ObjectId kObjects = 1000;
  base = now = scenes::rowOfObjects(kObjects);
  for (int i = 0; i < 100; ++i) {  // without an end of the log they would be 3000 pages
    std::vector<Edit> all;
    for (ObjectId id = 0; id < kObjects; ++id) all.emplace_back(MoveObject{id, at(i)});
    ASSERT_TRUE(apply(std::move(all)).ok());
    store->tidy();
  }
  const fs::path path = onlyStore();
  EXPECT_LT(fs::file_size(path / "edits.db"), 256U << 10);
  EXPECT_LT(fs::file_size(path / "edits.db-wal"), 6U << 20);
  crash();
  expectLoaded();
  EXPECT_EQ(fs::file_size(onlyStore() / "edits.db-wal"), 0U) << "a start empties the log";
}

TEST_F(EditStoreTest, ServesOnlyTheSceneFileThatWasEdited) {
  ASSERT_TRUE(apply({HideObject{1}}).ok());
  const auto other = edits->storeOf("s", keyOfUpload(8))->load(base);
  ASSERT_TRUE(other.ok());
  EXPECT_FALSE(other.value().has_value());
  const auto smaller = edits->storeOf("s", keyOfUpload(7))->load(scenes::rowOfObjects(1));
  EXPECT_FALSE(smaller.ok()) << "edits of objects that the scene has not";
}

TEST_F(EditStoreTest, SweepsEditsOfScenesThatWereReplacedOrAreGone) {
  ASSERT_TRUE(apply({HideObject{1}}).ok());
  store.reset();
  EXPECT_TRUE(edits->sweep({{"s", 7}}).empty());
  EXPECT_EQ(entries().size(), 1U);
  EXPECT_TRUE(edits->sweep({{"s", 8}}).empty());
  EXPECT_TRUE(entries().empty());
}

TEST_F(EditStoreTest, RemovesWhatWasBegunAndNamesWhatIsForeign) {
  fs::create_directories(folder / "~tmp~0000000000000009");
  std::ofstream(folder / "~tmp~0000000000000009" / "edits.db") << "half";
  std::ofstream(folder / "holiday.jpg") << "sun";
  reopenFolder();
  EXPECT_EQ(entries(), std::vector<std::string>{"holiday.jpg"});
  const auto foreign = edits->sweep({});
  ASSERT_EQ(foreign.size(), 1U);
  EXPECT_NE(foreign[0].find("holiday.jpg"), std::string::npos);
  EXPECT_EQ(entries().size(), 1U);
}

TEST_F(EditStoreTest, TakesTheNewerOfTwoStoresAndRemovesTheOther) {
  ASSERT_TRUE(apply({HideObject{1}}).ok());
  const fs::path older = folder / (onlyStore().filename().string().substr(0, 19) + "~" + hex16(0));
  fs::copy(onlyStore(), older, fs::copy_options::recursive);
  ASSERT_TRUE(apply({HideObject{2}}).ok());
  store.reset();
  reopen();
  expectLoaded();
  EXPECT_EQ(entries().size(), 1U);
}

TEST_F(EditStoreTest, LeavesNothingWhenDiscarded) {
  ASSERT_TRUE(apply({HideObject{1}}).ok());
  store->discard();
  EXPECT_TRUE(entries().empty());
  EXPECT_FALSE(apply({HideObject{2}}).ok());
  EXPECT_TRUE(entries().empty());
}

TEST_F(EditStoreTest, RefusesEditsOfAnotherScene) {
  ASSERT_TRUE(apply({HideObject{1}}).ok());
  store.reset();
  fs::rename(onlyStore(), folder / ("t~" + keyOfUpload(7) + "~" + hex16(3)));
  const auto loaded = edits->storeOf("t", keyOfUpload(7))->load(base);
  ASSERT_FALSE(loaded.ok());
  EXPECT_NE(loaded.error().message.find("holds the edits of s"), std::string::npos)
      << loaded.error().message;
}

}  // namespace
}  // namespace culld::server
