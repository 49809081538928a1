#include "culling/scene/gltf_container.h"

#include <cstdint>
#include <cstring>
#include <string>

#include "culling/scene/gltf_failure.h"

namespace culld::gltf {
namespace {

constexpr std::uint32_t kMagic = 0x46546C67;      // "glTF"
constexpr std::uint32_t kJsonChunk = 0x4E4F534A;  // "JSON"
constexpr std::uint32_t kBinChunk = 0x004E4942;   // "BIN"
constexpr std::size_t kHeaderBytes = 12;
constexpr std::size_t kChunkHeaderBytes = 8;

std::uint32_t wordAt(std::span<const std::byte> file, std::size_t offset) {
  std::uint32_t word = 0;
  std::memcpy(&word, file.data() + offset, sizeof word);  // GLB and this machine: little-endian
  return word;
}

std::string_view asText(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

struct Chunk {
  std::uint32_t type = 0;
  std::span<const std::byte> bytes;
};

/// The chunk at `offset`, which moves behind it.
Chunk nextChunk(std::span<const std::byte> file, std::size_t& offset) {
  const std::string place = "chunk at byte " + std::to_string(offset);
  if (file.size() - offset < kChunkHeaderBytes) fail(place, "its header is cut off");
  const std::uint32_t length = wordAt(file, offset);
  const std::uint32_t type = wordAt(file, offset + 4);
  offset += kChunkHeaderBytes;
  if (length > file.size() - offset) {
    fail(place, std::to_string(length) + " bytes announced, " +
                    std::to_string(file.size() - offset) + " left in the file");
  }
  const Chunk chunk{type, file.subspan(offset, length)};
  offset += length;
  return chunk;
}

Container openGlb(std::span<const std::byte> file) {
  if (file.size() < kHeaderBytes) fail("header", "the file ends within it");
  if (wordAt(file, 4) != 2) {
    fail("header", "GLB version " + std::to_string(wordAt(file, 4)) + " instead of 2");
  }
  const std::uint32_t total = wordAt(file, 8);
  if (total > file.size()) {
    fail("header",
         std::to_string(total) + " bytes announced, the file has " + std::to_string(file.size()));
  }
  if (total < kHeaderBytes) fail("header", std::to_string(total) + " bytes announced");
  file = file.first(total);  // what follows the announced end is not glTF's

  std::size_t offset = kHeaderBytes;
  Container container;
  container.is_glb = true;
  if (offset == file.size()) fail("header", "no JSON chunk follows");
  const Chunk json = nextChunk(file, offset);
  if (json.type != kJsonChunk) fail("chunk at byte 12", "the first chunk is not JSON");
  container.json = asText(json.bytes);
  // Chunks are padded to four bytes: with spaces says the standard, with zeros say old exporters.
  for (int i = 0; i < 3 && container.json.ends_with('\0'); ++i) container.json.remove_suffix(1);
  while (offset < file.size()) {
    const Chunk chunk = nextChunk(file, offset);
    if (chunk.type == kJsonChunk) fail("container", "two JSON chunks");
    if (chunk.type != kBinChunk) continue;  // other chunks are for extensions
    if (container.has_binary) fail("container", "two BIN chunks");
    container.binary = chunk.bytes;
    container.has_binary = true;
  }
  return container;
}

}  // namespace

Container openContainer(std::span<const std::byte> file) {
  if (file.empty()) fail("file", "is empty");
  if (file.size() >= 4 && wordAt(file, 0) == kMagic) return openGlb(file);
  Container container;
  container.json = asText(file);
  const auto first = container.json.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
  if (first == std::string_view::npos || container.json[first] != '{') {
    fail("file", "is neither GLB nor a JSON object");
  }
  return container;
}

}  // namespace culld::gltf
