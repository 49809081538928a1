// Files on disk: .gltf with data URIs and buffers beside it, and paths that must not be followed.
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "tests/unit/scene/gltf_file.h"

namespace culld::test {
namespace {

namespace fs = std::filesystem;

class GltfFiles : public testing::Test {
 protected:
  void SetUp() override {
    const std::string name = testing::UnitTest::GetInstance()->current_test_info()->name();
    folder_ = fs::path(testing::TempDir()) / ("culld-" + std::to_string(::getpid()) + "-" + name);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  void write(const std::string& name, const Bytes& bytes) const {
    std::ofstream(folder_ / name, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
  }
  /// A triangle whose buffer is at `uri`.
  void writeScene(const std::string& name, const std::string& uri, int byte_length = 36) const {
    GltfFile file;
    file.mesh(file.positions(kTriangle));
    file.nodeWith(0);
    file.buffers(R"({"byteLength":)" + std::to_string(byte_length) + R"(,"uri":")" + uri + "\"}");
    write(name, bytesOf(file.json()));
  }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  /// The error line without the path of the file, or "".
  std::string lineOf(const std::string& name, const LoadOptions& options = {}) const {
    const auto scene = loadGltfFile(path(name), options);
    if (scene.ok()) return "";
    EXPECT_TRUE(scene.error().message.starts_with(path(name) + ": ")) << scene.error().message;
    return scene.error().message.substr(path(name).size() + 2);
  }
  std::string lineOfUri(const std::string& uri) const {
    writeScene("scene.gltf", uri);
    return lineOf("scene.gltf");
  }

  fs::path folder_;
};

Bytes triangleBytes() {
  Bytes bytes;
  for (const float f : kTriangle) append(bytes, f);
  return bytes;
}

TEST_F(GltfFiles, ReadsBuffersBesideTheFileByTheirDecodedNames) {
  fs::create_directories(folder_ / "parts");
  write("parts/Größe 木 1.bin", triangleBytes());
  EXPECT_EQ(lineOfUri("parts/Größe 木 1.bin"), "");
  EXPECT_EQ(lineOfUri("parts/Gr%C3%B6%C3%9Fe%20%E6%9C%A8%201.bin"), "");
  writeScene("Szene ü.gltf", "./parts/Größe 木 1.bin");
  EXPECT_EQ(lineOf("Szene ü.gltf"), "");
}

TEST_F(GltfFiles, ReadsDataUris) {
  EXPECT_EQ(lineOfUri("data:application/octet-stream;base64,"
                      "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"),
            "");
  std::string percent = "data:,";
  for (const std::byte b : triangleBytes()) {
    constexpr const char* kHex = "0123456789ABCDEF";
    percent += {'%', kHex[static_cast<unsigned>(b) >> 4], kHex[static_cast<unsigned>(b) & 15]};
  }
  EXPECT_EQ(lineOfUri(percent), "");
}

TEST_F(GltfFiles, RefusesBrokenDataUris) {
  EXPECT_EQ(lineOfUri("data:nothing"), "buffer 0: data URI without a comma");
  EXPECT_EQ(lineOfUri("data:;base64,!!!!"), "buffer 0: data URI: not base64");
  EXPECT_EQ(lineOfUri("data:;base64,AAAAA"), "buffer 0: data URI: base64 is cut off");
  EXPECT_EQ(lineOfUri("data:;base64,"), "buffer 0: 36 bytes announced, its URI has 0");
  EXPECT_EQ(lineOfUri("data:;base64,AAAA"), "buffer 0: 36 bytes announced, its URI has 3");
  EXPECT_EQ(lineOfUri("data:,%0"), "buffer 0: URI: % without two hex digits");
}

TEST_F(GltfFiles, NeverLeavesTheFolderOfTheFile) {
  const std::string inside = "; only paths inside the file's folder are read";
  const std::string relative = ": URI with a scheme; only data: and relative paths are read";
  EXPECT_EQ(lineOfUri("../x.bin"), "buffer 0: ../x.bin: path with '..'" + inside);
  EXPECT_EQ(lineOfUri("a/../../x.bin"), "buffer 0: a/../../x.bin: path with '..'" + inside);
  EXPECT_EQ(lineOfUri("%2e%2e/x.bin"), "buffer 0: %2e%2e/x.bin: path with '..'" + inside);
  EXPECT_EQ(lineOfUri("/etc/hostname"), "buffer 0: /etc/hostname: absolute path" + inside);
  EXPECT_EQ(lineOfUri("%2fetc/hostname"), "buffer 0: %2fetc/hostname: absolute path" + inside);
  EXPECT_EQ(lineOfUri("file:///etc/hostname"), "buffer 0: file:///etc/hostname" + relative);
  EXPECT_EQ(lineOfUri("http://127.0.0.1/x"), "buffer 0: http://127.0.0.1/x" + relative);
  EXPECT_EQ(lineOfUri("a\\\\b.bin"), "buffer 0: a\\b.bin: URI with a backslash");
  EXPECT_EQ(lineOfUri("a\\u0000.bin"), "buffer 0: a?.bin: URI with a NUL character");
  EXPECT_EQ(lineOfUri(""), "buffer 0: : URI is empty");
}

TEST_F(GltfFiles, ReadsRegularFilesOnly) {
  fs::create_directories(folder_ / "dir.bin");
  ASSERT_EQ(::mkfifo(path("pipe.bin").c_str(), 0600), 0);
  EXPECT_EQ(lineOfUri("missing.bin"), "buffer 0: missing.bin: No such file or directory");
  EXPECT_EQ(lineOfUri("dir.bin"), "buffer 0: dir.bin: is not a regular file");
  EXPECT_EQ(lineOfUri("pipe.bin"), "buffer 0: pipe.bin: is not a regular file");
  EXPECT_EQ(lineOf("pipe.bin"), "file: is not a regular file");
  EXPECT_EQ(lineOf("missing.glb"), "file: No such file or directory");
}

TEST_F(GltfFiles, RefusesFilesThatAreShorterThanAnnounced) {
  Bytes bytes = triangleBytes();
  bytes.pop_back();
  write("short.bin", bytes);
  EXPECT_EQ(lineOfUri("short.bin"), "buffer 0: short.bin: has 35 bytes, 36 are needed");
}

TEST_F(GltfFiles, CountsExternalBuffersForTheLimit) {
  write("part.bin", triangleBytes());
  writeScene("scene.gltf", "part.bin");
  LoadOptions options;
  options.limits.max_file_bytes = fs::file_size(folder_ / "scene.gltf") + 35;
  EXPECT_EQ(lineOf("scene.gltf", options), "buffer 0: part.bin: 36 bytes > limit of 35");
  options.limits.max_file_bytes += 1;
  EXPECT_EQ(lineOf("scene.gltf", options), "");
}

TEST_F(GltfFiles, OpensNoBuffersWhenLoadingFromMemory) {
  GltfFile file;
  file.mesh(file.positions(kTriangle));
  file.nodeWith(0);
  file.buffers(R"({"byteLength":36,"uri":"part.bin"})");
  EXPECT_EQ(errorOf(bytesOf(file.json())),
            "t.glb: buffer 0: part.bin: external buffers are not read here");
}

TEST_F(GltfFiles, NeverOpensImages) {
  GltfFile file;
  file.mesh(file.positions(kTriangle));
  file.nodeWith(0);
  file.top(R"("images":[{"uri":"missing.png"},{"uri":"/dev/zero"},{"bufferView":99}],
              "textures":[{"source":0}])");
  EXPECT_EQ(errorOf(file.glb()), "");
}

}  // namespace
}  // namespace culld::test
