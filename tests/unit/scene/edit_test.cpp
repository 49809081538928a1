#include "culling/scene/edit.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <limits>
#include <thread>

#include "tests/unit/scene/test_meshes.h"

namespace culld {
namespace {

constexpr std::size_t kChunk = ChunkedArray<Instance>::kChunkSize;

EditedScene edited(const SnapshotPtr& scene, std::vector<Edit> edits) {
  auto result = applyEdits(scene, edits);
  EXPECT_TRUE(result.ok()) << result.error().message;
  return std::move(result).value();
}

std::string messageOf(const SnapshotPtr& scene, std::vector<Edit> edits) {
  const auto result = applyEdits(scene, edits);
  return result.ok() ? "no error" : result.error().message;
}

TEST(Edit, CopiesOnlyTheChunksThatItTouches) {
  const SnapshotPtr before = test::rowOfCubes(10 * kChunk);
  const EditedScene after = edited(before, {HideObject{5}, MoveObject{6, test::movedBy(9, 9, 9)},
                                            HideObject{static_cast<ObjectId>(7 * kChunk)}});
  EXPECT_EQ(after.snapshot->chunksNotIn(*before), 2U);
  EXPECT_EQ(after.changed, (std::vector<ObjectId>{5, 6, static_cast<ObjectId>(7 * kChunk)}));
  EXPECT_EQ(&after.snapshot->mesh(0), &before->mesh(0));
}

TEST(Edit, LeavesTheOldVersionAsItWas) {
  const SnapshotPtr before = test::rowOfCubes(3);
  const std::uint64_t hash = before->contentHash();
  const SnapshotPtr after =
      edited(before, {MoveObject{1, test::movedBy(0, 7, 0)}, RemoveObject{2}}).snapshot;
  EXPECT_EQ(before->instance(1).world_from_mesh[7], 0.0);
  EXPECT_FALSE(before->instance(2).removed);
  EXPECT_EQ(before->contentHash(), hash);
  EXPECT_EQ(before->version() + 1, after->version());
  EXPECT_EQ(after->instance(1).world_from_mesh[7], 7.0);
  EXPECT_GE(after->instance(1).bounds_world.max.y, 8.0);
}

TEST(Edit, HashIsOfTheContentNotOfTheHistory) {
  const SnapshotPtr start = test::rowOfCubes(2 * kChunk);
  const auto home = start->instance(4).world_from_mesh;
  const SnapshotPtr away = edited(start, {MoveObject{4, test::movedBy(0, 5, 0)}}).snapshot;
  const SnapshotPtr back = edited(away, {MoveObject{4, home}}).snapshot;
  EXPECT_NE(away->contentHash(), start->contentHash());
  EXPECT_EQ(back->contentHash(), start->contentHash());
  const SnapshotPtr hidden = edited(start, {HideObject{3}}).snapshot;
  EXPECT_NE(hidden->contentHash(), start->contentHash());
  EXPECT_EQ(edited(hidden, {ShowObject{3}}).snapshot->contentHash(), start->contentHash());
  EXPECT_EQ(edited(away, {RemoveObject{4}}).snapshot->contentHash(),
            edited(start, {HideObject{4}, RemoveObject{4}}).snapshot->contentHash());
}

TEST(Edit, HashDoesNotDependOnHowEditsAreGrouped) {
  const SnapshotPtr start = test::rowOfCubes(kChunk);
  const Edit add = AddInstance{0, test::movedBy(1, 2, 3)}, hide = HideObject{8};
  const SnapshotPtr once = edited(start, {add, hide}).snapshot;
  const SnapshotPtr twice = edited(edited(start, {hide}).snapshot, {add}).snapshot;
  EXPECT_EQ(once->contentHash(), twice->contentHash());
}

TEST(Edit, CountsTrianglesOfWhatIsNotRemoved) {
  SnapshotPtr scene = test::rowOfCubes(5);
  EXPECT_EQ(scene->triangleCount(), 60U);
  scene = edited(scene, {RemoveObject{0}, HideObject{1}}).snapshot;
  EXPECT_EQ(scene->triangleCount(), 48U);
  scene = edited(scene, {AddInstance{2, test::kIdentity}}).snapshot;
  EXPECT_EQ(scene->triangleCount(), 60U);
  EXPECT_EQ(scene->objectCount(), 6U);
}

TEST(Edit, AnAddedObjectHasANewIdAndItsOwnKey) {
  const SnapshotPtr before = test::rowOfCubes(kChunk);
  const EditedScene after =
      edited(before, {AddInstance{3, test::movedBy(0, 1, 0)}, AddInstance{3, test::kIdentity}});
  const auto first = static_cast<ObjectId>(kChunk);
  EXPECT_EQ(after.changed, (std::vector<ObjectId>{first, first + 1}));
  EXPECT_EQ(after.snapshot->instance(first).node, 3U);
  EXPECT_NE(after.snapshot->instance(first).instance_number,
            after.snapshot->instance(first + 1).instance_number);
  EXPECT_EQ(after.snapshot->chunksNotIn(*before), 1U);
}

TEST(Edit, AppliesAllOrNone) {
  const SnapshotPtr scene = test::rowOfCubes(3);
  const std::uint64_t hash = scene->contentHash();
  EXPECT_EQ(messageOf(scene, {HideObject{0}, HideObject{3}}),
            "edit: hide object 3: the scene has 3 objects");
  EXPECT_EQ(scene->contentHash(), hash);
  EXPECT_FALSE(scene->instance(0).hidden);
}

TEST(Edit, NamesWhatIsWrong) {
  const SnapshotPtr scene = edited(test::rowOfCubes(3), {RemoveObject{1}}).snapshot;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(messageOf(scene, {MoveObject{0, test::movedBy(nan, 0, 0)}}),
            "edit: move object 0: transform entry 3 is not finite");
  EXPECT_EQ(messageOf(scene, {ShowObject{1}}), "edit: show object 1: it was removed");
  EXPECT_EQ(messageOf(scene, {RemoveObject{1}}), "edit: remove object 1: it was removed");
  EXPECT_EQ(messageOf(scene, {AddInstance{7, test::kIdentity}}),
            "edit: add object 7: the scene has 3 objects");
  EXPECT_EQ(messageOf(scene, {MoveObject{7, test::kIdentity}}),
            "edit: move object 7: the scene has 3 objects");
}

TEST(Edit, AnEmptyListMakesAnEqualVersion) {
  const SnapshotPtr before = test::rowOfCubes(3);
  const EditedScene after = edited(before, {});
  EXPECT_TRUE(after.changed.empty());
  EXPECT_EQ(after.snapshot->contentHash(), before->contentHash());
  EXPECT_EQ(after.snapshot->chunksNotIn(*before), 0U);
}

TEST(Edit, OneEditCostsOneChunkHoweverLargeTheScene) {
  for (const std::size_t objects : {1'000UL, 10'000UL, 100'000UL, 1'000'000UL}) {
    const SnapshotPtr before = test::rowOfCubes(objects);
    const Edit move = MoveObject{static_cast<ObjectId>(objects / 2), test::movedBy(0, 1, 0)};
    auto best = std::chrono::nanoseconds::max();
    for (int repeat = 0; repeat < 5; ++repeat) {
      const auto start = std::chrono::steady_clock::now();
      const EditedScene after = edited(before, {move});
      best = std::min<std::chrono::nanoseconds>(best, std::chrono::steady_clock::now() - start);
      EXPECT_EQ(after.snapshot->chunksNotIn(*before), 1U);
    }
    RecordProperty("edit_us_" + std::to_string(objects), std::to_string(best.count() / 1000));
    // Typically well below 1 ms; the bound leaves room for sanitizers and loaded machines.
    EXPECT_LT(best, std::chrono::milliseconds(50)) << objects << " objects";
  }
}

TEST(Edit, ReadersSeeWholeVersionsWhileEditsAreMade) {
  SnapshotPtr current = test::rowOfCubes(3 * kChunk);
  std::atomic<bool> done{false};
  std::atomic<int> torn{0};
  std::vector<std::thread> readers;
  for (int r = 0; r < 3; ++r) {
    readers.emplace_back([&] {
      while (!done.load()) {
        const SnapshotPtr seen = std::atomic_load(&current);
        // Every version moves these two together.
        const double a = seen->instance(1).world_from_mesh[7];
        const double b = seen->instance(2 * kChunk).world_from_mesh[7];
        if (a != b || a + 1.0 != static_cast<double>(seen->version())) ++torn;
      }
    });
  }
  for (int step = 1; step <= 300; ++step) {
    const auto up = [&](ObjectId id) { return MoveObject{id, test::movedBy(0, step, 0)}; };
    const SnapshotPtr base = std::atomic_load(&current);
    std::atomic_store(&current,
                      edited(base, {up(1), up(static_cast<ObjectId>(2 * kChunk))}).snapshot);
  }
  done = true;
  for (std::thread& reader : readers) reader.join();
  EXPECT_EQ(torn.load(), 0);
}

}  // namespace
}  // namespace culld
