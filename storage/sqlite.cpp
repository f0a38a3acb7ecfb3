// SPDX-License-Identifier: Apache-2.0
#include "storage/sqlite.hpp"

#include <sqlite3.h>

#include <cassert>
#include <filesystem>

namespace lcrig {

namespace {

struct Advice {
  Errc code;
  std::string_view text;
};

// What an operator should do about a result code.
Advice advice_for(int extended_code) {
  if (extended_code == SQLITE_IOERR_FSYNC) {
    return {Errc::io, "; the disk did not confirm what was written: check it, then `lcrig verify`"};
  }
  switch (extended_code & 0xff) {
    case SQLITE_FULL:
      return {Errc::io, "no space is left on its disk, which is full: free some space"};
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return {Errc::busy, "another program holds it, and it is locked: stop that one or wait"};
    case SQLITE_NOTADB:
      return {Errc::invalid_request, "is not a database, or its beginning is damaged"};
    case SQLITE_CORRUPT: return {Errc::io, "is damaged: restore a copy of it"};
    case SQLITE_CANTOPEN:
    case SQLITE_PERM:
    case SQLITE_READONLY:
    case SQLITE_AUTH: return {Errc::io, "; check that the file and its folder are writable"};
    case SQLITE_IOERR: return {Errc::io, "; check the disk"};
    case SQLITE_NOMEM: return {Errc::io, "; memory is short: end other programs"};
    case SQLITE_CONSTRAINT: return {Errc::invalid_request, ""};
    default: return {Errc::bug, ""};
  }
}

Error make_error(sqlite3* handle, std::string_view path, std::string_view doing) {
  const int code = handle != nullptr ? sqlite3_extended_errcode(handle) : SQLITE_NOMEM;
  const Advice advice = advice_for(code);
  Error out(advice.code, {});
  out.database = path;
  // For these codes the statement and SQLite's words add nothing.
  if (const int kind = code & 0xff; kind == SQLITE_NOTADB || kind == SQLITE_CORRUPT ||
                                    kind == SQLITE_BUSY || kind == SQLITE_LOCKED ||
                                    kind == SQLITE_FULL) {
    out.what = fmt::format("{}: {} ({})", path, advice.text, code);
    return out;
  }
  const char* message = handle != nullptr ? sqlite3_errmsg(handle) : "out of memory";
  constexpr std::size_t kShown = 60;  // characters of a statement, enough to recognise it
  out.what =
      fmt::format("{}: {}: {} ({}){}", path, doing.substr(0, kShown), message, code, advice.text);
  return out;
}

// SQLite reads a name that begins with "file:" or ":" as an address. It may lead to another file
// than the one that was checked, or to none.
std::string plain_name(const std::string& path) {
  return path.starts_with("file:") || path.starts_with(':') ? "./" + path : path;
}

// Escapes the characters that have a meaning in a URI.
std::string immutable_uri(const std::string& path) {
  std::string uri = "file:";
  for (const char c : plain_name(path)) {
    if (c == '%' || c == '?' || c == '#') {
      uri += fmt::format("%{:02x}", static_cast<unsigned char>(c));
    } else {
      uri += c;
    }
  }
  return uri + "?immutable=1";
}

}  // namespace

void Statement::Finalize::operator()(sqlite3_stmt* s) const {
  sqlite3_finalize(s);
}
void Database::Close::operator()(sqlite3* db) const {
  sqlite3_close_v2(db);
}

// A bind fails only for a wrong index, a statement in use or lack of memory, so it only asserts.
void Statement::bind(int parameter, std::int64_t value) {
  [[maybe_unused]] const int rc = sqlite3_bind_int64(handle_.get(), parameter + 1, value);
  assert(rc == SQLITE_OK);
}
void Statement::bind(int parameter, double value) {
  [[maybe_unused]] const int rc = sqlite3_bind_double(handle_.get(), parameter + 1, value);
  assert(rc == SQLITE_OK);
}
void Statement::bind(int parameter, std::string_view text) {
  // A null pointer would bind NULL.
  const char* data = text.data() == nullptr ? "" : text.data();
  [[maybe_unused]] const int rc = sqlite3_bind_text(handle_.get(), parameter + 1, data,
                                                    static_cast<int>(text.size()), SQLITE_STATIC);
  assert(rc == SQLITE_OK);
}
void Statement::bind_blob(int parameter, std::span<const unsigned char> bytes) {
  [[maybe_unused]] const int rc = sqlite3_bind_blob(handle_.get(), parameter + 1, bytes.data(),
                                                    static_cast<int>(bytes.size()), SQLITE_STATIC);
  assert(rc == SQLITE_OK);
}
void Statement::bind_null(int parameter) {
  [[maybe_unused]] const int rc = sqlite3_bind_null(handle_.get(), parameter + 1);
  assert(rc == SQLITE_OK);
}
void Statement::bind(int parameter, std::optional<std::int64_t> value) {
  if (value) return bind(parameter, *value);
  bind_null(parameter);
}

Result<bool> Statement::step() {
  const int rc = sqlite3_step(handle_.get());
  if (rc == SQLITE_ROW) return true;
  if (rc == SQLITE_DONE) return false;
  sqlite3* db = sqlite3_db_handle(handle_.get());
  Error error = make_error(db, sqlite3_db_filename(db, "main"), sqlite3_sql(handle_.get()));
  sqlite3_reset(handle_.get());
  return fail(std::move(error));
}

Result<> Statement::run() {
  for (;;) {
    auto row = step();
    if (!row) return fail(row.error());
    if (!*row) break;
  }
  reset();
  return {};
}

void Statement::reset() {
  sqlite3_reset(handle_.get());
}

int Statement::columns() const {
  return sqlite3_column_count(handle_.get());
}
bool Statement::is_null(int column) const {
  return sqlite3_column_type(handle_.get(), column) == SQLITE_NULL;
}
std::int64_t Statement::integer(int column) const {
  return sqlite3_column_int64(handle_.get(), column);
}
double Statement::real(int column) const {
  return sqlite3_column_double(handle_.get(), column);
}
std::optional<double> Statement::optional_real(int column) const {
  if (is_null(column)) return std::nullopt;
  return real(column);
}
std::optional<std::int64_t> Statement::optional_integer(int column) const {
  if (is_null(column)) return std::nullopt;
  return integer(column);
}
std::string_view Statement::text(int column) const {
  const auto* data = reinterpret_cast<const char*>(sqlite3_column_text(handle_.get(), column));
  if (data == nullptr) return {};
  return {data, static_cast<std::size_t>(sqlite3_column_bytes(handle_.get(), column))};
}
std::span<const unsigned char> Statement::blob(int column) const {
  const auto* data = static_cast<const unsigned char*>(sqlite3_column_blob(handle_.get(), column));
  return {data, static_cast<std::size_t>(sqlite3_column_bytes(handle_.get(), column))};
}

Result<Database> Database::open(const std::string& path, Mode mode, const std::string& vfs) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) {
    return fail(Errc::invalid_request, "{}: is a folder; name a file, such as {}", path,
                (std::filesystem::path(path) / "lcrig.db").string());
  }
  const auto status = std::filesystem::status(path, ignored);
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) {
    return fail(Errc::invalid_request, "{}: is a pipe or a device; name a file", path);
  }
  const bool write = mode == Mode::read_write_create;
  int flags = write ? SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE : SQLITE_OPEN_READONLY;
  if (mode == Mode::immutable) flags |= SQLITE_OPEN_URI;
  // With a VFS that takes no locks SQLite lets the connection own the file, and so keeps the index
  // of the log in memory.
  const std::string by = mode == Mode::private_index ? "unix-none" : vfs;
  const std::string name = mode == Mode::immutable ? immutable_uri(path) : plain_name(path);
  sqlite3* handle = nullptr;
  const int rc = sqlite3_open_v2(name.c_str(), &handle, flags | SQLITE_OPEN_NOMUTEX,
                                 by.empty() ? nullptr : by.c_str());
  Database db;
  db.path_ = path;
  db.vfs_ = vfs;
  db.handle_.reset(handle);
  if (rc != SQLITE_OK) return fail(db.error("open"));
  sqlite3_extended_result_codes(handle, 1);
  if (mode == Mode::private_index) {
    sqlite3_db_config(handle, SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 1, nullptr);
    if (auto r = db.execute("PRAGMA locking_mode = EXCLUSIVE"); !r) return fail(r.error());
  }
  return db;
}

