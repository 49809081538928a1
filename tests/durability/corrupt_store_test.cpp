// Damage everywhere: a store with a flipped bit, a zeroed block or a missing end either still says
// exactly what was acknowledged, or is refused with a line that names it and left as it was found.
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <functional>

#include "server/edit_store.h"
#include "server/scene_seal.h"
#include "tests/scenes/random.h"
#include "tests/scenes/row_of_objects.h"

namespace culld::server {
namespace {

namespace fs = std::filesystem;
using Bytes = std::string;

Bytes contentOf(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

void setContent(const fs::path& path, const Bytes& bytes) {
  std::ofstream(path, std::ios::binary | std::ios::trunc) << bytes;
}

/// All files below that are not empty, by their path.
std::map<std::string, Bytes> contentsBelow(const fs::path& folder) {
  std::map<std::string, Bytes> contents;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file() && entry.file_size() > 0)
      contents[entry.path().string()] = contentOf(entry.path());
  }
  return contents;
}

class CorruptStoreTest : public ::testing::Test {
 protected:
  /// A store as kill -9 leaves it: some edits moved into the database, some in its log.
  CorruptStoreTest() {
    fs::remove_all(root);
    auto edits = EditFolder::open(root / "edits", serials).value();
    auto store = edits->storeOf("s", keyOfUpload(1));
    apply(*store, 0, 800);
    store.reset();
    store = edits->storeOf("s", keyOfUpload(1));
    EXPECT_TRUE(store->load(base).ok());
    apply(*store, 800, 820);
    apply(*store, 20, 40);
    fs::copy(root / "edits", root / "killed", fs::copy_options::recursive);
  }
  ~CorruptStoreTest() override { fs::remove_all(root); }

  void apply(EditStore& store, ObjectId first, ObjectId end) {
    std::vector<Edit> all;
    for (ObjectId id = first; id < end; ++id) {
      all.emplace_back(MoveObject{id, {1, 0, 0, id + 0.25, 0, 1, 0, 7, 0, 0, 1, 0}});
    }
    auto edited = applyEdits(now, all);
    ASSERT_TRUE(edited.ok());
    ASSERT_TRUE(store.commit(*now, *edited.value().snapshot, all).ok());
    now = edited.value().snapshot;
  }
  fs::path storeIn(const char* folder) const {
    return fs::directory_iterator(root / folder)->path();
  }

  enum class Verdict { kRefused, kSame, kWrong };
  /// Of the killed store with one file changed.
  Verdict judge(const std::string& file, const std::function<void(const fs::path&)>& damage) {
    fs::remove_all(root / "edits");
    fs::copy(root / "killed", root / "edits", fs::copy_options::recursive);
    damage(storeIn("edits") / file);
    const auto before = contentsBelow(root / "edits");
    auto edits = EditFolder::open(root / "edits", serials).value();
    auto store = edits->storeOf("s", keyOfUpload(1));
    const auto loaded = store->load(base);
    if (loaded.ok()) {
      if (!loaded.value()) return Verdict::kWrong;
      const SceneSnapshot& scene = *loaded.value()->snapshot;
      const bool same =
          scene.version() == now->version() && scene.contentHash() == now->contentHash();
      return same ? Verdict::kSame : Verdict::kWrong;
    }
    store.reset();
    EXPECT_NE(loaded.error().message.find("edits of scene \"s\" (s~u"), std::string::npos)
        << loaded.error().message;
    EXPECT_TRUE(contentsBelow(root / "edits") == before) << "looking changed " << file;
    return Verdict::kRefused;
  }

