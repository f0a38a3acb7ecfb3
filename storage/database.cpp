// SPDX-License-Identifier: Apache-2.0
#include "storage/database.hpp"

#include <spdlog/spdlog.h>
#include <sqlite3.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "base/text.hpp"
#include "storage/migrations.hpp"
#include "storage/writer_lock.hpp"

namespace lcrig {

namespace {

enum class Content { empty, current, older };

// Readers need nothing that later schemas added; schema 2 added views for people.
constexpr int kOldestRead = 1;

// Decides what the file is before anything is written to it.
Result<Content> inspect(const Database& db) {
  auto application = db.integer("PRAGMA application_id");
  if (!application) return fail(application.error());
  auto version = db.integer("PRAGMA user_version");
  if (!version) return fail(version.error());
  auto tables = db.integer("SELECT count(*) FROM sqlite_schema");
  if (!tables) return fail(tables.error());
  if (*application == 0 && *version == 0 && *tables == 0) return Content::empty;
  if (*application != kApplicationId) {
    return fail(Errc::invalid_request,
                "{}: an SQLite database of another program (application id {}); give another --db",
                db.path(), *application);
  }
  const int ours = shipped_migrations().back().version;
  if (*version > ours) {
    return fail(Errc::invalid_request,
                "{}: schema {} is newer than this lcrig knows ({}); install a newer lcrig",
                db.path(), *version, ours);
  }
  return *version < kOldestRead ? Content::older : Content::current;
}

Result<> configure(const Database& db) {
  // 5 s is longer than any of our writes. A backup does not block writers.
  if (auto r = db.execute("PRAGMA busy_timeout = 5000"); !r) return r;
  if (auto r = db.execute("PRAGMA foreign_keys = ON"); !r) return r;
  // Otherwise INSERT OR REPLACE would delete rows without firing the delete triggers.
  return db.execute("PRAGMA recursive_triggers = ON");
}

// SQLite silently opens a file read-only when it may not write it.
Result<> require_writable(const Database& db) {
  const std::filesystem::path file(db.path());
  std::error_code ignored;
  const bool exists = std::filesystem::exists(file, ignored);
  const auto folder = file.has_parent_path() ? file.parent_path() : std::filesystem::path(".");
  if ((exists && ::access(file.c_str(), W_OK) != 0) || ::access(folder.c_str(), W_OK) != 0) {
    return fail(Errc::io,
                "{}: not writable; change the rights of the file and its folder, or give another "
                "--db",
                db.path());
  }
  return {};
}

std::uintmax_t bytes_of(const std::string& file) {
  std::error_code unknown;
  const auto bytes = std::filesystem::file_size(file, unknown);
  return unknown ? 0 : bytes;
}

// Refuses an empty or missing file with a log beside it: the log may hold readings that were
// committed but not yet moved into the file.
Result<> require_database_of_log(const std::string& path) {
  const std::string log = beside_database(path, "-wal");
  if (bytes_of(path) > 0 || bytes_of(log) == 0) return {};
  return fail(Errc::invalid_request,
              "{}: there is no database, but its log ({}) holds what is in no other file: move the "
              "database back beside it, or the log to the database",
              path, log);
}

Result<> require_readable(const std::string& path) {
  if (::access(path.c_str(), R_OK) == 0) return {};
  if (errno == ENOENT) {
    return fail(Errc::invalid_request, "{}: no such database; give --db, or record a run first",
                path);
  }
  return fail(Errc::io,
              "{}: {}; whoever is in the group of the file and its folder may read it (the "
              "service's: `lcrig`)",
              path, std::strerror(errno));
}

// How to open a file for reading without creating anything. Every writer of ours leaves -wal and
// -shm beside the file, and a reader shares them. Beside an older file or a copy one may be
// missing, and a reader must not create it.
Result<Database::Mode> reading_mode(const std::string& path) {
  std::error_code unknown;
  const auto log_bytes = std::filesystem::file_size(beside_database(path, "-wal"), unknown);
  const bool has_log = !unknown;
  if (has_log && std::filesystem::exists(beside_database(path, "-shm"), unknown)) {
    return Database::Mode::read_only;
  }
  const auto written = has_writer(path);
  if (!written) return fail(written.error());
  if (*written) return Database::Mode::read_only;  // the writer is about to create them
  return has_log && log_bytes > 0 ? Database::Mode::private_index : Database::Mode::immutable;
}

// Reports a migration as a warning where information is not logged, because an older lcrig can no
// longer open the file.
void tell_migration(const std::string& path, std::int64_t before) {
  const int now = shipped_migrations().back().version;
  if (before == 0 || before == now) return;  // a new file, or no migration
  const auto level =
      spdlog::should_log(spdlog::level::info) ? spdlog::level::info : spdlog::level::warn;
  spdlog::log(level, "database {}: schema {} -> {}", printable(path), before, now);
}

}  // namespace

Result<> require_safe_to_create(const std::string& path) {
  std::error_code unknown;
  const auto name = std::filesystem::symlink_status(path, unknown);
  if (std::filesystem::is_symlink(name) && !std::filesystem::exists(path, unknown)) {
    return fail(Errc::invalid_request,
                "{}: a link to nothing ({}): is its disk mounted? To make a new database, name the "
                "file itself",
                path, std::filesystem::read_symlink(path, unknown).string());
  }
  return require_database_of_log(path);
}

Result<> require_one_name(const std::string& path) {
  struct stat file{};
  if (::stat(path.c_str(), &file) != 0 || file.st_nlink <= 1) return {};
  return fail(Errc::invalid_request,
              "{}: this file has {} names (hard links), and whoever opens it by another one does "
              "not see what is written here: remove the others, which `find -samefile {}` lists",
              path, file.st_nlink, path);
}

Result<Database> open_read_write(const std::string& path, const std::string& vfs) {
  if (vfs != kInMemory) {
    if (auto safe = require_safe_to_create(path); !safe) return fail(safe.error());
  }
  auto db = Database::open(path, Database::Mode::read_write_create, vfs);
  if (!db) return fail(db.error());
  if (auto r = require_writable(*db); !r) return fail(r.error());
  if (auto r = configure(*db); !r) return fail(r.error());
  if (auto content = inspect(*db); !content) return fail(content.error());
  if (auto r = db->execute("PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL"); !r) {
    return fail(r.error());
  }
  // SQLite empties the log when the last connection closes, so that a copy of the file alone is
  // complete. It does so only if a size limit is set; nothing of ours reaches this one.
  db->keep_companions();
  if (auto r = db->execute("PRAGMA journal_size_limit = 67108864"); !r) return fail(r.error());
  const auto before = db->integer("PRAGMA user_version");
  if (!before) return fail(before.error());
  if (auto r = migrate(*db); !r) return fail(r.error());
  tell_migration(path, *before);
  return db;
}

Result<Database> open_read_only(const std::string& path, const std::string& vfs) {
  if (vfs != kInMemory) {
    // Opening the empty file even for reading would delete the log.
    if (auto r = require_database_of_log(path); !r) return fail(r.error());
    if (auto r = require_readable(path); !r) return fail(r.error());
  }
  const auto mode = vfs.empty() ? reading_mode(path) : Database::Mode::read_only;
  if (!mode) return fail(mode.error());
  auto db = Database::open(path, *mode, vfs);
  if (!db) return fail(db.error());
  if (auto r = configure(*db); !r) return fail(r.error());
  auto content = inspect(*db);
  if (!content) return fail(content.error());
  if (*content != Content::current) {
    return fail(Errc::invalid_request, "{}: {}; start lcrigd or record a run with it first", path,
                *content == Content::empty ? "an empty database" : "an older schema");
  }
  return db;
}

Result<bool> has_uuids(const Database& db) {
  constexpr std::int64_t kFirstWithUuids = 8;
  auto schema = db.integer("PRAGMA user_version");
  if (!schema) return fail(schema.error());
  return *schema >= kFirstWithUuids;
}

Result<bool> has_table(const Database& db, std::string_view name) {
  return db.holds("SELECT count(*) FROM sqlite_schema WHERE name = ?", name);
}

}  // namespace lcrig
