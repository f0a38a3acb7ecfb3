// SPDX-License-Identifier: Apache-2.0
// RAII over the SQLite C API. Used by storage/, the recorder and analysis. A connection and its
// statements belong to one thread at a time.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/enum_words.hpp"
#include "base/result.hpp"

struct sqlite3;
struct sqlite3_stmt;

namespace lcrig {

class Database;

// A prepared statement. Parameters and columns count from 0. It keeps its connection open.
class Statement {
 public:
  Statement() = default;

  // Texts and blobs must stay alive until the next `step`, `run` or `reset` has returned.
  void bind(int parameter, std::int64_t value);
  void bind(int parameter, double value);
  void bind(int parameter, std::string_view text);
  void bind_blob(int parameter, std::span<const unsigned char> bytes);
  void bind_null(int parameter);
  void bind(int parameter, std::optional<std::int64_t> value);  // none: NULL
  template <class E>
    requires std::is_enum_v<E>
  void bind(int parameter, E value) {
    bind(parameter, to_string(value));
  }

  Result<bool> step();  // true: there is a row
  Result<> run();  // runs to the end, then resets
  void reset();
  // Calls `visit` with each row. If `visit` returns a Result, an error ends the loop.
  template <class Visit>
  Result<> each(Visit visit) {
    for (;;) {
      auto row = step();
      if (!row) return fail(row.error());
      if (!*row) return {};
      if constexpr (std::is_void_v<std::invoke_result_t<Visit&, const Statement&>>) {
        visit(std::as_const(*this));
      } else if (auto r = visit(std::as_const(*this)); !r) {
        return r;
      }
    }
  }

  int columns() const;
  bool is_null(int column) const;
  std::int64_t integer(int column) const;
  double real(int column) const;
  std::optional<double> optional_real(int column) const;
  std::optional<std::int64_t> optional_integer(int column) const;
  // Valid until the next step, run or reset.
  std::string_view text(int column) const;
  std::span<const unsigned char> blob(int column) const;
  // Reads the columns, from the first on, into variables of their types. An optional takes NULL. An
  // unknown word leaves an enumeration as it is.
  template <class... Values>
  void read(Values&... out) const {
    int column = 0;
    (get(column++, out), ...);
  }
  sqlite3_stmt* handle() const { return handle_.get(); }

 private:
  friend class Database;
  struct Finalize {
    void operator()(sqlite3_stmt* s) const;
  };
  explicit Statement(sqlite3_stmt* handle) : handle_(handle) {}
  template <class T>
  void get(int column, T& out) const {
    if constexpr (std::is_integral_v<T>) {
      out = static_cast<T>(integer(column));
    } else if constexpr (std::is_same_v<T, double>) {
      out = real(column);
    } else if constexpr (HasWords<T>) {
      out = parse_word<T>(text(column)).value_or(out);
    } else {
      out = text(column);
    }
  }
  template <class T>
  void get(int column, std::optional<T>& out) const {
    out.reset();
    if constexpr (HasWords<T>) {
      out = parse_word<T>(text(column));
    } else if (!is_null(column)) {
      get(column, out.emplace());
    }
  }

  std::unique_ptr<sqlite3_stmt, Finalize> handle_;
};

// A connection to one database file.
class Database {
 public:
  // immutable and private_index create no file beside the database, and require that nobody writes.
  // immutable reads the file alone; private_index also what is still in its log.
  enum class Mode { read_write_create, read_only, immutable, private_index };
  Database() = default;
  // `path` is as the user wrote it and appears in every message. Opening reads nothing yet. `vfs`
  // names a registered VFS (storage/faulty_disk.hpp); empty means the operating system's.
  static Result<Database> open(const std::string& path, Mode mode, const std::string& vfs = "");

