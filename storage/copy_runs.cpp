// SPDX-License-Identifier: Apache-2.0
#include "storage/copy_runs.hpp"

#include <fcntl.h>
#include <fmt/ranges.h>
#include <sqlite3.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <future>
#include <optional>
#include <utility>

#include "storage/backup.hpp"
#include "storage/chain.hpp"
#include "storage/copied_from.hpp"
#include "storage/database.hpp"
#include "storage/migrations.hpp"
#include "storage/runs.hpp"
#include "storage/writer_lock.hpp"

namespace lcrig {

namespace {

namespace fs = std::filesystem;

// Tables whose first column is the number of the run, ordered so that each row is copied after the
// rows that it refers to. The queue is not copied, because it belongs to a rig.
constexpr std::array kTablesOfRun{"run",        "run_end",     "run_note",     "level",
                                  "event",      "lcr_reading", "frame_sample", "chain",
                                  "run_anchor", "run_tag",     "run_made"};
// Rows, some megabytes, between two checks of the free space and for a stop.
constexpr std::int64_t kRowsOfStep = 32'768;

std::optional<struct ::stat> look_at(const std::string& path) {
  struct ::stat out{};
  if (::stat(path.c_str(), &out) != 0) return std::nullopt;
  return out;
}

// Refuses a target that cannot hold a copy at all.
Result<> require_possible(const std::string& from, const std::string& to) {
  if (to.empty() || to.back() == '/') {
    return fail(Errc::invalid_request, "`{}`: a folder; name a file in it", to);
  }
  if (auto other = require_no_companion(from, to); !other) return other;
  const auto there = look_at(to);
  if (auto safe = require_safe_to_create(to); !safe) return safe;
  if (!there) return {};
  const auto original = look_at(from);
  if (original && there->st_dev == original->st_dev && there->st_ino == original->st_ino) {
    return fail(Errc::invalid_request,
                "{}: is the database itself, whose runs it has; name another", to);
  }
  if (!S_ISREG(there->st_mode)) {
    return fail(Errc::invalid_request, "{}: is a folder, a pipe or a device; name a file", to);
  }
  // SQLite keeps its log under the file's name, so two names of one file would have two logs.
  if (there->st_nlink > 1) {
    return fail(Errc::invalid_request,
                "{}: has {} names (hard links), and SQLite loses commits in such a file; remove "
                "the others",
                to, there->st_nlink);
  }
  return {};
}

Result<> require_same_schema(const Database& db, std::int64_t ours) {
  auto schema = db.integer("PRAGMA user_version");
  if (!schema) return fail(schema.error());
  if (*schema == ours) return {};
  return fail(Errc::invalid_request,
              "{}: schema {} is older than that of this lcrig ({}), and runs are copied only "
              "between databases of the same; record into it once, which brings it up to date, or "
              "name another",
              db.path(), *schema, ours);
}

class RunCopy {
 public:
  RunCopy(std::string from, std::string to, RunCopyOptions options)
      : from_(std::move(from)), to_(std::move(to)), options_(std::move(options)) {}

  Result<std::vector<CopiedRun>> make(std::vector<std::int64_t> runs) {
    std::ranges::sort(runs);
    const auto twice = std::ranges::unique(runs);
    runs.erase(twice.begin(), twice.end());
    if (auto r = open_source(runs); !r) return fail(r.error());
    if (auto r = require_possible(from_, to_); !r) return fail(of_target(r.error()));
    if (auto r = look_at_target(); !r) return fail(of_target(r.error()));
    auto lock = WriterLock::acquire(to_);
    if (!lock) return fail(of_target(lock.error()));
    auto copied = copy_all(runs);
    target_ = Database();
    if (copied) return copied;
    if (created_) remove_target();
    return fail(of_target(copied.error()));
  }

 private:
  // After the runs were found sound, every error is about the target, except a stop and a source
  // that becomes unreadable. SQLite's errors may name a file by its full path.
  Error of_target(Error error) const {
    std::error_code unknown;
    const bool of_source = fs::equivalent(error.database, from_, unknown);
    if (error.code != Errc::aborted && !of_source) error.database = to_;
    return error;
  }

  // Opens a snapshot of the source, which all reads use, and verifies the runs in it.
  Result<> open_source(const std::vector<std::int64_t>& runs) {
    if (auto r = keep(open_read_only(from_), source_); !r) return r;
    if (auto r = require_same_schema(source_, schema_); !r) return r;
    auto snapshot = Transaction::begin_read(source_);
    if (!snapshot) return fail(snapshot.error());
    snapshot_.emplace(std::move(*snapshot));
    for (const std::int64_t run : runs) {
      if (!goes_on()) return stopped();
      if (auto r = require_sound(run); !r) return r;
    }
    return {};
  }

