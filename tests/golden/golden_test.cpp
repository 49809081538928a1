// The bytes of every message as they were when it was made golden, judged by flatc, which shares no
// code with the codec: neither may change its mind about what they mean.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "protocol/codec.h"
#include "protocol/id_set.h"
#include "tests/golden/messages.h"

namespace culld::testing {
namespace {

namespace fs = std::filesystem;
using Bytes = std::vector<std::uint8_t>;

const fs::path kGolden = CULLD_GOLDEN;

std::string read(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  EXPECT_TRUE(in.good()) << path << " is missing";
  return {std::istreambuf_iterator<char>(in), {}};
}

Bytes bytesOf(const fs::path& path) {
  const std::string text = read(path);
  return {text.begin(), text.end()};
}

void write(const fs::path& path, const Bytes& bytes) {
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
}

/// flatc at work in a folder of its own.
class Flatc {
 public:
  Flatc() { fs::create_directories(folder); }
  ~Flatc() { fs::remove_all(folder); }
  Flatc(const Flatc&) = delete;
  Flatc& operator=(const Flatc&) = delete;

  void toJson(const std::vector<fs::path>& files) const {
    run("--json --strict-json --raw-binary", files, " --");
  }
  void toBinary(const std::vector<fs::path>& files) const { run("--binary", files, ""); }

  const fs::path folder =
      fs::path(::testing::TempDir()) / ("culld_golden_" + std::to_string(::getpid()));

 private:
  void run(const std::string& flags, const std::vector<fs::path>& files,
           const std::string& separator) const {
    std::string command = std::string(CULLD_FLATC) + " " + flags + " -o " + folder.string() + " " +
                          CULLD_SCHEMA + separator;
    for (const fs::path& file : files) command += " " + file.string();
    ASSERT_EQ(std::system(command.c_str()), 0) << command;
  }
};

class Golden : public ::testing::Test {
 protected:
  /// CULLD_WRITE_GOLDEN=1 makes the files of messages that have none yet.
  static void SetUpTestSuite() {
    if (std::getenv("CULLD_WRITE_GOLDEN") == nullptr) return;
    const Flatc flatc;
    for (const auto& [name, message] : goldenMessages()) {
      const fs::path file = kGolden / (name + ".bin");
      if (fs::exists(file)) continue;
      write(file, protocol::encode(message));
      flatc.toJson({file});
      fs::copy_file(flatc.folder / (name + ".json"), kGolden / (name + ".json"));
    }
  }

  static protocol::Message decoded(const Bytes& bytes) {
    auto message = protocol::decode(bytes, protocol::kMaxReplyBytes);
    EXPECT_TRUE(message.ok()) << message.error().message;
    return message ? std::move(message).value() : protocol::Message{};
  }

  const std::vector<GoldenMessage> all = goldenMessages();
  const Flatc flatc;
  const fs::path& work = flatc.folder;
};

TEST_F(Golden, HasEveryKindOfMessage) {
  std::vector<bool> covered(std::variant_size_v<protocol::Body>);
  for (const auto& [name, message] : all) covered[message.body.index()] = true;
  EXPECT_EQ(std::count(covered.begin(), covered.end(), false), 0);
  std::size_t files = 0;
  for (const auto& entry : fs::directory_iterator(kGolden)) {
    files += entry.path().extension() == ".bin" || entry.path().extension() == ".json" ? 1U : 0U;
  }
  EXPECT_EQ(files, 2 * all.size()) << "a file that no test reads, or one too few";
}

TEST_F(Golden, TheBytesMeanWhatTheyMeant) {
  std::vector<fs::path> files;
  for (const auto& [name, message] : all) {
    files.push_back(kGolden / (name + ".bin"));
    EXPECT_EQ(decoded(bytesOf(files.back())), message) << name;
  }
  flatc.toJson(files);
  for (const auto& [name, message] : all) {
    EXPECT_EQ(read(work / (name + ".json")), read(kGolden / (name + ".json"))) << name;
  }
}

TEST_F(Golden, WhatIsWrittenTodayMeansTheSame) {
  std::vector<fs::path> files;
  for (const auto& [name, message] : all) {
    files.push_back(work / (name + ".bin"));
    write(files.back(), protocol::encode(message));
  }
  flatc.toJson(files);
  for (const auto& [name, message] : all) {
    EXPECT_EQ(read(work / (name + ".json")), read(kGolden / (name + ".json"))) << name;
  }
}

TEST_F(Golden, WhatAnotherWriterMakesOfTheJsonIsRead) {
  std::vector<fs::path> files;
  for (const auto& [name, message] : all) files.push_back(kGolden / (name + ".json"));
  flatc.toBinary(files);
  for (const auto& [name, message] : all) {
    EXPECT_EQ(decoded(bytesOf(work / (name + ".bin"))), message) << name;
  }
}

TEST_F(Golden, TheSetsOfAnswersAreTheDocumentsExample) {
  const protocol::IdSet baseline = {2, 7};
  const protocol::IdSet expected = {1, 2, 300};
  int sets = 0;
  for (const auto& [name, message] : all) {
    const auto* answer = std::get_if<protocol::Answer>(&message.body);
    if (answer == nullptr) continue;
    const auto set = protocol::decodeSet(answer->encoding, answer->payload, answer->scene_objects,
                                         answer->baseline != 0 ? baseline : protocol::IdSet{});
    ASSERT_TRUE(set.ok()) << name << ": " << set.error().message;
    EXPECT_EQ(set.value(), expected) << name;
    EXPECT_EQ(protocol::setHash(set.value()), answer->set_hash) << name;
    ++sets;
  }
  EXPECT_EQ(sets, 4) << "one for each encoding";
}

TEST_F(Golden, TextPastItsLimitIsRefusedWhoeverWroteIt) {
  for (const std::size_t length : {protocol::kMaxTextBytes, protocol::kMaxTextBytes + 1}) {
    std::ofstream(work / "text.json")
        << R"({"body_type":"GoAway","body":{"reason":")" << std::string(length, 'x') << "\"}}";
    flatc.toBinary({work / "text.json"});
    const auto message = protocol::decode(bytesOf(work / "text.bin"), protocol::kMaxReplyBytes);
    ASSERT_EQ(message.ok(), length == protocol::kMaxTextBytes);
    if (!message) {
      EXPECT_EQ(message.error().code, protocol::ErrorCode::kLimit);
    }
  }
}

}  // namespace
}  // namespace culld::testing