  Result<Statement> prepare(std::string_view sql) const;
  // A prepared statement with these values bound in order. They must stay alive until it has run.
  template <class... Values>
  Result<Statement> query(std::string_view sql, const Values&... values) const {
    auto statement = prepare(sql);
    int parameter = 0;
    if (statement) (statement->bind(parameter++, values), ...);
    return statement;
  }
  // The same for a statement without rows.
  template <class... Values>
  Result<> change(std::string_view sql, const Values&... values) const {
    auto statement = query(sql, values...);
    if (!statement) return fail(statement.error());
    return statement->run();
  }
  template <class Visit, class... Values>
  Result<> each(std::string_view sql, Visit visit, const Values&... values) const {
    auto statement = query(sql, values...);
    return statement ? statement->each(std::move(visit)) : fail(statement.error());
  }
  // All rows, or the first one if there is one, each converted by `read`.
  template <class Read, class... Values>
  auto rows(std::string_view sql, Read read, const Values&... values) const
      -> Result<std::vector<decltype(read(Statement()))>> {
    std::vector<decltype(read(Statement()))> out;
    auto all = each(sql, [&](const Statement& row) { out.push_back(read(row)); }, values...);
    if (!all) return fail(all.error());
    return out;
  }
  template <class Read, class... Values>
  auto first(std::string_view sql, Read read, const Values&... values) const
      -> Result<std::optional<decltype(read(Statement()))>> {
    std::optional<decltype(read(Statement()))> out;
    auto statement = query(sql, values...);
    if (!statement) return fail(statement.error());
    auto row = statement->step();
    if (!row) return fail(row.error());
    if (*row) out.emplace(read(*statement));
    return out;
  }
  // The first column alone. `first` returns nullopt also for NULL.
  template <class T, class... Values>
  Result<std::vector<T>> rows(std::string_view sql, const Values&... values) const {
    std::vector<T> out;
    auto all = each(sql, [&out](const Statement& row) { row.read(out.emplace_back()); }, values...);
    if (!all) return fail(all.error());
    return out;
  }
  template <class T, class... Values>
  Result<std::optional<T>> first(std::string_view sql, const Values&... values) const {
    const auto read = [](const Statement& row) {
      std::optional<T> value;
      row.read(value);
      return value;
    };
    auto found = first(sql, read, values...);
    if (!found) return fail(found.error());
    return found->value_or(std::nullopt);
  }
  Result<> execute(const std::string& sql) const;  // any number of statements; rows are ignored
  // The first column of the first row; 0 for NULL. Errors: also bug, when there is no row.
  template <class... Values>
  Result<std::int64_t> integer(std::string_view sql, const Values&... values) const {
    auto found = first(sql, [](const Statement& row) { return row.integer(0); }, values...);
    if (!found) return fail(found.error());
    if (!*found) return fail(Errc::bug, "{}: no row from {}", path_, sql);
    return **found;
  }
  // The same as a truth value.
  template <class... Values>
  Result<bool> holds(std::string_view sql, const Values&... values) const {
    auto value = integer(sql, values...);
    if (!value) return fail(value.error());
    return *value != 0;
  }
  std::int64_t last_insert_id() const;
  bool in_transaction() const;
  const std::string& path() const { return path_; }
  const std::string& vfs() const { return vfs_; }
  // Extended result code of the last call that failed (SQLITE_FULL, SQLITE_IOERR_FSYNC, ...).
  int error_code() const;
  // Keeps the files beside the database when the last connection closes, for users who may read but
  // not write.
  void keep_companions() const;
  // True when the connection cannot be trusted after the last failed call and must be reopened.
  bool needs_reopening() const;
  // True when the file's name leads to another file now, or to none.
  bool has_moved() const;
  // The last failed call as an Error that says what happened to which file and what to do.
  Error error(std::string_view doing) const;

 private:
  struct Close {
    void operator()(sqlite3* db) const;
  };
  std::string path_, vfs_;
  std::unique_ptr<sqlite3, Close> handle_;
};

// BEGIN IMMEDIATE ... COMMIT. The destructor rolls back what was not committed. The connection must
// not be moved while the transaction lives.
class Transaction {
 public:
  static Result<Transaction> begin(const Database& db);
  // BEGIN: all reads of the transaction see one state, even while another connection writes.
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
