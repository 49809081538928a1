#include "server/edit_database.h"

#include <fcntl.h>
#include <sqlite3.h>
#include <unistd.h>

#include <bit>
#include <cerrno>
#include <cstring>

#include "server/checksum.h"
#include "server/disk.h"

namespace culld::server {
namespace {

static_assert(std::endian::native == std::endian::little, "stored numbers are little-endian");

constexpr int kFormat = 1;                   // PRAGMA user_version
constexpr int kApplication = 0x434c4445;     // "CLDE", PRAGMA application_id
constexpr std::size_t kTransformBytes = 96;  // 12 doubles

constexpr const char* kSchema =
    "CREATE TABLE state(one INTEGER PRIMARY KEY CHECK(one=1), owner TEXT NOT NULL,"
    " version INTEGER NOT NULL, rows INTEGER NOT NULL, sum INTEGER NOT NULL,"
    " checksum INTEGER NOT NULL);"
    "CREATE TABLE edits(object INTEGER PRIMARY KEY, like INTEGER, hidden INTEGER NOT NULL,"
    " removed INTEGER NOT NULL, world_from_mesh BLOB);";
constexpr const char* kWriteRow =
    "INSERT OR REPLACE INTO edits(object,like,hidden,removed,world_from_mesh) VALUES(?,?,?,?,?)";
constexpr const char* kWriteState =
    "INSERT OR REPLACE INTO state(one,owner,version,rows,sum,checksum) VALUES(1,?,?,?,?,?)";

std::uint64_t checksumOfState(const std::string& owner, const EditTotals& totals) {
  const std::array<std::uint64_t, 4> parts{
      checksumOf(std::as_bytes(std::span(owner.data(), owner.size()))), totals.version, totals.rows,
      totals.sum};
  return checksumOf(std::as_bytes(std::span(parts)));
}

/// What SQLite's words leave out. It keeps errno for some calls only.
std::string cause(sqlite3* db) {
  switch (sqlite3_extended_errcode(db)) {
    case SQLITE_FULL:
      return std::string(" (") + std::strerror(ENOSPC) + ")";
    case SQLITE_IOERR_FSYNC:
    case SQLITE_IOERR_DIR_FSYNC:
      return " at a sync";
    case SQLITE_IOERR_WRITE:
      return " at a write";
    case SQLITE_IOERR_TRUNCATE:
      return " at a truncation";
    case SQLITE_IOERR_READ:
    case SQLITE_IOERR_SHORT_READ:
      return " at a read";
    default:
      return "";
  }
}

Error failure(sqlite3* db, const std::string& what) {
  return {ErrorCode::kIo, what + ": " + sqlite3_errmsg(db) + cause(db)};
}

Error damaged(const std::string& what) { return invalidInput("damaged: " + what); }

class Statement {
 public:
  Statement(sqlite3* db, const char* sql) { sqlite3_prepare_v2(db, sql, -1, &statement_, nullptr); }
  ~Statement() { sqlite3_finalize(statement_); }
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  bool ready() const noexcept { return statement_ != nullptr; }
  void bind(int at, std::uint64_t value) {
    sqlite3_bind_int64(statement_, at, static_cast<sqlite3_int64>(value));
  }
  void bind(int at, const std::string& text) {
    sqlite3_bind_text(statement_, at, text.data(), static_cast<int>(text.size()), SQLITE_TRANSIENT);
  }
  void bindBytes(int at, const void* bytes, std::size_t size) {
    sqlite3_bind_blob(statement_, at, bytes, static_cast<int>(size), SQLITE_TRANSIENT);
  }
  void bindNull(int at) { sqlite3_bind_null(statement_, at); }
  /// SQLITE_ROW, SQLITE_DONE or an error.
  int step() { return sqlite3_step(statement_); }
  void reset() { sqlite3_reset(statement_); }
  bool isNull(int column) { return sqlite3_column_type(statement_, column) == SQLITE_NULL; }
  std::uint64_t number(int column) {
    return static_cast<std::uint64_t>(sqlite3_column_int64(statement_, column));
  }
  std::string text(int column) {
    const auto* bytes = static_cast<const char*>(sqlite3_column_blob(statement_, column));
    const int size = sqlite3_column_bytes(statement_, column);
    return bytes == nullptr ? std::string() : std::string(bytes, static_cast<std::size_t>(size));
  }

