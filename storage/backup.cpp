// SPDX-License-Identifier: Apache-2.0
#include "storage/backup.hpp"

#include <sqlite3.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <future>
#include <memory>
#include <string_view>
#include <utility>

#include "base/whole_file.hpp"
#include "storage/chain.hpp"
#include "storage/database.hpp"
#include "storage/writer_lock.hpp"

namespace lcrig {

namespace {

namespace fs = std::filesystem;

// 256 pages of 4 kB are 1 MB. Syncing after every few steps keeps each sync short; one long sync
// would hold up a commit of the recorder.
constexpr int kPagesOfStep = 256, kStepsOfSync = 4;

sqlite3* handle_of(const Statement& statement) {
  return sqlite3_db_handle(statement.handle());
}

// "folder/name", with all links on the way resolved; the file itself need not exist.
fs::path place_of(const std::string& path) {
  std::error_code unknown;
  const auto absolute = fs::absolute(path, unknown);
  return fs::weakly_canonical(absolute.parent_path(), unknown) / absolute.filename();
}

Result<> require_free_name(const std::string& from, const std::string& to) {
  struct ::stat there{};
  struct ::stat original{};
  if (to.empty() || to.back() == '/') {
    return fail(Errc::invalid_request, "`{}`: a folder; name a file in it", to);
  }
  if (::stat(to.c_str(), &there) == 0) {
    if (::stat(from.c_str(), &original) == 0 && there.st_dev == original.st_dev &&
        there.st_ino == original.st_ino) {
      return fail(Errc::invalid_request, "{}: is the database itself; name another file", to);
    }
    if (S_ISDIR(there.st_mode)) {
      return fail(Errc::invalid_request, "{}: is a folder; name a file in it, such as {}", to,
                  (fs::path(to) / "copy-of-lcrig.db").string());
    }
    if (!S_ISREG(there.st_mode)) {
      return fail(Errc::invalid_request,
                  "{}: is a pipe or a device; what is written is read again to check it: name a "
                  "file",
                  to);
    }
  }
  if (::lstat(to.c_str(), &there) != 0) return {};
  return fail(Errc::invalid_request, "{}: is there already, and no copy overwrites anything", to);
}

// SQLite would take a log or journal beside the new file for that of the copy, and write its pages
// into the copy.
Result<> require_free_companions(const std::string& from, const std::string& to) {
  if (auto other = require_no_companion(from, to); !other) return other;
  for (const char* suffix : {"-wal", "-shm", "-journal"}) {
    struct ::stat ignored{};
    const auto beside = to + suffix;
    if (::lstat(beside.c_str(), &ignored) != 0) continue;
    return fail(Errc::invalid_request,
                "{}: the log of a database that was there before; move it away, or name another "
                "file",
                beside);
  }
  return {};
}

Result<> require_room(const std::string& from, const std::string& to, std::int64_t bytes) {
  const auto folder = place_of(to).parent_path();
  struct ::stat there{};
  struct ::stat original{};
  if (::stat(folder.c_str(), &there) != 0) {
    return fail(Errc::io, "{}: {}; make the folder first", folder.string(), std::strerror(errno));
  }
  const bool shared = ::stat(from.c_str(), &original) == 0 && there.st_dev == original.st_dev;
  const auto needed = static_cast<std::uintmax_t>(bytes) + (shared ? kLeftToRecorder : 0);
  std::error_code unknown;
  const auto space = fs::space(folder, unknown);
  if (unknown || space.available >= needed) return {};
  return fail(Errc::io, "{}: {:.1f} MB are free, and the copy needs {:.1f} MB{}: free some space",
              folder.string(), static_cast<double>(space.available) / 1e6,
              static_cast<double>(needed) / 1e6,
              shared ? ", with what is left to the recorder" : "");
}

struct EndBackup {
  void operator()(sqlite3_backup* backup) const { sqlite3_backup_finish(backup); }
};

class Copy {
 public:
  Copy(std::string from, std::string to, CopyOptions options)
      : from_(std::move(from)), to_(std::move(to)), options_(std::move(options)) {}

  Result<CopyReport> make() {
    if (auto free = require_free_name(from_, to_); !free) return fail(free.error());
    if (auto free = require_free_companions(from_, to_); !free) return fail(free.error());
    if (auto r = keep(open_read_only(from_), original_); !r) return fail(r.error());
    if (options_.check_original) {
      if (auto sound = check_pages(original_); !sound) return fail(sound.error());
    }
    auto part = copied();
    if (!part) return fail(part.error());
    if (auto checked = check(part->name()); !checked) return fail(checked.error());
    if (auto named = part->put_new(); !named) return fail(named.error());
    return report_;
  }

 private:
  // Writes and syncs the copy, but does not check it. One read transaction spans all steps;
  // otherwise each commit of the recorder would restart the copy.
  Result<PartFile> copied() {
    auto snapshot = Transaction::begin_read(original_);
    if (!snapshot) return fail(snapshot.error());
    auto pages = original_.integer("PRAGMA page_count");
    if (!pages) return fail(pages.error());
    auto page_bytes = original_.integer("PRAGMA page_size");
    if (!page_bytes) return fail(page_bytes.error());
    auto tables = original_.integer("SELECT count(*) FROM sqlite_schema");  // a first read, which
                                                                            // fixes the state that
                                                                            // is copied
    if (!tables) return fail(tables.error());
    report_.bytes = *pages * *page_bytes;
    if (auto room = require_room(from_, to_, report_.bytes); !room) return fail(room.error());
    auto part = PartFile::create(to_);
    if (!part) return part;
    if (auto done = copy_pages(*part); !done) return fail(done.error());
    return part;
  }

