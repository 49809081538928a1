#include "server/scene_seal.h"

#include <bit>
#include <cstring>
#include <string>

namespace culld::server {
namespace {

static_assert(std::endian::native == std::endian::little, "stored numbers are little-endian");

constexpr char kMagic[] = {'C', 'L', 'D', 'S', 'C', 'E', 'N', 'E'};
constexpr std::uint32_t kVersion = 1;

struct Layout {
  char magic[8];
  std::uint32_t version;
  std::uint32_t zero;
  std::uint64_t size;
  Digest digest;
  std::uint64_t check;
};
static_assert(sizeof(Layout) == kSealBytes);

std::uint64_t checkOf(const Layout& seal) {
  return checksumOf(std::as_bytes(std::span(&seal, 1)).first(offsetof(Layout, check)));
}

}  // namespace

Seal makeSeal(std::uint64_t size, const Digest& digest) {
  Layout seal{};
  std::memcpy(seal.magic, kMagic, sizeof(kMagic));
  seal.version = kVersion;
  seal.size = size;
  seal.digest = digest;
  seal.check = checkOf(seal);
  return std::bit_cast<Seal>(seal);
}

Result<std::span<const std::byte>> openSealed(std::span<const std::byte> file) {
  Layout seal{};
  if (file.size() >= kSealBytes) std::memcpy(&seal, file.last(kSealBytes).data(), kSealBytes);
  if (std::memcmp(seal.magic, kMagic, sizeof(kMagic)) != 0) {
    return invalidInput("does not end with a seal of culld: cut short, or no stored scene");
  }
  if (seal.check != checkOf(seal)) return invalidInput("the seal at the end is damaged");
  if (seal.version != kVersion) {
    return invalidInput("stored in version " + std::to_string(seal.version) +
                        ", and this culld reads version " + std::to_string(kVersion));
  }
  const auto content = file.first(file.size() - kSealBytes);
  if (seal.size != content.size()) {
    return invalidInput("holds " + std::to_string(content.size()) + " bytes where " +
                        std::to_string(seal.size) + " were stored");
  }
  Checksum sum;
  sum.add(content);
  if (sum.digest() != seal.digest) {
    return invalidInput("the content is damaged: its checksum does not fit");
  }
  return content;
}

}  // namespace culld::server
