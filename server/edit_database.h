// The net edits of one scene in an SQLite file: one row per object that edits touched, and one that
// sums them up. Write-ahead log, synchronous=FULL: a commit that returned is on disk.
// SQLite checks its log but not its pages, so every row counts into a checksum of ours.
#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "culling/core/ids.h"
#include "culling/core/result.h"

namespace culld::server {

/// What edits made of one object.
struct EditRow {
  ObjectId object = 0;
  std::optional<ObjectId> like;  ///< it was added, as a further instance of this one's mesh
  bool hidden = false;
  bool removed = false;
  std::optional<std::array<double, 12>> world_from_mesh;  ///< it was moved or added
};
std::uint64_t checksumOf(const EditRow& row) noexcept;

/// Of all rows together.
struct EditTotals {
  std::uint64_t version = 0;  ///< of the scene
  std::uint64_t rows = 0;
  std::uint64_t sum = 0;  ///< of the rows' checksums, modulo 2^64
  bool operator==(const EditTotals&) const = default;
};

/// Errors are one line that does not name the scene: "cannot commit: disk I/O error (No space
/// ...)". THREADS: one at a time.
class EditDatabase {
 public:
  /// A new file with these rows; nothing of it is kept open. `owner` says whose edits they are.
  /// GUARANTEES: after success the file is on disk, its name not yet. ERROR: kIo.
  static Result<void> create(const std::filesystem::path& file, const std::string& owner,
                             std::span<const EditRow> rows, const EditTotals& totals);
  /// Reads only: a file that turns out damaged, and its log, stay as they were found.
  /// ERROR: kIo; kInvalidInput: not one of ours.
  static Result<EditDatabase> open(const std::filesystem::path& file, const std::string& owner);
  EditDatabase(EditDatabase&& other) noexcept;
  EditDatabase& operator=(EditDatabase&& other) noexcept;
  ~EditDatabase();

  struct Contents {
    std::vector<EditRow> rows;  ///< ascending by object
    EditTotals totals;
  };
  /// ERROR: kInvalidInput: damaged, or another owner's; kIo.
  Result<Contents> read();

  /// All or nothing. ERROR: kIo; see sound().
  Result<void> commit(std::span<const EditRow> rows, const EditTotals& totals);
  /// False once a failure has left open what is on disk: a sync that failed once may succeed the
  /// next time without having written anything, so nothing after it can be trusted.
  bool sound() const noexcept;
  /// Pages in the log; it grows until checkpoint().
  int logPages() const noexcept;
  /// Moves the log into the file. ERROR: kIo, and the database is not sound any more.
  Result<void> checkpoint();

 private:
  struct Impl;
  explicit EditDatabase(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace culld::server