 private:
  sqlite3_stmt* statement_ = nullptr;
};

struct Connection {
  Connection() = default;
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;
  ~Connection() { sqlite3_close(db); }
  sqlite3* db = nullptr;
};

/// From the log into the file; the log is empty then.
Result<void> moveLog(sqlite3* db) {
  const int moved =
      sqlite3_wal_checkpoint_v2(db, nullptr, SQLITE_CHECKPOINT_TRUNCATE, nullptr, nullptr);
  if (moved != SQLITE_OK) return failure(db, "cannot move the log");
  return Done{};
}

Result<void> run(sqlite3* db, const char* sql, const std::string& what) {
  if (sqlite3_exec(db, sql, nullptr, nullptr, nullptr) != SQLITE_OK) return failure(db, what);
  return Done{};
}

/// The one value that a pragma gives.
Result<std::string> ask(sqlite3* db, const char* sql) {
  Statement statement(db, sql);
  if (!statement.ready() || statement.step() != SQLITE_ROW) return failure(db, "cannot read");
  return statement.text(0);
}

Result<void> writeRows(sqlite3* db, std::span<const EditRow> rows) {
  Statement statement(db, kWriteRow);
  if (!statement.ready()) return failure(db, "cannot write");
  for (const EditRow& row : rows) {
    statement.bind(1, row.object);
    row.like ? statement.bind(2, *row.like) : statement.bindNull(2);
    statement.bind(3, std::uint64_t{row.hidden});
    statement.bind(4, std::uint64_t{row.removed});
    row.world_from_mesh ? statement.bindBytes(5, row.world_from_mesh->data(), kTransformBytes)
                        : statement.bindNull(5);
    if (statement.step() != SQLITE_DONE) return failure(db, "cannot write");
    statement.reset();
  }
  return Done{};
}

Result<void> writeState(sqlite3* db, const std::string& owner, const EditTotals& totals) {
  Statement statement(db, kWriteState);
  if (!statement.ready()) return failure(db, "cannot write");
  statement.bind(1, owner);
  statement.bind(2, totals.version);
  statement.bind(3, totals.rows);
  statement.bind(4, totals.sum);
  statement.bind(5, checksumOfState(owner, totals));
  if (statement.step() != SQLITE_DONE) return failure(db, "cannot write");
  return Done{};
}

/// Settings of every connection. Exclusive: no shared memory file, the folder's lock keeps others
/// out. Nothing but checkpoint() moves the log, so that no failure of it goes unseen.
Result<void> setUp(sqlite3* db, const std::string& synchronous) {
  sqlite3_extended_result_codes(db, 1);
  sqlite3_db_config(db, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  const std::string settings =
      "PRAGMA locking_mode=EXCLUSIVE; PRAGMA wal_autocheckpoint=0; PRAGMA trusted_schema=OFF;"
      "PRAGMA cell_size_check=ON; PRAGMA mmap_size=0; PRAGMA synchronous=" +
      synchronous;
  return run(db, settings.c_str(), "cannot open");
}

Result<EditRow> readRow(Statement& statement) {
  EditRow row;
  const std::uint64_t object = statement.number(0);
  row.object = static_cast<ObjectId>(object);
  if (!statement.isNull(1)) row.like = static_cast<ObjectId>(statement.number(1));
  row.hidden = statement.number(2) != 0;
  row.removed = statement.number(3) != 0;
  if (!statement.isNull(4)) {
    const std::string bytes = statement.text(4);
    if (bytes.size() != kTransformBytes) return damaged("object " + std::to_string(object));
    std::memcpy(row.world_from_mesh.emplace().data(), bytes.data(), kTransformBytes);
  }
  if (object != row.object) return damaged("object " + std::to_string(object));
  return row;
}

/// A file that nobody knows yet needs no sync of each step; its maker syncs the whole.
Result<void> fill(const std::filesystem::path& file, const std::string& owner,
                  std::span<const EditRow> rows, const EditTotals& totals) {
  Connection made;
  constexpr int kFlags = SQLITE_OPEN_READWRITE | SQLITE_OPEN_EXRESCODE;
  if (sqlite3_open_v2(file.c_str(), &made.db, kFlags, nullptr) != SQLITE_OK) {
    return failure(made.db, "cannot make");
  }
  if (auto ready = setUp(made.db, "OFF"); !ready) return ready;
  const std::string marks =
      "PRAGMA journal_mode=WAL; PRAGMA application_id=" + std::to_string(kApplication) +
      "; PRAGMA user_version=" + std::to_string(kFormat) + "; BEGIN";
  if (auto begun = run(made.db, marks.c_str(), "cannot make"); !begun) return begun;
  if (auto tables = run(made.db, kSchema, "cannot make"); !tables) return tables;
  if (auto written = writeRows(made.db, rows); !written) return written;
  if (auto written = writeState(made.db, owner, totals); !written) return written;
  if (auto committed = run(made.db, "COMMIT", "cannot commit"); !committed) return committed;
  return moveLog(made.db);
}

Result<void> rollBack(sqlite3* db) {
  if (sqlite3_get_autocommit(db) != 0) return Done{};
  return run(db, "ROLLBACK", "cannot roll back");
}

}  // namespace

std::uint64_t checksumOf(const EditRow& row) noexcept {
  struct {
    std::uint64_t object, like;
    std::uint64_t flags;
    std::array<double, 12> world_from_mesh;
  } packed{row.object, row.like ? *row.like : ~std::uint64_t{0},
           std::uint64_t{row.hidden} + 2U * std::uint64_t{row.removed} +
               4U * std::uint64_t{row.world_from_mesh.has_value()},
           row.world_from_mesh.value_or(std::array<double, 12>{})};
  return checksumOf(std::as_bytes(std::span(&packed, 1)));
}

struct EditDatabase::Impl : Connection {
  static int countLog(void* self, sqlite3*, const char*, int pages) {
    static_cast<Impl*>(self)->log_pages = pages;
    return SQLITE_OK;
  }

