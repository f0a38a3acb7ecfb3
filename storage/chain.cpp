// SPDX-License-Identifier: Apache-2.0
#include "storage/chain.hpp"

#include <sqlite3.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <vector>

#include "storage/copied_from.hpp"
#include "storage/database.hpp"
#include "storage/uuid.hpp"
#include "storage/writer_lock.hpp"

namespace lcrig {

namespace {

// The columns that the chain covers. When a migration adds a column, do not add it here; give the
// table a new tag instead.
struct TableSpec {
  std::string_view name;
  char tag;
  std::string_view columns;
};
constexpr std::array<TableSpec, 7> kTables{{
    {"level", 'L',
     "run_id,seq,level,step_id,repeat,level_index,target_force_N,target_pressure_Pa,"
     "planned_readings,begin_mono_ns"},
    {"event", 'E', "run_id,seq,at_mono_ns,kind,step_id,detail"},
    {"lcr_reading", 'R',
     "run_id,seq,asked_mono_ns,first_byte_mono_ns,last_byte_mono_ns,planned_mono_ns,step_id,repeat,"
     "level,reading_index,fresh,flags,function,status,capacitance_F,dissipation,resistance_ohm,"
     "reactance_ohm,impedance_ohm,phase_rad,phase_deg"},
    {"frame_sample", 'F',
     "run_id,seq,received_mono_ns,device_seq,device_time_s,force_N,travel_m,flags"},
    {"run_note", 'N', "run_id,seq,operator,text,added_unix_ns"},
    {"run", 'U',
     "id,protocol_name,protocol_text,protocol_sha256,parameters_json,specimen_id,specimen_name,"
     "specimen_text,probe_diameter_m,lcr_identity,frame_identity,lcr_settings_json,"
     "frame_capabilities_json,frame_limits_json,correction_json,bench_name,bench_text,simulated,"
     "seed,model_level,model_error_json,software_version,operator,note,started_unix_ns,"
     "started_mono_ns,boot_id,uuid"},
    {"run_end", 'Z', "run_id,exit_status,reason,ended_mono_ns,ended_unix_ns"},
}};
constexpr std::size_t kRunSpec = 5, kEndSpec = 6;
constexpr int kSpecimenColumn = 5;  // in the run row

// The columns of runs recorded before runs had a uuid. The uuid of such a run is derived from this
// link.
TableSpec run_without_uuid() {
  TableSpec spec = kTables[kRunSpec];
  spec.tag = 'S';
  spec.columns.remove_suffix(std::string_view(",uuid").size());
  return spec;
}

const TableSpec& spec_of(std::string_view table) {
  const auto* it = std::ranges::find(kTables, table, &TableSpec::name);
  assert(it != kTables.end());
  return *it;
}

std::string placeholders(std::string_view columns) {
  std::string out = "?";
  for (const char c : columns) {
    if (c == ',') out += ",?";
  }
  return out;
}

void hash_value(RowHash& hash, const Statement& row, int column) {
  switch (sqlite3_column_type(row.handle(), column)) {
    case SQLITE_INTEGER: hash.integer(row.integer(column)); break;
    case SQLITE_FLOAT: hash.real(row.real(column)); break;
    case SQLITE_NULL: hash.null(); break;
    default: hash.text(row.text(column)); break;  // text; no covered column is a blob
  }
}

constexpr std::string_view kLinks =
    "SELECT seq, level_seq, event_seq, lcr_reading_seq, frame_sample_seq, run_note_seq, run_end,"
    " sha256 FROM chain WHERE run_id = ? ORDER BY seq";

void read_link(const Statement& row, ChainHead& out) {
  auto& [level, event, reading, sample, note] = out.last;
  row.read(out.seq, level, event, reading, sample, note, out.ended);
  const auto hash = row.blob(7);
  // A hash of another size leaves one that does not match.
  if (hash.size() == out.hash.size()) std::ranges::copy(hash, out.hash.begin());
}

Result<bool> has_end(const Database& db, std::int64_t run) {
  return db.holds("SELECT count(*) FROM run_end WHERE run_id = ?", run);
}

// Walks through the chain of one run and hashes the stored rows again, in the order of their keys.
class Verifier {
 public:
  Verifier(const Database& db, std::int64_t run, const std::optional<Anchor>& anchor)
      : db_(db), run_(run), anchor_(anchor) {}