  Result<> require_sound(std::int64_t run) {
    auto chain = verify_chain(source_, run);
    if (!chain) return fail(chain.error());
    if (chain->goes_on) {
      return fail(Errc::invalid_request, "run {} is still going on: copy it when it has ended",
                  run);
    }
    if (chain->not_closed) {
      return fail(Errc::invalid_request,
                  "run {} was cut off, and lcrigd closes it at its next start: copy it then", run);
    }
    if (!chain->intact) {
      return fail(Errc::invalid_request, "run {} is not as it was recorded ({}), and is not copied",
                  run, chain->finding);
    }
    before_.push_back(std::move(*chain));
    return {};
  }

  Result<> look_at_target() {
    const auto written = has_writer(to_);
    if (!written) return fail(written.error());
    if (*written) {
      return fail(
          Errc::busy,
          "{}: a daemon, or another copy, writes to it now: end that first, or name another file",
          to_);
    }
    const auto there = look_at(to_);
    created_ = !there;
    if (!there) return {};
    if (there->st_size == 0) {
      return fail(Errc::invalid_request, "{}: is empty, and no database; remove it first", to_);
    }
    auto target = open_read_only(to_);
    if (!target) return fail(target.error());
    return require_same_schema(*target, schema_);
  }

  Result<std::vector<CopiedRun>> copy_all(const std::vector<std::int64_t>& runs) {
    if (auto r = keep(open_read_write(to_, options_.vfs), target_); !r) return fail(r.error());
    auto transaction = Transaction::begin(target_);
    if (!transaction) return fail(transaction.error());
    if (auto r = require_new(runs); !r) return fail(r.error());
    std::vector<CopiedRun> out;
    out.reserve(runs.size());
    for (std::size_t i = 0; i < runs.size(); ++i) {
      auto copied = copy_run(runs[i], before_[i]);
      if (!copied) return fail(copied.error());
      out.push_back(std::move(*copied));
    }
    if (auto r = transaction->commit(); !r) return fail(r.error());
    if (auto r = move_out_of_log(); !r) return fail(r.error());
    return out;
  }

  // Moves the log into the file, so that a person who copies the file alone gets the runs. A
  // program that reads the file meanwhile does it when it closes the database last.
  Result<> move_out_of_log() {
    const auto moved = target_.execute("PRAGMA wal_checkpoint(TRUNCATE)");
    if (moved) return {};
    if (created_) return fail(moved.error());
    return fail(moved.error().code,
                "{}; the runs are copied, but could not be moved from {} into the file itself: "
                "keep both files together; the next command that writes there moves them",
                moved.error().what, beside_database(to_, "-wal"));
  }

  Result<> require_new(const std::vector<std::int64_t>& runs) {
    std::vector<std::string> there;
    for (std::size_t i = 0; i < runs.size(); ++i) {
      auto uuid = get_uuid(source_, runs[i]);
      if (!uuid) return fail(uuid.error());
      auto found = target_.first(
          "SELECT id, (SELECT max(seq) FROM chain WHERE run_id = id) FROM run WHERE uuid = ?",
          [](const Statement& s) { return std::pair(s.integer(0), s.integer(1)); },
          uuid->value_or(""));
      if (!found) return fail(found.error());
      if (!*found) continue;
      const auto& [run, links] = **found;
      const auto more = before_[i].head.links - links;
      there.push_back(fmt::format("run {} is there already, as run {}{}", runs[i], run,
                                  more > 0   ? ", without the notes that were added here since"
                                  : more < 0 ? ", with notes that were added there since"
                                             : ""));
    }
    if (there.empty()) return {};
    return fail(Errc::invalid_request, "{}: {} (same uuid): nothing was copied", to_,
                fmt::join(there, "; "));
  }

  Result<CopiedRun> copy_run(std::int64_t run, const ChainReport& before) {
    auto number = next_run_number(target_);
    if (!number) return fail(number.error());
    for (const char* table : kTablesOfRun) {
      if (auto r = copy_rows(table, run, *number); !r) return fail(r.error());
    }
    if (auto r = write_origin(run, *number); !r) return fail(r.error());
    auto after = verify_chain(target_, *number);
    if (!after) return fail(after.error());
    if (!after->intact || after->head != before.head || after->rows != before.rows) {
      return fail(Errc::io, "{}: run {} was not copied as it is ({}): check the disk", to_, run,
                  after->finding);
    }
    auto uuid = get_uuid(target_, *number);
    if (!uuid) return fail(uuid.error());
    CopiedRun out;
    out.from = run;
    out.to = *number;
    out.uuid = uuid->value_or("");
    out.rows = after->rows;
    return out;
  }

