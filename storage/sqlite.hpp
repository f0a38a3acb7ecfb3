// SPDX-License-Identifier: Apache-2.0
// RAII over the SQLite C API. A connection and its statements belong to one thread at a time.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "base/result.hpp"

struct sqlite3;
struct sqlite3_stmt;

namespace lcrig {

class Database;

// A prepared statement. Parameters and columns count from 0. Keeps its connection open.
class Statement {
 public:
  Statement() = default;

  // Texts and blobs must live until the next `step`, `run` or `reset` returned.
  void bind(int parameter, std::int64_t value);
  void bind(int parameter, double value);
  void bind(int parameter, std::string_view text);
  void bind_blob(int parameter, std::span<const unsigned char> bytes);
  void bind_null(int parameter);

  Result<bool> step();  // true: a row is there
  Result<> run();  // to its end, then resets
  void reset();

  int columns() const;
  bool is_null(int column) const;
  std::int64_t integer(int column) const;
  double real(int column) const;
  std::optional<double> optional_real(int column) const;
  std::optional<std::int64_t> optional_integer(int column) const;
  // Valid until the next step, run or reset.
  std::string_view text(int column) const;
  std::span<const unsigned char> blob(int column) const;
  sqlite3_stmt* handle() const { return handle_.get(); }

 private:
  friend class Database;
  struct Finalize {
    void operator()(sqlite3_stmt* s) const;
  };
  explicit Statement(sqlite3_stmt* handle) : handle_(handle) {}

  std::unique_ptr<sqlite3_stmt, Finalize> handle_;
};

// A connection.
class Database {
 public:
  // immutable: read-only on a medium where SQLite cannot create its -shm file; nobody may write.
  enum class Mode { read_only, immutable, read_write_create };
  Database() = default;
  // `path` as the user wrote it; it stands in every message. Nothing is read yet.
  // `vfs` names one that is registered (storage/faulty_disk.hpp); empty: the operating system's.
  static Result<Database> open(const std::string& path, Mode mode, const std::string& vfs = "");

  Result<Statement> prepare(std::string_view sql) const;
  Result<> execute(const std::string& sql) const;  // any number of statements, rows are dropped
  Result<std::int64_t> integer(std::string_view sql) const;  // first column of the first row
  std::int64_t last_insert_id() const;
  bool in_transaction() const;
  const std::string& path() const { return path_; }
  const std::string& vfs() const { return vfs_; }
  // Extended result code of the last call that failed (SQLITE_FULL, SQLITE_IOERR_FSYNC, ...).
  int error_code() const;
  // The last failed call left a connection that is not to be trusted: reopen the file.
  bool needs_reopening() const;
  // The last failed call as an Error: what happened to which file and what to do.
  Error error(std::string_view doing) const;

 private:
  struct Close {
    void operator()(sqlite3* db) const;
  };
  std::string path_, vfs_;
  std::unique_ptr<sqlite3, Close> handle_;
};

// BEGIN IMMEDIATE ... COMMIT on a connection that stays where it is; what is not committed is
// rolled back by the destructor.
class Transaction {
 public:
  static Result<Transaction> begin(const Database& db);
  // BEGIN: all reads until the end see one state, beside a writer.
  static Result<Transaction> begin_read(const Database& db);
  Transaction(Transaction&& other) noexcept : db_(std::exchange(other.db_, nullptr)) {}
  Transaction& operator=(Transaction&&) = delete;
  ~Transaction();
  Result<> commit();

 private:
  explicit Transaction(const Database& db) : db_(&db) {}
  const Database* db_;
};

}  // namespace lcrig