  Result<ChainReport> verify() {
    if (auto r = prepare(); !r) return fail(r.error());
    auto links = db_.query(kLinks, run_);
    if (!links) return fail(links.error());
    while (report_.finding.empty()) {
      auto row = links->step();
      if (!row) return fail(row.error());
      if (!*row) break;
      ChainHead link;
      read_link(*links, link);
      if (auto r = check_link(link); !r) return fail(r.error());
    }
    if (report_.head.links == 0) find("the run has no chain");
    if (report_.finding.empty()) {
      if (auto r = check_rest(); !r) return fail(r.error());
    }
    if (auto r = check_anchors(); !r) return fail(r.error());
    report_.intact = report_.finding.empty();
    if (!report_.intact) {  // the walk stopped before the link that holds the end
      if (auto r = keep(has_end(db_, run_), report_.ended); !r) return fail(r.error());
    }
    return report_;
  }

 private:
  Result<> prepare() {
    for (std::size_t i = 0; i < kRunTables; ++i) {
      auto s = db_.query(fmt::format("SELECT {} FROM {} WHERE run_id = ? ORDER BY seq",
                                     kTables[i].columns, kTables[i].name),
                         run_);
      if (!s) return fail(s.error());
      rows_.push_back(std::move(*s));
    }
    if (auto r = keep(get_copied_from(db_, run_), copied_); !r) return r;
    return keep(get_uuid(db_, run_), uuid_);
  }

  // The first column of every table is the number of the run. A copied run is hashed with the
  // number that it had where it was recorded.
  void hash_row(const TableSpec& spec, const Statement& row) {
    hash_.row(spec.tag);
    for (int i = 0; i < row.columns(); ++i) {
      if (copied_ && i == 0) {
        hash_.integer(copied_->run);
      } else if (copied_ && i == kSpecimenColumn && spec.name == kTables[kRunSpec].name) {
        if (copied_->specimen_id) {
          hash_.integer(*copied_->specimen_id);
        } else {
          hash_.null();
        }
      } else {
        hash_value(hash_, row, i);
      }
    }
  }

  Result<> hash_run_row() {
    const bool in_link = uuid_ && !is_of_link(*uuid_);
    return hash_single(in_link ? kTables[kRunSpec] : run_without_uuid(), "id");
  }

  Result<> check_link(const ChainHead& link) {
    Anchor& head = report_.head;
    if (link.seq != head.links + 1) {
      find(fmt::format("link {} is missing", head.links + 1));
      return {};
    }
    hash_.start(head.hash);
    if (++head.links == 1) {
      if (auto r = hash_run_row(); !r) return r;
    }
    for (std::size_t i = 0; i < kRunTables && report_.finding.empty(); ++i) {
      if (auto r = hash_range(i, link.last[i]); !r) return r;
    }
    const bool ends = link.ended && !report_.ended;
    if (ends) {
      if (auto r = hash_single(kTables[kEndSpec], "run_id"); !r) return r;
    }
    report_.ended = link.ended;
    head.hash = hash_.finish();
    if (ends) end_ = head;
    if (link.hash != head.hash) {
      find(fmt::format("link {} does not match its rows: a value was changed", head.links));
    } else if (head.links == 1 && uuid_ && is_of_link(*uuid_) &&
               *uuid_ != uuid_of_link(head.hash)) {
      find("the uuid is not that of the run: it was changed");
    } else if (anchor_ && anchor_->links == head.links && anchor_->hash != head.hash) {
      report_.other_anchor = true;
      find(fmt::format("link {} is not that of the anchor: the run was written anew", head.links));
    }
    return {};
  }

