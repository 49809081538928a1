#include "server/scene_store.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <thread>

#include "tests/scenes/known_scenes.h"
#include "tests/scenes/row_glb.h"
#include "tests/unit/server/fake_method.h"

namespace culld::server {
namespace {

namespace fs = std::filesystem;

class SceneStoreTest : public ::testing::Test {
 protected:
  SceneStoreTest() {
    fs::remove_all(folder);
    fs::create_directories(folder);
  }
  ~SceneStoreTest() override { fs::remove_all(folder); }

  std::unique_ptr<SceneStore> open(std::size_t max_scenes = 10) {
    auto files = SceneFiles::open(folder);
    EXPECT_TRUE(files.ok());
    auto edits = EditFolder::open(folder / "edits", files.value()->serials());
    EXPECT_TRUE(edits.ok());
    return std::make_unique<SceneStore>(std::move(files).value(), std::move(edits).value(),
                                        Methods(table), max_scenes, LoadOptions{});
  }
  Result<bool> put(SceneStore& store, const std::string& name, std::span<const std::byte> bytes) {
    auto upload = store.beginUpload();
    EXPECT_TRUE(upload.ok());
    EXPECT_TRUE(upload.value().append(bytes).ok());
    return store.finishUpload(name, std::move(upload).value());
  }
  std::size_t filesIn(const char* part) const {
    return static_cast<std::size_t>(
        std::distance(fs::directory_iterator(folder / part), fs::directory_iterator()));
  }

