#include "server/edit_store.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstring>

#include "server/checksum.h"
#include "server/scene_names.h"

namespace culld::server {
namespace {

namespace fs = std::filesystem;

constexpr const char* kDatabase = "edits.db";
constexpr const char* kMark = "mark";
constexpr std::string_view kUnfinished = "~tmp~";  // no scene name begins so, not even "tmp"
constexpr int kLongLog = 1000;                     // pages, about 4 MB

struct StoreName {
  std::string name, key;
  std::uint64_t serial = 0;
};

/// "NAME~u0123456789abcdef~0123456789abcdef"
std::optional<StoreName> storeName(const std::string& folder) {
  const auto first = folder.find('~');
  const auto second = folder.find('~', first == std::string::npos ? first : first + 1);
  if (second == std::string::npos) return std::nullopt;
  StoreName out{folder.substr(0, first), folder.substr(first + 1, second - first - 1), 0};
  const auto serial = fromHex16(std::string_view(folder).substr(second + 1));
  const bool known = !out.key.empty() && (out.key.front() == 'u' || out.key.front() == 'f') &&
                     fromHex16(std::string_view(out.key).substr(1)).has_value();
  if (!serial || !known || !validOwnedName(out.name)) return std::nullopt;
  out.serial = *serial;
  return out;
}

std::vector<std::string> entriesOf(const fs::path& folder, std::error_code& failure) {
  std::vector<std::string> entries;
  fs::directory_iterator entry(folder, failure);
  for (; !failure && entry != fs::directory_iterator(); entry.increment(failure)) {
    entries.push_back(entry->path().filename().string());
  }
  std::sort(entries.begin(), entries.end());
  return entries;
}

/// Half a store must never look like one: it loses its name first.
void removeStore(const fs::path& folder, const std::string& entry) {
  const fs::path gone = folder / (std::string(kUnfinished) + entry);
  std::error_code ignored;  // what stays is removed at the next start
  if (renamePath(folder / entry, gone)) fs::remove_all(gone, ignored);
}

/// The last state that was acknowledged. The log of the database ends where its checksums end, so a
/// flipped bit in it would look like an end; the mark tells.
struct Mark {
  char magic[8];
  EditTotals totals;
  std::uint64_t check;
};
static_assert(sizeof(Mark) == 40);

std::uint64_t checkOf(const Mark& mark) {
  return checksumOf(std::as_bytes(std::span(&mark, 1)).first(offsetof(Mark, check)));
}

Mark makeMark(const EditTotals& totals) {
  Mark mark{{'C', 'L', 'D', 'M', 'A', 'R', 'K', '1'}, totals, 0};
  mark.check = checkOf(mark);
  return mark;
}

/// The mark has two places, written in turn: one that was being written when the process ended or
/// the disk was full must not make the store look damaged.
using Marks = std::array<Mark, 2>;

bool valid(const Mark& mark) {
  return std::memcmp(mark.magic, makeMark({}).magic, sizeof(mark.magic)) == 0 &&
         mark.check == checkOf(mark);
}

Result<void> compareMark(const FileDescriptor& file, const EditTotals& totals) {
  Marks marks{};
  char more = 0;
  const bool whole = ::pread(file.get(), &marks, sizeof(marks), 0) == ssize_t{sizeof(marks)} &&
                     ::pread(file.get(), &more, 1, sizeof(marks)) == 0;
  if (!whole || (!valid(marks[0]) && !valid(marks[1]))) {
    return invalidInput("damaged: the mark of the last edit");
  }
  const bool second =
      !valid(marks[0]) || (valid(marks[1]) && marks[1].totals.version > marks[0].totals.version);
  const EditTotals& last = marks[second ? 1 : 0].totals;
  // The mark follows the commit, so the edits may be one group ahead of it, and never behind.
  const bool behind = totals.version < last.version;
  if (!behind && (totals.version > last.version || totals == last)) return Done{};
  return invalidInput("damaged: edits up to version " + std::to_string(last.version) +
                      " were acknowledged, and those up to " + std::to_string(totals.version) +
                      (behind ? " are there" : " are not the same"));
}

EditRow rowOf(ObjectId id, const std::optional<ObjectId>& like, bool moved,
              const Instance& instance) {
  EditRow row{id, like, instance.hidden, instance.removed, std::nullopt};
  if (like || moved) row.world_from_mesh = instance.world_from_mesh;
  return row;
}

/// Rows as edits that have the same effect in this order: objects are added while those that they
/// are like are still there.
Result<std::vector<Edit>> editsOf(const std::vector<EditRow>& rows, std::size_t objects) {
  std::vector<Edit> adds, changes, removals;
  for (const EditRow& row : rows) {
    const auto wrong = invalidInput("object " + std::to_string(row.object) + " is not the scene's");
    if (row.like.has_value() != (row.object >= objects)) return wrong;
    if (row.like) {
      if (row.object != objects + adds.size() || !row.world_from_mesh) return wrong;
      adds.emplace_back(AddInstance{*row.like, *row.world_from_mesh});
    } else if (row.world_from_mesh) {
      changes.emplace_back(MoveObject{row.object, *row.world_from_mesh});
    }
    if (row.hidden) changes.emplace_back(HideObject{row.object});
    if (row.removed) removals.emplace_back(RemoveObject{row.object});
  }
  adds.insert(adds.end(), changes.begin(), changes.end());
  adds.insert(adds.end(), removals.begin(), removals.end());
  return adds;
}

}  // namespace

std::string keyOfUpload(std::uint64_t serial) { return "u" + hex16(serial); }
std::string keyOfContent(std::uint64_t content_hash) { return "f" + hex16(content_hash); }

EditStore::EditStore(fs::path folder, std::string name, std::string key, SerialSource& serials)
    : folder_(std::move(folder)), name_(std::move(name)), key_(std::move(key)), serials_(serials) {}

EditStore::~EditStore() {
  if (database_) (void)database_->checkpoint();  // or the next start does it
}

Error EditStore::named(Error error) const {
  const std::string where = path_.empty() ? name_ : path_.filename().string();
  return {error.code, "edits of scene \"" + name_ + "\" (" + where + "): " + error.message};
}

Result<std::optional<EditedScene>> EditStore::load(const SnapshotPtr& base) {
  std::error_code failure;
  std::vector<std::string> mine;  // ascending by serial
  for (std::string& entry : entriesOf(folder_, failure)) {
    const auto store = storeName(entry);
    if (store && store->name == name_ && store->key == key_) mine.push_back(std::move(entry));
  }
  if (failure) return named({ErrorCode::kIo, "cannot read: " + failure.message()});
  if (mine.empty()) return std::optional<EditedScene>();
  path_ = folder_ / mine.back();
  if (auto opened = openMade(); !opened) return named(opened.error());
  auto contents = database_->read();
  const auto fail = [this](Error error) {
    database_.reset();
    return named(std::move(error));
  };
  if (!contents) return fail(contents.error());
  if (auto same = compareMark(mark_, contents.value().totals); !same) return fail(same.error());
  const auto& rows = contents.value().rows;
  const auto edits = editsOf(rows, base->objectCount());
  if (!edits) return fail(edits.error());
  auto scene = restoreEdits(base, edits.value(), contents.value().totals.version);
  if (!scene) return fail(scene.error());
  for (const EditRow& row : rows) {
    touched_[row.object] = {row.like, row.world_from_mesh.has_value(), checksumOf(row)};
  }
  totals_ = contents.value().totals;
  // What the log holds may never have reached the disk; from here on it has, or a new store is
  // made.
  if (!database_->checkpoint() || !writeMark(totals_) || !writeMark(totals_)) database_.reset();
  mine.pop_back();
  for (const std::string& older : mine) removeStore(folder_, older);
  return std::optional<EditedScene>(std::move(scene).value());
}

Result<void> EditStore::openMade() {
  mark_ = FileDescriptor(::open((path_ / kMark).c_str(), O_RDWR | O_CLOEXEC));
  if (mark_.get() < 0) return ioError("cannot open the mark of the last edit");
  auto database = EditDatabase::open(path_ / kDatabase, owner());
  if (!database) return database.error();
  database_.emplace(std::move(database).value());
  return Done{};
}

/// All that is acknowledged in a new store, which takes the place of the one before, if any. Its
/// files are new, so a sync that succeeds speaks of all that is in them.
Result<void> EditStore::make(const SceneSnapshot& scene) {
  if (touched_.empty()) totals_ = {scene.version(), 0, 0};
  const std::string serial = hex16(serials_++);
  const fs::path unfinished = folder_ / (std::string(kUnfinished) + serial);
  const fs::path finished = folder_ / (name_ + "~" + key_ + "~" + serial);
  const auto giveUp = [&](Error error) {
    std::error_code ignored;  // or the next start removes it
    fs::remove_all(unfinished, ignored);
    return error;
  };
  if (::mkdir(unfinished.c_str(), 0777) != 0) return ioError("cannot make a folder");
  if (auto filled = fill(unfinished, scene); !filled) return giveUp(filled.error());
  MoveOutcome move = moveDurably(unfinished, finished, folder_);
  if (!move.moved) {
    if (!move.undone) halt("a failed write could not be undone; no more edits before a new start");
    return giveUp(move.moved.error());
  }
  const fs::path older = std::exchange(path_, finished);
  if (!older.empty()) removeStore(folder_, older.filename().string());
  return openMade();
}

Result<void> EditStore::fill(const fs::path& folder, const SceneSnapshot& scene) const {
  std::vector<EditRow> rows;
  rows.reserve(touched_.size());
  for (const auto& [id, touched] : touched_) {
    rows.push_back(rowOf(id, touched.like, touched.moved, scene.instance(id)));
  }
  if (auto made = EditDatabase::create(folder / kDatabase, owner(), rows, totals_); !made) {
    return made;
  }
  const FileDescriptor mark(::open((folder / kMark).c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0666));
  if (mark.get() < 0) return ioError("cannot make a mark");
  const Marks content{makeMark(totals_), makeMark(totals_)};
  if (auto w = writeAll(mark, std::as_bytes(std::span(content)), "mark"); !w) return w;
  if (::fsync(mark.get()) != 0) return ioError("cannot sync the mark");
  return syncFolder(folder);
}

Result<void> EditStore::writeMark(const EditTotals& totals) {
  const Mark mark = makeMark(totals);
  next_mark_ = 1 - next_mark_;
  const auto place = static_cast<off_t>(next_mark_ * sizeof(mark));
  if (::pwrite(mark_.get(), &mark, sizeof(mark), place) == ssize_t{sizeof(mark)}) return Done{};
  return ioError("cannot write the mark");
}

EditStore::TouchedObjects EditStore::touchedBy(const SceneSnapshot& before,
                                               std::span<const Edit> edits) const {
  TouchedObjects changed;
  auto next = static_cast<ObjectId>(before.objectCount());
  const auto at = [&](ObjectId id) -> Touched& {
    const auto known = touched_.find(id);
    return changed.try_emplace(id, known == touched_.end() ? Touched{} : known->second)
        .first->second;
  };
  for (const Edit& edit : edits) {
    if (const auto* add = std::get_if<AddInstance>(&edit)) {
      at(next++).like = add->like;
    } else if (const auto* move = std::get_if<MoveObject>(&edit)) {
      at(move->object).moved = true;
    } else if (const auto* hide = std::get_if<HideObject>(&edit)) {
      at(hide->object);
    } else if (const auto* show = std::get_if<ShowObject>(&edit)) {
      at(show->object);
    } else if (const auto* remove = std::get_if<RemoveObject>(&edit)) {
      at(remove->object);
    }
  }
  return changed;
}

Result<void> EditStore::commit(const SceneSnapshot& before, const SceneSnapshot& after,
                               std::span<const Edit> edits) {
  if (!halted_.empty()) return named({ErrorCode::kIo, halted_});
  if (!database_) {
    if (auto made = make(before); !made) return named(made.error());
  }
  TouchedObjects changed = touchedBy(before, edits);
  EditTotals totals{after.version(), totals_.rows, totals_.sum};
  std::vector<EditRow> rows;
  rows.reserve(changed.size());
  for (auto& [id, touched] : changed) {
    rows.push_back(rowOf(id, touched.like, touched.moved, after.instance(id)));
    totals.sum -= std::exchange(touched.checksum, checksumOf(rows.back()));
    totals.sum += touched.checksum;
    if (!touched_.contains(id)) ++totals.rows;
  }
  auto kept = database_->commit(rows, totals);
  bool repair = !kept && !database_->sound();
  if (kept) {
    kept = writeMark(totals);
    repair = !kept;  // the edits are on disk, and their client hears that they are not
  }
  if (repair) {  // by a new store without these edits; if that fails, the next commit begins with
                 // it
    database_.reset();
    (void)make(before);
  }
  if (!kept) return named(kept.error());
  for (const auto& [id, touched] : changed) {
    if (const auto known = touched_.find(id); known != touched_.end()) known->second = touched;
  }
  touched_.merge(changed);  // from the commit on nothing here may fail, not for memory either
  totals_ = totals;
  return Done{};
}

void EditStore::tidy() {
  if (!database_ || database_->logPages() < kLongLog) return;
  if (!database_->checkpoint()) database_.reset();
}

void EditStore::discard() {
  halt("the scene was removed or replaced");
  database_.reset();
  if (!path_.empty()) removeStore(folder_, path_.filename().string());
  path_.clear();
}

Result<std::unique_ptr<EditFolder>> EditFolder::open(const fs::path& folder,
                                                     SerialSource& serials) {
  if (auto made = makeFolder(folder); !made) return made.error();
  std::error_code failure;
  for (const std::string& entry : entriesOf(folder, failure)) {
    if (entry.starts_with(kUnfinished)) {
      std::error_code ignored;  // it stays in the way of nobody
      fs::remove_all(folder / entry, ignored);
    } else if (const auto store = storeName(entry)) {
      skipSerial(serials, store->serial);
      const auto key = fromHex16(std::string_view(store->key).substr(1));
      if (store->key.front() == 'u') skipSerial(serials, *key);
    }
  }
  if (failure) {
    return Error{ErrorCode::kIo, folder.string() + ": cannot read: " + failure.message()};
  }
  return std::unique_ptr<EditFolder>(new EditFolder(folder, serials));
}

std::unique_ptr<EditStore> EditFolder::storeOf(const std::string& name, const std::string& key) {
  return std::make_unique<EditStore>(folder_, name, key, serials_);
}

std::vector<std::string> EditFolder::sweep(const std::map<std::string, std::uint64_t>& scenes) {
  std::vector<std::string> foreign;
  std::error_code failure;
  for (const std::string& entry : entriesOf(folder_, failure)) {
    const auto store = storeName(entry);
    if (!store) {
      foreign.push_back((folder_ / entry).string() + ": not an edit store of culld; left alone");
    } else if (store->key.front() == 'u') {
      const auto scene = scenes.find(store->name);
      const bool current = scene != scenes.end() && keyOfUpload(scene->second) == store->key;
      if (!current) removeStore(folder_, entry);
    }
  }
  return foreign;
}

void EditFolder::removeStores(const std::string& name, Which which, const std::string& keep) {
  std::error_code failure;  // what cannot be listed is swept at the next start
  for (const std::string& entry : entriesOf(folder_, failure)) {
    const auto store = storeName(entry);
    if (!store || store->name != name || store->key == keep) continue;
    if (which == Which::kAll || store->key.front() == 'f') removeStore(folder_, entry);
  }
}

}  // namespace culld::server