  // Compares the chain with the anchor that the caller gave and with the one stored at the end.
  Result<> check_anchors() {
    if (anchor_ && report_.finding.empty() && anchor_->links > report_.head.links) {
      report_.other_anchor = true;
      find(fmt::format("the anchor is that of {} links, but there are {}: the last were cut off",
                       anchor_->links, report_.head.links));
    }
    auto stored = get_anchor(db_, run_);
    if (!stored) return fail(stored.error());
    if (*stored && !report_.ended) {
      find(fmt::format("the run once ended with {} links: its end was deleted", (*stored)->links));
    } else if (*stored && **stored != end_ && (*stored)->links == end_.links) {
      find(
          "the anchor that was stored at the end of the run is another: it was changed, or the run "
          "was written anew");
    } else if (*stored && **stored != end_) {
      find(fmt::format("the run once ended with {} links, now with {}: it was cut or written anew",
                       (*stored)->links, end_.links));
    }
    return {};
  }

  Result<> hash_single(const TableSpec& spec, std::string_view key) {
    const auto before = report_.rows;
    auto all = db_.each(
        fmt::format("SELECT {} FROM {} WHERE {} = ?", spec.columns, spec.name, key),
        [&](const Statement& row) {
          hash_row(spec, row);
          ++report_.rows;
        },
        run_);
    if (all && report_.rows == before) find(fmt::format("the {} row is missing", spec.name));
    return all;
  }

  Result<> hash_range(std::size_t table, std::int64_t to) {
    if (to < last_[table]) find(fmt::format("{} rows run backwards", kTables[table].name));
    for (std::int64_t seq = last_[table] + 1; seq <= to; ++seq) {
      auto row = rows_[table].step();
      if (!row) return fail(row.error());
      if (!*row || rows_[table].integer(1) != seq) {
        find(fmt::format("{} {} is missing", kTables[table].name, seq));
        return {};
      }
      hash_row(kTables[table], rows_[table]);
      ++report_.rows;
    }
    last_[table] = std::max(last_[table], to);
    return {};
  }

  // Reports rows that no link covers.
  Result<> check_rest() {
    for (std::size_t i = 0; i < kRunTables; ++i) {
      auto row = rows_[i].step();
      if (!row) return fail(row.error());
      if (*row) find(fmt::format("{} {} is in no link", kTables[i].name, rows_[i].integer(1)));
    }
    if (report_.ended) return {};
    auto ended = has_end(db_, run_);
    if (!ended) return fail(ended.error());
    if (*ended) find("the run_end row is in no link");
    return {};
  }

  void find(std::string finding) {
    if (report_.finding.empty()) report_.finding = std::move(finding);
  }