  const fs::path folder =
      fs::path(::testing::TempDir()) / ("culld_store_" + std::to_string(::getpid()));
  FakeMethod fake;
  const Method* table[1] = {&fake};
};

TEST_F(SceneStoreTest, KeepsUploadsAcrossRestarts) {
  std::uint64_t hash = 0;
  {
    auto store = open();
    const auto fresh = put(*store, "two", scenes::rowGlb(2));
    ASSERT_TRUE(fresh.ok()) << fresh.error().message;
    EXPECT_TRUE(fresh.value());
    hash = store->find("two")->current()->snapshot()->contentHash();
  }
  auto store = open();
  EXPECT_TRUE(store->loadAll().value().empty());
  ASSERT_NE(store->find("two"), nullptr);
  EXPECT_EQ(store->find("two")->current()->snapshot()->contentHash(), hash);
  EXPECT_EQ(store->list().at("two").file_bytes, scenes::rowGlb(2).size());
}

TEST_F(SceneStoreTest, ReplacesASceneUnderTheHandsOfItsReaders) {
  auto store = open();
  ASSERT_TRUE(put(*store, "s", scenes::rowGlb(2)).ok());
  const auto scene = store->find("s");
  const SceneVersionPtr before = scene->current();
  const auto again = put(*store, "s", scenes::rowGlb(5));
  ASSERT_TRUE(again.ok());
  EXPECT_FALSE(again.value());
  EXPECT_EQ(before->snapshot()->objectCount(), 2U);
  EXPECT_EQ(scene->current()->snapshot()->objectCount(), 5U);
  EXPECT_EQ(scene->current()->epoch(), before->epoch() + 1);
}

TEST_F(SceneStoreTest, KeepsNothingOfABadUpload) {
  auto store = open();
  const auto bad = put(*store, "bad", std::vector<std::byte>(100, std::byte{7}));
  ASSERT_FALSE(bad.ok());
  EXPECT_EQ(bad.error().message.rfind("bad: ", 0), 0U) << bad.error().message;
  EXPECT_EQ(store->find("bad"), nullptr);
  EXPECT_EQ(filesIn("scenes"), 0U);
  EXPECT_EQ(filesIn("uploads"), 0U);
}

TEST_F(SceneStoreTest, RemovesHalfUploadsOfADeadProcess) {
  { open(); }
  std::ofstream(folder / "uploads" / "half") << "glTF";
  open();
  EXPECT_EQ(filesIn("uploads"), 0U);
}

TEST_F(SceneStoreTest, NamesAStoredSceneThatIsBrokenAndServesTheOthers) {
  {
    auto store = open();
    ASSERT_TRUE(put(*store, "fine", scenes::rowGlb(1)).ok());
    std::ofstream(folder / "scenes" / "torn~0000000000000007.scene") << "glTF but no more";
  }
  auto store = open();
  const auto failures = store->loadAll().value();
  ASSERT_EQ(failures.size(), 1U);
  EXPECT_NE(failures[0].find("torn"), std::string::npos);
  EXPECT_EQ(store->find("torn"), nullptr);
  EXPECT_NE(store->find("fine"), nullptr);
}

TEST_F(SceneStoreTest, ForgetsARemovedSceneForGood) {
  {
    auto store = open();
    ASSERT_TRUE(put(*store, "s", scenes::rowGlb(1)).ok());
    EXPECT_TRUE(store->remove("s").ok());
    EXPECT_EQ(store->find("s"), nullptr);
    const auto again = store->remove("s");
    ASSERT_FALSE(again.ok());
    EXPECT_EQ(again.error().code, ErrorCode::kNotFound);
  }
  auto store = open();
  EXPECT_TRUE(store->loadAll().value().empty());
  EXPECT_EQ(store->find("s"), nullptr);
}

TEST_F(SceneStoreTest, LimitsTheNumberOfScenes) {
  auto store = open(1);
  ASSERT_TRUE(put(*store, "a", scenes::rowGlb(1)).ok());
  const auto second = put(*store, "b", scenes::rowGlb(1));
  ASSERT_FALSE(second.ok());
  EXPECT_EQ(second.error().code, ErrorCode::kUnavailable);
  EXPECT_TRUE(put(*store, "a", scenes::rowGlb(2)).ok()) << "replacing is not one more";
}

TEST_F(SceneStoreTest, KeepsASecondProcessOut) {
  const auto store = open();
  const auto second = SceneFiles::open(folder);
  ASSERT_FALSE(second.ok());
  EXPECT_EQ(second.error().code, ErrorCode::kUnavailable);
}

TEST_F(SceneStoreTest, LeavesNoTemporaryFolderBehind) {
  fs::path where;
  {
    auto files = SceneFiles::open({});
    ASSERT_TRUE(files.ok());
    where = files.value()->folder();
    EXPECT_TRUE(fs::exists(where));
  }
  EXPECT_FALSE(fs::exists(where));
}

TEST(SceneName, AllowsOnlyWhatIsSafeInAPath) {
  for (const char* good : {"a", "City_2.1-b", "0"}) EXPECT_TRUE(validSceneName(good)) << good;
  for (const char* bad : {"", ".", "..", ".x", "a/b", "a b", "a%2e", "\xC3\xA4"}) {
    EXPECT_FALSE(validSceneName(bad)) << bad;
  }
  EXPECT_TRUE(validSceneName(std::string(64, 'x')));
  EXPECT_FALSE(validSceneName(std::string(65, 'x')));
}

TEST(SceneReaders, NeverWaitForAWriterAndSeeWholeVersions) {
  FakeMethod fake;
  const Method* table[1] = {&fake};
  Scene scene("s", Methods(table), rowOfObjects(100));
  std::atomic<bool> done{false};
  std::thread reader([&] {
    std::uint64_t last = 0;
    while (!done) {
      const SceneVersionPtr version = scene.current();
      EXPECT_GE(version->snapshot()->version(), last);
      last = version->snapshot()->version();
      const auto culler = version->culler(fake);
      EXPECT_TRUE(culler.ok());
    }
  });
  for (ObjectId id = 0; id < 100; ++id) {
    EXPECT_TRUE(editScene(scene, {HideObject{id}}).ok());
  }
  done = true;
  reader.join();
  EXPECT_EQ(scene.current()->snapshot()->version(), 101U);
}

}  // namespace
}  // namespace culld::server