  std::string owner;
  bool sound = true;
  int log_pages = 0;
};

EditDatabase::EditDatabase(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
EditDatabase::EditDatabase(EditDatabase&& other) noexcept = default;
EditDatabase& EditDatabase::operator=(EditDatabase&& other) noexcept = default;
EditDatabase::~EditDatabase() = default;

Result<void> EditDatabase::create(const std::filesystem::path& file, const std::string& owner,
                                  std::span<const EditRow> rows, const EditTotals& totals) {
  // Opened before anything is written, so that no failed write can be forgotten before its sync.
  const FileDescriptor whole(::open(file.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
  if (whole.get() < 0) return ioError("cannot make");
  if (auto filled = fill(file, owner, rows, totals); !filled) return filled;
  if (::fsync(whole.get()) != 0) return ioError("cannot sync");
  return Done{};
}

Result<EditDatabase> EditDatabase::open(const std::filesystem::path& file,
                                        const std::string& owner) {
  std::error_code missing;
  const auto size = std::filesystem::file_size(file, missing);
  if (missing) return Error{ErrorCode::kIo, "cannot open: " + missing.message()};
  // SQLite would take an empty file for a new database, and delete the log beside it.
  if (size == 0) return damaged("the database is empty");
  auto impl = std::make_unique<Impl>();
  impl->owner = owner;
  constexpr int kFlags = SQLITE_OPEN_READWRITE | SQLITE_OPEN_EXRESCODE;
  if (sqlite3_open_v2(file.c_str(), &impl->db, kFlags, nullptr) != SQLITE_OK) {
    return failure(impl->db, "cannot open");
  }
  sqlite3_db_config(impl->db, SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 1, nullptr);
  if (auto ready = setUp(impl->db, "FULL"); !ready) return ready.error();
  sqlite3_wal_hook(impl->db, &Impl::countLog, impl.get());
  return EditDatabase(std::move(impl));
}

Result<EditDatabase::Contents> EditDatabase::read() {
  sqlite3* db = impl_->db;
  const std::string& owner = impl_->owner;
  const auto application = ask(db, "PRAGMA application_id");
  if (!application) return application.error();
  if (application.value() != std::to_string(kApplication)) {
    return invalidInput("not an edit store of culld");
  }
  const auto format = ask(db, "PRAGMA user_version");
  if (!format) return format.error();
  if (format.value() != std::to_string(kFormat)) {
    return invalidInput("stored in version " + format.value() + ", and this culld reads version " +
                        std::to_string(kFormat));
  }
  const auto mode = ask(db, "PRAGMA journal_mode");
  if (!mode) return mode.error();
  if (mode.value() != "wal") return damaged("its journal mode is " + mode.value());
  const auto whole = ask(db, "PRAGMA integrity_check(1)");
  if (!whole) return whole.error();
  if (whole.value() != "ok") return damaged(whole.value());

  Contents contents;
  Statement state(db, "SELECT owner,version,rows,sum,checksum FROM state");
  if (!state.ready()) return failure(db, "cannot read");
  if (state.step() != SQLITE_ROW) return damaged("it holds no state");
  const EditTotals stored{state.number(1), state.number(2), state.number(3)};
  if (state.number(4) != checksumOfState(state.text(0), stored)) {
    return damaged("the checksum of its state does not fit");
  }
  if (state.text(0) != owner) {
    return invalidInput("holds the edits of " + state.text(0) + ", not of " + owner);
  }
  Statement rows(db,
                 "SELECT object,like,hidden,removed,world_from_mesh FROM edits ORDER BY object");
  if (!rows.ready()) return failure(db, "cannot read");
  int step = rows.step();
  for (; step == SQLITE_ROW; step = rows.step()) {
    auto row = readRow(rows);
    if (!row) return row.error();
    contents.totals.sum += checksumOf(row.value());
    ++contents.totals.rows;
    contents.rows.push_back(row.value());
  }
  if (step != SQLITE_DONE) return failure(db, "cannot read");
  contents.totals.version = stored.version;
  if (contents.totals != stored) return damaged("its rows do not fit their checksum");
  return contents;
}

Result<void> EditDatabase::commit(std::span<const EditRow> rows, const EditTotals& totals) {
  sqlite3* db = impl_->db;
  const auto attempt = [&]() -> Result<void> {
    if (auto begun = run(db, "BEGIN IMMEDIATE", "cannot write"); !begun) return begun;
    if (auto written = writeRows(db, rows); !written) return written;
    if (auto written = writeState(db, impl_->owner, totals); !written) return written;
    return run(db, "COMMIT", "cannot commit");
  };
  auto done = attempt();
  if (done) return done;
  // A full disk is found before anything counts as written; with everything else, who knows.
  const int code = sqlite3_extended_errcode(db);
  impl_->sound = rollBack(db).ok() && (code == SQLITE_FULL || code == SQLITE_IOERR_WRITE);
  return done;
}

bool EditDatabase::sound() const noexcept { return impl_->sound; }
int EditDatabase::logPages() const noexcept { return impl_->log_pages; }

Result<void> EditDatabase::checkpoint() {
  if (auto moved = moveLog(impl_->db); !moved) {
    impl_->sound = false;
    return moved;
  }
  impl_->log_pages = 0;
  return Done{};
}

}  // namespace culld::server