  const Database& db_;
  std::int64_t run_;
  std::vector<Statement> rows_;  // by RunTable; each at the next row of its table
  std::array<std::int64_t, kRunTables> last_{};
  RowHash hash_;
  std::optional<Anchor> anchor_;
  Anchor end_;  // the link with the end of the run
  std::optional<CopiedFrom> copied_;
  std::optional<std::string> uuid_;
  ChainReport report_;
};

Result<ChainReport> verify_snapshot(const Database& db, std::int64_t run,
                                    const std::optional<Anchor>& anchor) {
  std::optional<Transaction> snapshot;  // absent when the caller's transaction is used
  if (!db.in_transaction()) {
    auto begun = Transaction::begin_read(db);
    if (!begun) return fail(begun.error());
    snapshot.emplace(std::move(*begun));
  }
  auto known = db.holds(
      "SELECT EXISTS (SELECT 1 FROM run WHERE id = ?1) OR EXISTS"
      " (SELECT 1 FROM chain WHERE run_id = ?1)",
      run);
  if (!known) return fail(known.error());
  if (!*known) return fail(no_such_run(db, run));
  return Verifier(db, run, anchor).verify();
}

}  // namespace

Result<RowWriter> RowWriter::prepare(const Database& db, std::string_view table) {
  const TableSpec& spec = spec_of(table);
  auto statement = db.prepare(fmt::format("INSERT INTO {} ({}) VALUES ({})", spec.name,
                                          spec.columns, placeholders(spec.columns)));
  if (!statement) return fail(statement.error());
  RowWriter writer;
  writer.statement_ = std::move(*statement);
  writer.tag_ = spec.tag;
  return writer;
}

RowWriter& RowWriter::begin(RowHash& hash) {
  hash_ = &hash;
  next_ = 0;
  hash.row(tag_);
  return *this;
}

RowWriter& RowWriter::add_number(std::int64_t stored, std::int64_t hashed) {
  statement_.bind(next_++, stored);
  hash_->integer(hashed);
  return *this;
}

void RowWriter::put(double value) {
  if (std::isnan(value)) return put_null();  // as SQLite stores a NaN
  value += 0.0;  // turns -0.0 into 0.0, as SQLite does
  statement_.bind(next_++, value);
  hash_->real(value);
}

void RowWriter::put(std::string_view text) {
  statement_.bind(next_++, text);
  hash_->text(text);
}

void RowWriter::put_null() {
  statement_.bind_null(next_++);
  hash_->null();
}

Result<ChainWriter> ChainWriter::prepare(const Database& db) {
  auto head = db.prepare(fmt::format("{} DESC LIMIT 1", kLinks));
  if (!head) return fail(head.error());
  auto append = db.prepare("INSERT INTO chain VALUES (?,?,?,?,?,?,?,?,?)");
  if (!append) return fail(append.error());
  auto anchor = db.prepare("INSERT OR IGNORE INTO run_anchor VALUES (?,?,?)");
  if (!anchor) return fail(anchor.error());
  ChainWriter writer;
  writer.anchor_ = std::move(*anchor);
  writer.head_ = std::move(*head);
  writer.append_ = std::move(*append);
  return writer;
}

Result<ChainHead> ChainWriter::head(std::int64_t run) {
  ChainHead out;
  out.run = run;
  head_.bind(0, run);
  auto row = head_.step();
  if (!row) return fail(row.error());
  if (*row) read_link(head_, out);
  head_.reset();
  return out;
}

Result<> ChainWriter::append(ChainHead& head, RowHash& rows) {
  const Sha256 hash = rows.finish();
  append_.bind(0, head.run);
  append_.bind(1, head.seq + 1);
  for (std::size_t i = 0; i < kRunTables; ++i) append_.bind(static_cast<int>(i) + 2, head.last[i]);
  append_.bind(7, std::int64_t{head.ended ? 1 : 0});
  append_.bind_blob(8, hash);
  if (auto r = append_.run(); !r) return r;
  ++head.seq;
  head.hash = hash;
  return {};
}

Result<> ChainWriter::anchor(const ChainHead& head) {
  anchor_.bind(0, head.run);
  anchor_.bind(1, head.seq);
  anchor_.bind_blob(2, head.hash);
  return anchor_.run();
}

Result<ChainReport> verify_chain(const Database& db, std::int64_t run,
                                 const std::optional<Anchor>& anchor) {
  for (;;) {
    auto report = verify_snapshot(db, run, anchor);
    if (!report || !report->intact || report->ended) return report;
    auto asked = keep(is_being_recorded(db.path(), run), report->goes_on);
    if (!asked) return fail(asked.error());
    if (report->goes_on) return report;
    auto ended = has_end(db, run);
    if (!ended) return fail(ended.error());
    if (*ended) continue;  // it ended during the check, so check again
    report->intact = false;
    report->not_closed = true;
    report->finding =
        "it has no end, and nobody records it: it was cut off, or its end was deleted";
    return report;
  }
}

std::future<Result<ChainReport>> verify_aside(const Database& db, std::int64_t run) {
  return std::async(std::launch::async,
                    [path = db.path(), vfs = db.vfs(), run]() -> Result<ChainReport> {
                      auto own = open_read_only(path, vfs);
                      if (!own) return fail(own.error());
                      return verify_chain(*own, run);
                    });
}

std::optional<Anchor> anchor_of(const ChainReport& chain) {
  if (!chain.intact) return std::nullopt;
  return chain.head;
}

std::string remark_on(const ChainReport& chain) {
  return chain.intact ? "" : "not as it was recorded: " + chain.finding;
}

}  // namespace lcrig
