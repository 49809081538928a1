#include "tests/bench/dump_file.h"

#include <cstring>
#include <fstream>
#include <iterator>
#include <span>

namespace culld::bench {
namespace {

constexpr std::uint32_t kDumpMagic = 0x31424C53, kTruthMagic = 0x31555254;  // "SLB1", "TRU1"
constexpr std::uint32_t kDumpVersion = 1;

/// Takes values off the front of a file's bytes; once it has run short, everything fails.
class Reader {
 public:
  explicit Reader(std::span<const char> bytes) : left_(bytes) {}

  template <typename T>
  T value() {
    T out{};
    std::vector<T> one;
    if (array(1, one)) out = one.front();
    return out;
  }

  template <typename T>
  bool array(std::size_t count, std::vector<T>& out) {
    static_assert(std::is_trivially_copyable_v<T>);
    if (short_ || left_.size() / sizeof(T) < count) {
      short_ = true;
      return false;
    }
    out.resize(count);
    if (count != 0) std::memcpy(out.data(), left_.data(), count * sizeof(T));
    left_ = left_.subspan(count * sizeof(T));
    return true;
  }

  bool ranShort() const { return short_; }
  bool atEnd() const { return !short_ && left_.empty(); }

 private:
  std::span<const char> left_;
  bool short_ = false;
};

Result<std::vector<char>> bytesOf(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) return invalidInput(file + ": cannot open");
  std::vector<char> bytes{std::istreambuf_iterator<char>(in), {}};
  if (in.bad()) return invalidInput(file + ": cannot read");
  return bytes;
}

Result<void> ends(const Reader& reader, const std::string& file) {
  if (reader.ranShort()) return invalidInput(file + ": ends too early");
  if (!reader.atEnd()) return invalidInput(file + ": has bytes after its end");
  return Done{};
}

Result<void> meshesFit(const Dump& dump, const std::string& file) {
  for (std::size_t m = 0; m < dump.meshes.size(); ++m) {
    const DumpMesh& mesh = dump.meshes[m];
    const std::uint64_t end = std::uint64_t{mesh.first_index} + mesh.index_count;
    const std::string where = file + ": mesh " + std::to_string(m);
    if (end > dump.indices.size() || mesh.index_count % 3 != 0) {
      return invalidInput(where + ": its triangles are not among the file's");
    }
    for (std::uint64_t i = mesh.first_index; i < end; ++i) {
      if (dump.indices[i] >= dump.vertices.size()) {
        return invalidInput(where + ": index " + std::to_string(dump.indices[i]) +
                            " >= " + std::to_string(dump.vertices.size()) + " vertices");
      }
    }
  }
  return Done{};
}

template <typename T>
void put(std::ofstream& out, std::span<const T> values) {
  out.write(reinterpret_cast<const char*>(values.data()),
            static_cast<std::streamsize>(values.size_bytes()));
}

template <typename T>
void put(std::ofstream& out, const std::vector<T>& values) {
  put(out, std::span<const T>(values));
}

std::uint32_t sizeOf(const auto& values) { return static_cast<std::uint32_t>(values.size()); }

}  // namespace

Result<Dump> readDump(const std::string& file) {
  auto bytes = bytesOf(file);
  if (!bytes) return std::move(bytes).error();
  Reader reader(bytes.value());
  const auto header = reader.value<std::array<std::uint32_t, 8>>();
  if (reader.ranShort() || header[0] != kDumpMagic || header[1] != kDumpVersion) {
    return invalidInput(file + ": not a dump of version 1");
  }
  Dump dump;
  reader.array(header[2], dump.vertices);
  reader.array(header[3], dump.indices);
  reader.array(header[4], dump.meshes);
  reader.array(header[5], dump.objects);
  reader.array(header[6], dump.cameras);
  if (auto whole = ends(reader, file); !whole) return std::move(whole).error();
  if (auto fit = meshesFit(dump, file); !fit) return std::move(fit).error();
  return dump;
}

Result<Truth> readTruth(const std::string& file, const Dump& dump) {
  auto bytes = bytesOf(file);
  if (!bytes) return std::move(bytes).error();
  Reader reader(bytes.value());
  const auto header = reader.value<std::array<std::uint32_t, 4>>();
  if (reader.ranShort() || header[0] != kTruthMagic) {
    return invalidInput(file + ": not a truth file");
  }
  Truth truth{header[1], header[2], {}};
  for (std::uint32_t f = 0; f < header[3] && !reader.ranShort(); ++f) {
    const auto head = reader.value<std::array<std::uint32_t, 4>>();
    TruthFrame frame{head[0], head[1], {}};
    reader.array(head[2], frame.seen);
    const std::string where = file + ": frame " + std::to_string(f);
    if (frame.camera >= dump.cameras.size()) return invalidInput(where + ": no such camera");
    for (const auto& [object, samples] : frame.seen) {
      if (object >= dump.objects.size()) return invalidInput(where + ": no such object");
    }
    truth.frames.push_back(std::move(frame));
  }
  if (auto whole = ends(reader, file); !whole) return std::move(whole).error();
  return truth;
}

void writeDump(const std::string& file, const Dump& dump) {
  std::ofstream out(file, std::ios::binary);
  const std::vector<std::uint32_t> header{
      kDumpMagic,          kDumpVersion,         sizeOf(dump.vertices), sizeOf(dump.indices),
      sizeOf(dump.meshes), sizeOf(dump.objects), sizeOf(dump.cameras),  0};
  put(out, header);
  put(out, dump.vertices);
  put(out, dump.indices);
  put(out, dump.meshes);
  put(out, dump.objects);
  put(out, dump.cameras);
}

void writeTruth(const std::string& file, const Truth& truth) {
  std::ofstream out(file, std::ios::binary);
  put(out,
      std::vector<std::uint32_t>{kTruthMagic, truth.width, truth.height, sizeOf(truth.frames)});
  for (const TruthFrame& frame : truth.frames) {
    put(out,
        std::vector<std::uint32_t>{frame.camera, frame.objects_in_frustum, sizeOf(frame.seen), 0});
    put(out, frame.seen);
  }
}

}  // namespace culld::bench