  const fs::path root =
      fs::path(::testing::TempDir()) / ("culld_corrupt_" + std::to_string(::getpid()));
  const SnapshotPtr base = scenes::rowOfObjects(1000);
  SnapshotPtr now = base;
  SerialSource serials{1};
};

constexpr const char* kFiles[] = {"edits.db", "edits.db-wal", "mark"};

TEST_F(CorruptStoreTest, TheUndamagedStoreIsRead) {
  EXPECT_EQ(judge("mark", [](const fs::path&) {}), Verdict::kSame);
  EXPECT_GT(fs::file_size(storeIn("killed") / "edits.db-wal"), 8000U);
  EXPECT_GT(fs::file_size(storeIn("killed") / "edits.db"), 20'000U);
}

TEST_F(CorruptStoreTest, AFlippedBitIsFoundOrChangesNothing) {
  scenes::Random random(1);
  for (const char* file : kFiles) {
    const Bytes whole = contentOf(storeIn("killed") / file);
    std::size_t refused = 0, tried = 0;
    // Headers byte by byte, the rest in steps that do not fit rows or pages.
    for (std::size_t at = 0; at < whole.size(); at += at < 100 ? 1 : 151 + random.below(100)) {
      const auto bit = static_cast<char>(1U << random.below(8));
      const Verdict verdict = judge(file, [&](const fs::path& path) {
        Bytes bytes = whole;
        bytes[at] = static_cast<char>(bytes[at] ^ bit);
        setContent(path, bytes);
      });
      EXPECT_NE(verdict, Verdict::kWrong) << file << " byte " << at << " bit " << int{bit};
      refused += verdict == Verdict::kRefused ? 1U : 0U;
      ++tried;
    }
    if (file == kFiles[2]) continue;  // of the mark's two places one is enough
    EXPECT_GE(refused * 2, tried) << file << ": " << refused;
  }
}

TEST_F(CorruptStoreTest, AFileCutShortIsFoundOrChangesNothing) {
  scenes::Random random(2);
  for (const char* file : kFiles) {
    const std::size_t size = fs::file_size(storeIn("killed") / file);
    std::size_t refused = 0, tried = 0;
    for (std::size_t length = 0; length < size; length += 1 + random.below(1500)) {
      const Verdict verdict =
          judge(file, [length](const fs::path& path) { fs::resize_file(path, length); });
      EXPECT_NE(verdict, Verdict::kWrong) << file << " cut to " << length;
      refused += verdict == Verdict::kRefused ? 1U : 0U;
      ++tried;
    }
    EXPECT_GT(refused * 4, tried * 3) << file << ": " << refused << " of " << tried;
  }
}

TEST_F(CorruptStoreTest, AZeroedBlockIsFoundOrChangesNothing) {
  for (const char* file : kFiles) {
    const Bytes whole = contentOf(storeIn("killed") / file);
    for (std::size_t at = 0; at < whole.size(); at += 512) {
      const Verdict verdict = judge(file, [&](const fs::path& path) {
        Bytes bytes = whole;
        bytes.replace(at, std::min<std::size_t>(512, bytes.size() - at), 512, '\0');
        setContent(path, bytes.substr(0, whole.size()));
      });
      EXPECT_NE(verdict, Verdict::kWrong) << file << " block at " << at;
    }
  }
}

TEST_F(CorruptStoreTest, AFileThatIsMissingOrAnotherOneIsFound) {
  for (const char* file : kFiles) {
    EXPECT_EQ(judge(file, [](const fs::path& path) { fs::remove(path); }), Verdict::kRefused)
        << file;
    const auto foreign = [](const fs::path& path) { setContent(path, Bytes(5000, 'x')); };
    EXPECT_EQ(judge(file, foreign), Verdict::kRefused) << file;
  }
}

TEST_F(CorruptStoreTest, AnOlderCopyOfTheLogIsFound) {
  const Bytes log = contentOf(storeIn("killed") / "edits.db-wal");
  const Verdict verdict = judge("edits.db-wal", [&](const fs::path& path) {
    setContent(path, log.substr(0, log.size() / 2));  // ends with a whole commit or in one
  });
  EXPECT_EQ(verdict, Verdict::kRefused);
}

TEST(SceneSeal, FindsAnyBitThatIsNotAsItWas) {
  scenes::Random random(3);
  std::vector<std::byte> file(700);
  for (std::byte& b : file) b = static_cast<std::byte>(random.below(256));
  Checksum sum;
  sum.add(file);
  const Seal seal = makeSeal(file.size(), sum.digest());
  file.insert(file.end(), seal.begin(), seal.end());
  ASSERT_TRUE(openSealed(file).ok());
  EXPECT_EQ(openSealed(file).value().size(), 700U);
  for (std::size_t bit = 0; bit < file.size() * 8; ++bit) {
    file[bit / 8] ^= static_cast<std::byte>(1U << (bit % 8));
    EXPECT_FALSE(openSealed(file).ok()) << "bit " << bit;
    file[bit / 8] ^= static_cast<std::byte>(1U << (bit % 8));
  }
  for (std::size_t length = 0; length < file.size(); ++length) {
    EXPECT_FALSE(openSealed(std::span(file).first(length)).ok()) << length << " bytes";
  }
  file.push_back(std::byte{0});
  EXPECT_FALSE(openSealed(file).ok()) << "a byte more";
}

TEST(SceneSeal, NamesAVersionThatItDoesNotKnow) {
  Seal seal = makeSeal(0, Checksum().digest());
  seal[8] = std::byte{2};
  const std::uint64_t check = checksumOf(std::span(seal).first(40));
  for (std::size_t i = 0; i < 8; ++i) seal[40 + i] = static_cast<std::byte>(check >> (8 * i));
  const auto opened = openSealed(seal);
  ASSERT_FALSE(opened.ok());
  EXPECT_NE(opened.error().message.find("version 2"), std::string::npos) << opened.error().message;
}

}  // namespace
}  // namespace culld::server