  Result<> copy_pages(const PartFile& part) {
    auto copy = Database::open(part.name(), Database::Mode::read_write_create, options_.vfs);
    if (!copy) return fail(copy.error());
    // No journal or sync is needed: nobody reads the copy before all of it is synced and checked.
    if (auto r = copy->execute("PRAGMA journal_mode = OFF; PRAGMA synchronous = OFF"); !r) return r;
    const auto to = copy->prepare("SELECT 1");
    const auto from = original_.prepare("SELECT 1");
    if (!to || !from) return fail(to ? from.error() : to.error());
    const std::unique_ptr<sqlite3_backup, EndBackup> backup(
        sqlite3_backup_init(handle_of(*to), "main", handle_of(*from), "main"));
    if (!backup) return fail(copy->error("copy"));
    int code = SQLITE_OK;
    for (int step = 1; code == SQLITE_OK; ++step) {
      if (!goes_on()) return stopped();
      code = sqlite3_backup_step(backup.get(), kPagesOfStep);
      if (step % kStepsOfSync == 0) ::fdatasync(part.fd());
    }
    if (code == SQLITE_DONE) return {};
    if ((code & 0xff) == SQLITE_FULL) {
      return fail(Errc::io, "{}: no space is left on this disk: free some", to_);
    }
    return fail(Errc::io, "{}: {} ({}); check the disk of {}", to_, sqlite3_errstr(code), code,
                from_);
  }

  Result<> check(const std::string& name) {
    auto copy = open_read_only(name);
    if (!copy) return fail(copy.error());
    if (auto sound = check_pages(*copy); !sound) return why_damaged(sound);
    auto runs =
        copy->rows<std::int64_t>("SELECT id FROM run UNION SELECT run_id FROM chain ORDER BY 1");
    if (!runs) return fail(runs.error());
    report_.runs = static_cast<std::int64_t>(runs->size());
    for (const std::int64_t run : *runs) {
      if (!goes_on()) return stopped();
      if (auto checked = check_run(*copy, run); !checked) return checked;
    }
    return {};
  }

  Result<> check_run(const Database& copy, std::int64_t run) {
    auto chain = verify_chain(copy, run);
    if (!chain) return fail(chain.error());
    report_.rows += chain->rows;
    if (chain->not_closed) {
      report_.without_end.push_back(run);
      return {};
    }
    if (chain->intact) return {};
    const auto before = verify_chain(original_, run);
    if (!before) return fail(before.error());
    if (before->finding != chain->finding) {
      return fail(Errc::io, "{}: run {} was not copied as it is ({}): check the disk", to_, run,
                  chain->finding);
    }
    BrokenRun broken;
    broken.run = run;
    broken.finding = chain->finding;
    report_.broken.push_back(std::move(broken));
    return {};
  }

  // The progress handler lets a stop interrupt the check.
  Result<> check_pages(const Database& db) {
    auto statement = db.prepare("PRAGMA integrity_check(1)");
    if (!statement) return fail(statement.error());
    constexpr int kInstructions = 1'000'000;
    sqlite3_progress_handler(
        handle_of(*statement), kInstructions,
        [](void* copy) { return static_cast<Copy*>(copy)->goes_on() ? 0 : 1; }, this);
    const auto row = statement->step();
    std::string words = row && *row ? std::string(statement->text(0)) : "";
    sqlite3_progress_handler(handle_of(*statement), 0, nullptr, nullptr);
    if (stopped_) return stopped();
    if (!row) words = row.error().what;
    if (words == "ok") return {};
    const bool is_original = &db == &original_;
    return fail(Errc::io, "{}: is damaged ({}); {}", is_original ? from_ : to_, words,
                is_original ? "use an older copy of it" : "it was removed: check the disk");
  }
  // Blames the original when it is damaged, too: the copy is then as good as it can be.
  Result<> why_damaged(const Result<>& of_copy) {
    if (stopped_) return of_copy;
    auto of_original = check_pages(original_);
    return of_original ? of_copy : of_original;
  }

  bool goes_on() {
    stopped_ = stopped_ || (options_.goes_on && !options_.goes_on());
    return !stopped_;
  }
  Result<> stopped() const { return fail(Errc::aborted, "{}: stopped; nothing was kept", to_); }

  std::string from_, to_;
  CopyOptions options_;
  Database original_;
  CopyReport report_;
  bool stopped_ = false;
};

}  // namespace

void give_way() {
  constexpr int kThisThread = 1, kIdleClass = 3 << 13;
  ::setpriority(PRIO_PROCESS, 0, 10);
  ::syscall(SYS_ioprio_set, kThisThread, 0, kIdleClass);
}

Result<> require_no_companion(const std::string& from, const std::string& to) {
  constexpr std::array kCompanions{"-wal", "-shm", "-journal", ".lock", ".writer", ".reserve"};
  for (const char* suffix : kCompanions) {
    if (place_of(beside_database(from, suffix)) != place_of(to)) continue;
    return fail(Errc::invalid_request, "{}: belongs to the database {}; name another file", to,
                from);
  }
  for (const std::string_view suffix : {"-wal", "-shm", "-journal"}) {
    if (!to.ends_with(suffix)) continue;
    return fail(Errc::invalid_request,
                "{}: SQLite takes a file of this name for a log of `{}`, and removes it; name "
                "another file",
                to, to.substr(0, to.size() - suffix.size()));
  }
  return {};
}

Result<CopyReport> copy_database(const std::string& from, const std::string& to,
                                 CopyOptions options) {
  const auto copy = [&]() -> Result<CopyReport> {
    give_way();
    return Copy(from, to, std::move(options)).make();
  };
  return std::async(std::launch::async, copy).get();
}

}  // namespace lcrig