bool Database::has_moved() const {
  if (!handle_) return false;
  int moved = 0;
  const int rc = sqlite3_file_control(handle_.get(), "main", SQLITE_FCNTL_HAS_MOVED, &moved);
  return rc == SQLITE_OK && moved != 0;
}

Result<Statement> Database::prepare(std::string_view sql) const {
  sqlite3_stmt* handle = nullptr;
  const int rc = sqlite3_prepare_v3(handle_.get(), sql.data(), static_cast<int>(sql.size()),
                                    SQLITE_PREPARE_PERSISTENT, &handle, nullptr);
  if (rc != SQLITE_OK) return fail(error(sql));
  return Statement(handle);
}

Result<> Database::execute(const std::string& sql) const {
  if (sqlite3_exec(handle_.get(), sql.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK) {
    return fail(error(sql));
  }
  return {};
}

std::int64_t Database::last_insert_id() const {
  return sqlite3_last_insert_rowid(handle_.get());
}
bool Database::in_transaction() const {
  return sqlite3_get_autocommit(handle_.get()) == 0;
}
int Database::error_code() const {
  return handle_ ? sqlite3_extended_errcode(handle_.get()) : SQLITE_NOMEM;
}

void Database::keep_companions() const {
  int on = 1;
  sqlite3_file_control(handle_.get(), "main", SQLITE_FCNTL_PERSIST_WAL, &on);
}

bool Database::needs_reopening() const {
  const int code = error_code() & 0xff;
  return code == SQLITE_IOERR || code == SQLITE_CORRUPT;
}

Error Database::error(std::string_view doing) const {
  return make_error(handle_.get(), path_, doing);
}

Result<Transaction> Transaction::begin(const Database& db) {
  if (auto r = db.execute("BEGIN IMMEDIATE"); !r) return fail(r.error());
  return Transaction(db);
}

Result<Transaction> Transaction::begin_read(const Database& db) {
  if (auto r = db.execute("BEGIN"); !r) return fail(r.error());
  return Transaction(db);
}

Transaction::~Transaction() {
  // A failed COMMIT may or may not have ended the transaction, so ask SQLite.
  if (db_ != nullptr && db_->in_transaction()) static_cast<void>(db_->execute("ROLLBACK"));
}

Result<> Transaction::commit() {
  if (auto r = db_->execute("COMMIT"); !r) return fail(r.error());
  db_ = nullptr;
  return {};
}

}  // namespace lcrig
