// Every write, sync, rename, truncation and folder that an upload, a replacement, a removal or an
// edit makes fails once, or from then on, with ENOSPC and with EIO. The client hears of it, cameras
// are served, and after kill -9 and a restart all is as it was acknowledged.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/mount.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>

#include "tests/durability/disk_faults.h"
#include "tests/durability/known_scene.h"

namespace culld::testing {
namespace {

namespace fs = std::filesystem;
namespace wire = protocol;

std::vector<wire::EditItem> hide(std::uint32_t object) {
  return {{wire::EditKind::kHide, object, {}}};
}

class DiskFaultTest : public ::testing::Test {
 protected:
  DiskFaultTest() {
    fs::remove_all(folder);
    fs::create_directories(folder);
    const std::string file = (folder / "faults").string();
    const int fd = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
    EXPECT_EQ(::ftruncate(fd, sizeof(DiskFaults)), 0);
    void* shared = ::mmap(nullptr, sizeof(DiskFaults), PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
    ::close(fd);
    faults = static_cast<DiskFaults*>(shared);
  }
  ~DiskFaultTest() override {
    daemon.kill();
    ::munmap(faults, sizeof(DiskFaults));
    fs::remove_all(folder);
  }

  void start() {
    quiet();
    const Daemon::Environment environment{
        {"LD_PRELOAD", CULLD_DISK_FAULTS},
        {"ASAN_OPTIONS", "verify_asan_link_order=0:detect_leaks=0"},
        {"CULLD_FAULTS_FOLDER", fs::canonical(folder).string() + "/data"},
        {"CULLD_FAULTS_FILE", (folder / "faults").string()}};
    ASSERT_TRUE(daemon.start(environment)) << daemon.log();
  }
  void quiet() {
    faults->fail_at = 0;
    faults->calls = 0;
    faults->failed = 0;
  }
  void failFrom(std::uint64_t call, int code, bool lasting) {
    quiet();
    faults->error = static_cast<std::uint32_t>(code);
    faults->lasting = lasting ? 1 : 0;
    faults->fail_at = call;
  }

  int put(std::uint32_t objects) {
    const std::string glb = rowGlb(objects);
    const HttpAnswer answer = daemon.ask("PUT", "/v1/scenes/s", glb);
    error = answer.body;
    if (answer.status == 200 || answer.status == 201) scene = loaded(glb);
    return answer.status;
  }
  int remove() {
    const HttpAnswer answer = daemon.ask("DELETE", "/v1/scenes/s");
    error = answer.body;
    if (answer.status == 204) scene = nullptr;
    return answer.status;
  }
  /// 200 or 500, as the others.
  int edit(const std::vector<wire::EditItem>& items) {
    LiveClient client(daemon.connect(), "s");
    if (!client.hello() || !client.send(wire::Edit{0, items}, 9)) return 0;
    while (const auto message = client.receive()) {
      if (std::holds_alternative<wire::Edited>(message->body)) {
        scene = applied(scene, items);
        return 200;
      }
      if (const auto* refusal = std::get_if<wire::ErrorReply>(&message->body)) {
        error = refusal->message;
        return refusal->code == wire::WireCode::kInternal ? 500 : 1;
      }
    }
    return 0;
  }

  void expectAcknowledged(const std::string& when) {
    const ToldScene told = askScene(daemon, "s");
    EXPECT_TRUE(same(told, scene))
        << when << ": " << told.status << ", version " << told.version << ", " << told.objects
        << " objects, " << told.hash << " and not " << describe(scene);
    EXPECT_TRUE(scene == nullptr || answersAs(daemon, "s", scene)) << when;
  }

  /// `prepare`, then `act`, which makes `after(scene)` of the scene, with each of its calls
  /// failing. If the disk fails for good, and so the undoing too, one may find the new state after
  /// a restart where the client heard of a failure; never anything else.
  void failEach(const std::string& what, const std::function<void()>& prepare,
                const std::function<int()>& act,
                const std::function<SnapshotPtr(const SnapshotPtr&)>& after) {
    Told told;
    for (const int code : {ENOSPC, EIO}) {
      for (const bool lasting : {false, true}) {
        bool more = true;
        for (std::uint64_t call = 1; more; ++call) {
          SCOPED_TRACE(what + ", call " + std::to_string(call) + (lasting ? " and on" : "") + ", " +
                       std::strerror(code));
          prepare();
          if (HasFatalFailure()) return;
          const SnapshotPtr before = scene, attempted = after(scene);
          failFrom(call, code, lasting);
          const int status = act();
          more = faults->calls >= call;
          expectTold(status, code, told);
          if (status == 500) scene = before;
          expectAcknowledged("while the disk fails");
          daemon.kill();
          start();
          if (HasFatalFailure()) return;
          if (lasting && status == 500 && same(askScene(daemon, "s"), attempted)) {
            ++told.found;
            scene = attempted;
          }
          expectAcknowledged("afterwards");
        }
      }
    }
    std::printf("%s: %d failures told to the client, %d of them undone only in memory\n",
                what.c_str(), told.failures, told.found);
    EXPECT_GE(told.failures, 6) << what;
    EXPECT_LT(told.found * 3, told.failures) << what;
  }
  struct Told {
    int failures = 0, found = 0;
  };
  void expectTold(int status, int code, Told& told) const {
    EXPECT_TRUE(status / 100 == 2 || status == 500) << status << " " << error;
    if (status != 500) return;
    ++told.failures;
    EXPECT_GT(faults->failed, 0U) << error;
    EXPECT_NE(error.find("scene"), std::string::npos) << error;
    EXPECT_TRUE(error.find(std::strerror(code)) != std::string::npos ||
                error.find("disk I/O error at a ") != std::string::npos)  // SQLite's words
        << error;
  }

  const fs::path folder =
      fs::path(::testing::TempDir()) / ("culld_disk_" + std::to_string(::getpid()));
  DiskFaults* faults = nullptr;
  Daemon daemon{folder / "data"};
  SnapshotPtr scene;  ///< acknowledged last
  std::string error;
};

TEST_F(DiskFaultTest, AnUploadIsThereOrIsNot) {
  start();
  failEach(
      "a new scene", [this] { ASSERT_TRUE(scene == nullptr || remove() == 204) << error; },
      [this] { return put(30); }, [](const SnapshotPtr&) { return loaded(rowGlb(30)); });
}

TEST_F(DiskFaultTest, AReplacementIsThereOrTheSceneBeforeWithItsEdits) {
  start();
  failEach(
      "a replacement",
      [this] {
        ASSERT_EQ(put(20) / 100, 2);
        ASSERT_EQ(edit(hide(3)), 200) << error;
      },
      [this] { return put(30); }, [](const SnapshotPtr&) { return loaded(rowGlb(30)); });
}

TEST_F(DiskFaultTest, ARemovalIsDoneOrTheSceneIsThereWithItsEdits) {
  start();
  failEach(
      "a removal",
      [this] {
        ASSERT_EQ(put(20) / 100, 2);
        ASSERT_EQ(edit(hide(3)), 200) << error;
      },
      [this] { return remove(); }, [](const SnapshotPtr&) { return SnapshotPtr(); });
}

TEST_F(DiskFaultTest, TheFirstEditIsThereOrIsNot) {
  start();
  failEach(
      "the first edit", [this] { ASSERT_EQ(put(20) / 100, 2); }, [this] { return edit(hide(3)); },
      [](const SnapshotPtr& before) { return applied(before, hide(3)); });
}

TEST_F(DiskFaultTest, AnEditIsThereOrIsNot) {
  start();
  failEach(
      "an edit",
      [this] {
        ASSERT_EQ(put(20) / 100, 2);
        ASSERT_EQ(edit(hide(3)), 200) << error;
      },
      [this] { return edit(hide(4)); },
      [](const SnapshotPtr& before) { return applied(before, hide(4)); });
}

TEST_F(DiskFaultTest, EditsGoOnOnceTheDiskIsSoundAgain) {
  start();
  ASSERT_EQ(put(40), 201);
  ASSERT_EQ(edit(hide(1)), 200);
  std::uint32_t object = 2;
  for (const int code : {ENOSPC, EIO}) {
    for (std::uint64_t call = 1; call < 9; ++call) {
      failFrom(call, code, true);
      const int status = edit(hide(object));
      ASSERT_EQ(status, call <= faults->calls ? 500 : 200) << error;
      quiet();
      ASSERT_EQ(edit(hide(object)), 200) << "call " << call << ": " << error;
      expectAcknowledged("sound again");
      ++object;
    }
  }
  daemon.kill();
  start();
  expectAcknowledged("afterwards");
}

TEST_F(DiskFaultTest, NothingIsAcknowledgedThatIsNotSynced) {
  start();
  for (int round = 0; round < 3; ++round) {
    ASSERT_EQ(put(20) / 100, 2);
    EXPECT_EQ(faults->unsynced, 0U) << "after an upload";
    for (std::uint32_t object = 0; object < 10; ++object) {
      ASSERT_EQ(edit(hide(object)), 200);
      EXPECT_EQ(faults->unsynced, 0U) << "after edit " << object;
    }
  }
  ASSERT_EQ(remove(), 204);
  EXPECT_EQ(faults->unsynced, 0U) << "after a removal";
}

TEST_F(DiskFaultTest, AFullDiskIsToldAndLosesNothing) {
  const std::string data = (folder / "data").string();
  fs::create_directories(data);
  if (::mount("tmpfs", data.c_str(), "tmpfs", 0, "size=1m") != 0) {
    GTEST_SKIP() << "cannot mount a small tmpfs (needs root): a disk that is really full is not "
                    "tested here, only injected failures are";
  }
  start();
  EXPECT_EQ(put(100), 201);
  EXPECT_EQ(edit(hide(1)), 200) << error;
  int full = 0;
  for (std::uint32_t i = 0; i < 400 && full < 20; ++i) {  // until not even an edit fits
    std::vector<wire::EditItem> items;
    for (int add = 0; add < 64; ++add) {
      items.push_back(
          {wire::EditKind::kAdd, 1, {1, 0, 0, 1.0 * i, 0, 1, 0, 1.0 * add, 0, 0, 1, 0}});
    }
    const int status = edit(items);
    ASSERT_TRUE(status == 200 || status == 500) << status;
    if (status == 500) {
      ++full;
      EXPECT_NE(error.find("No space left"), std::string::npos) << error;
    }
  }
  EXPECT_EQ(full, 20);
  EXPECT_EQ(put(9000), 500);
  EXPECT_NE(error.find("No space left"), std::string::npos) << error;
  expectAcknowledged("while the disk is full");
  daemon.kill();
  start();
  expectAcknowledged("after a restart on a full disk");
  daemon.kill();
  EXPECT_EQ(::umount(data.c_str()), 0);
}

}  // namespace
}  // namespace culld::testing
