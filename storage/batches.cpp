// SPDX-License-Identifier: Apache-2.0
#include "storage/batches.hpp"

#include <nlohmann/json.hpp>

#include "base/text.hpp"
#include "storage/database.hpp"
#include "storage/queue_rows.hpp"

namespace lcrig {

namespace {

constexpr std::string_view kBatchColumns =
    "b.id, b.name, b.file_name, b.run_order, b.seed, b.added_by, b.added_unix_ns";

StoredBatch read_batch(const Statement& s) {
  StoredBatch out;
  out.order = BatchOrder::random;  // of a word that is not known
  s.read(out.batch, out.name, out.file_name, out.order, out.seed, out.added_by, out.added_unix_ns);
  return out;
}

Result<bool> stores_batches(const Database& db) {
  return has_table(db, "batch_entry");
}

Result<std::int64_t> insert_batch(const Database& db, const StoredBatch& batch,
                                  std::string_view file_text, const QueueActor& who) {
  if (auto unused = check_batch_name(db, batch.name); !unused) return fail(unused.error());
  auto text = store_queue_text(db, std::string(file_text));
  if (!text) return fail(text.error());
  auto stored = db.change(
      "INSERT INTO batch (name, file_name, file_sha256, run_order, seed, added_by, added_uid,"
      " added_unix_ns) VALUES (?,?,?,?,?,?,?,?)",
      batch.name, batch.file_name, *text, batch.order, batch.seed, who.user, who.uid.value_or(-1),
      who.now_unix_ns);
  if (!stored) return fail(stored.error());
  return db.last_insert_id();
}

BatchListing read_batch_listing(const Statement& s) {
  BatchListing out;
  std::string runs_json;
  s.read(out.position, out.line, out.repeat, out.entry, out.state, out.protocol_name,
         out.parameters_json, out.specimen_name, out.note, runs_json);
  const auto runs = nlohmann::json::parse(runs_json, nullptr, false);
  for (const auto& run : runs) out.runs.push_back(run.get<std::int64_t>());
  return out;
}

}  // namespace

std::string order_words(BatchOrder order, std::int64_t seed) {
  if (order == BatchOrder::given) return "in the order of the table";
  return fmt::format("{}, seed {}", order == BatchOrder::blocks ? "in blocks" : "in random order",
                     seed);
}

Result<std::vector<std::int64_t>> add_batch_to_queue(const Database& db, const StoredBatch& batch,
                                                     std::string_view file_text, std::size_t count,
                                                     const BatchedRuns& run_at, QueuePlace place,
                                                     const QueueActor& who) {
  auto transaction = Transaction::begin(db);
  if (!transaction) return fail(transaction.error());
  auto id = insert_batch(db, batch, file_text, who);
  if (!id) return fail(id.error());
  const auto queued = [&run_at](std::size_t i) { return run_at(i).run; };
  auto entries = insert_into_queue(db, count, queued, place, who, "batch " + batch.name);
  if (!entries) return entries;
  for (std::size_t i = 0; i < count; ++i) {
    const BatchedRun from = run_at(i);
    auto stored = db.change(
        "INSERT INTO batch_entry (batch_id, position, entry_id, line, repeat) VALUES (?,?,?,?,?)",
        *id, static_cast<std::int64_t>(i) + 1, (*entries)[i], from.line, from.repeat);
    if (!stored) return fail(stored.error());
  }
  if (auto r = transaction->commit(); !r) return fail(r.error());
  return entries;
}

Result<> check_batch_name(const Database& db, std::string_view name) {
  auto known = find_batch(db, name);
  if (!known) return fail(known.error());
  if (!*known) return {};
  return fail(Errc::invalid_request,
              "a batch `{}` exists already, added by {}: give another name (--name)",
              printable(name, 100), printable((*known)->added_by, 100));
}

Result<std::optional<StoredBatch>> find_batch(const Database& db, std::string_view name) {
  return read_if(stores_batches(db), [&] {
    return db.first(fmt::format("SELECT {} FROM batch AS b WHERE name = ?", kBatchColumns),
                    read_batch, name);
  });
}

Result<std::vector<StoredBatch>> list_batches(const Database& db) {
  return read_if(stores_batches(db), [&] {
    return db.rows(fmt::format("SELECT {} FROM batch AS b ORDER BY id DESC", kBatchColumns),
                   read_batch);
  });
}

Result<std::vector<BatchListing>> batch_entries(const Database& db, std::int64_t batch) {
  return db.rows(
      "SELECT b.position, b.line, b.repeat, e.id, e.state, e.protocol_name, e.parameters_json,"
      " e.specimen_name, e.note, (SELECT json_group_array(run_id) FROM (SELECT run_id FROM"
      " queue_attempt WHERE entry_id = e.id ORDER BY attempt)) FROM batch_entry AS b"
      " JOIN queue_entry AS e ON e.id = b.entry_id WHERE b.batch_id = ? ORDER BY b.position",
      read_batch_listing, batch);
}

Result<std::optional<EntryBatch>> batch_of_entry(const Database& db, std::int64_t entry) {
  const auto read = [](const Statement& s) {
    EntryBatch out;
    out.batch = read_batch(s);
    out.position = s.integer(7);
    out.line = s.integer(8);
    out.repeat = s.integer(9);
    out.of = s.integer(10);
    return out;
  };
  return read_if(stores_batches(db), [&] {
    return db.first(fmt::format("SELECT {}, e.position, e.line, e.repeat,"
                                " (SELECT count(*) FROM batch_entry WHERE batch_id = b.id)"
                                " FROM batch_entry AS e JOIN batch AS b ON b.id = e.batch_id"
                                " WHERE e.entry_id = ?",
                                kBatchColumns),
                    read, entry);
  });
}

}  // namespace lcrig