  // Both databases have the same schema, so the columns have the same order.
  Result<> copy_rows(std::string_view table, std::int64_t run, std::int64_t number) {
    const bool row_of_run = table == kTablesOfRun.front();
    auto rows = source_.query(
        fmt::format("SELECT * FROM {} WHERE {} = ?", table, row_of_run ? "id" : "run_id"), run);
    if (!rows) return fail(rows.error());
    std::string places = "?";
    for (int i = 1; i < rows->columns(); ++i) places += ",?";
    auto insert = target_.prepare(fmt::format("INSERT INTO {} VALUES ({})", table, places));
    if (!insert) return fail(insert.error());
    return rows->each([&](const Statement& row) -> Result<> {
      insert->bind(0, number);
      for (int i = 1; i < row.columns(); ++i) {
        // NULL: the number is a row of the other database, and the run has the specimen's text
        // itself.
        if (row_of_run && sqlite3_column_name(row.handle(), i) == kSpecimen) {
          insert->bind_null(i);
        } else {
          sqlite3_bind_value(insert->handle(), i + 1, sqlite3_column_value(row.handle(), i));
        }
      }
      if (auto r = insert->run(); !r) return r;
      return ++rows_ % kRowsOfStep == 0 ? take_breath() : Result<>();
    });
  }

  // The origin of a run that is copied again stays the database where it was recorded.
  Result<> write_origin(std::int64_t run, std::int64_t number) {
    auto row = get_run(source_, run);
    if (!row) return fail(row.error());
    if (!row->copied_from) {
      std::error_code unknown;
      auto& here = row->copied_from.emplace();
      here.run = run;
      here.specimen_id = row->specimen_id;
      here.file = fs::canonical(from_, unknown).string();
      if (unknown) here.file = from_;
    }
    const CopiedFrom& o = *row->copied_from;
    return target_.change("INSERT INTO run_copy VALUES (?,?,?,?,?,?)", number, o.run, o.specimen_id,
                          std::string_view(o.file), std::string_view(options_.by),
                          options_.now_unix_ns);
  }

  // Syncs the log between steps, because one large sync at the end would hold up a commit of the
  // recorder.
  Result<> take_breath() {
    if (!goes_on()) return stopped();
    const int log = ::open(beside_database(to_, "-wal").c_str(), O_RDONLY | O_CLOEXEC);
    if (log >= 0) {
      ::fdatasync(log);
      ::close(log);
    }
    const auto here = look_at(from_), there = look_at(to_);
    std::error_code unknown;
    const auto space = fs::space(to_, unknown);
    const bool shared = here && there && here->st_dev == there->st_dev;
    if (unknown || !shared || space.available >= kLeftToRecorder) return {};
    return fail(Errc::io, "{}: less than {} MB would be left to the recorder: free some space", to_,
                kLeftToRecorder >> 20U);
  }

  void remove_target() const {
    std::error_code ignored;
    for (const char* suffix : {"", "-wal", "-shm", "-journal", ".lock", ".writer"}) {
      fs::remove(to_ + suffix, ignored);
    }
  }

  bool goes_on() const { return !options_.goes_on || options_.goes_on(); }
  Result<> stopped() const { return fail(Errc::aborted, "{}: stopped; nothing was copied", to_); }

  static constexpr std::string_view kSpecimen = "specimen_id";
  const std::int64_t schema_ = shipped_migrations().back().version;
  std::string from_, to_;
  RunCopyOptions options_;
  Database source_, target_;
  std::optional<Transaction> snapshot_;
  std::vector<ChainReport> before_;  // one for each run
  std::int64_t rows_ = 0;
  bool created_ = false;
};

}  // namespace

Result<std::vector<CopiedRun>> copy_runs(const std::string& from, std::vector<std::int64_t> runs,
                                         const std::string& to, RunCopyOptions options) {
  const auto copy = [&]() -> Result<std::vector<CopiedRun>> {
    give_way();
    return RunCopy(from, to, std::move(options)).make(std::move(runs));
  };
  return std::async(std::launch::async, copy).get();
}

}  // namespace lcrig
