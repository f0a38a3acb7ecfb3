// SPDX-License-Identifier: Apache-2.0
// Checks and plans a table of runs as a whole, then queues it in one transaction.
#include <algorithm>
#include <utility>

#include "base/text.hpp"
#include "daemon/queue/runner.hpp"
#include "daemon/queue/runner_batch.hpp"

namespace lcrig {

namespace {

constexpr std::size_t kEnoughRefusals = 20;  // of plans, each of which takes a while

Result<BatchFile> sent_file(const std::map<std::string, BatchFile>& files, const char* noun,
                            const std::string& word) {
  const auto found = files.find(word);
  if (found != files.end()) return found->second;
  return fail(Errc::invalid_request, "the text of the {} `{}` was not sent", noun,
              printable(word, 60));
}

RunRequest request_of_row(const BatchEntry& row, const std::string& operator_name) {
  RunRequest out;
  out.protocol_name = row.protocol_name;
  out.protocol_text = row.protocol_text;
  out.parameters = row.parameters;
  out.specimen_name = row.specimen_name;
  out.specimen_text = row.specimen_text;
  out.operator_name = operator_name;
  out.note = row.note;
  return out;
}

// Equal for rows that ask for the same run.
std::string key_of_row(const BatchEntry& row) {
  std::string key = row.specimen_name + '\n' + row.protocol_text + '\n';
  for (const auto& [name, value] : row.parameters) {
    key += fmt::format("{}={}\n", name, std::get<std::string>(value));
  }
  return key;
}

}  // namespace

// A specimen without a text may be known to the daemon.
Result<WantedBatch> read_wanted_batch(const BatchAdd& wanted) {
  WantedBatch out;
  auto read = keep(read_batch_table(wanted.table, wanted.file_name), out.table);
  if (!read) return fail(read.error());
  BatchLookup lookup;
  lookup.protocol = [&wanted](const std::string& word) {
    return sent_file(wanted.protocols, "protocol", word);
  };
  lookup.specimen = [&wanted](const std::string& word) {
    if (wanted.specimens.contains(word)) return sent_file(wanted.specimens, "specimen", word);
    BatchFile named;
    named.name = word;
    return Result<BatchFile>(named);
  };
  if (auto good = keep(check_batch(out.table, lookup), out.rows); !good) return fail(good.error());
  out.turns = order_batch(out.rows, wanted.order, static_cast<std::uint64_t>(wanted.seed));
  std::map<std::string, std::size_t> kinds;
  for (const BatchEntry& row : out.rows) {
    const auto [kind, is_new] = kinds.emplace(key_of_row(row), out.kinds.size());
    if (is_new) out.kinds.push_back(request_of_row(row, wanted.operator_name));
    out.kind_of_row.push_back(kind->second);
    out.terms_of_row.push_back(with_row_terms(wanted.terms, row.terms));
  }
  return out;
}

// Plans each kind of run once; the first one looks at the rig.
Task<Result<>> QueueRunner::plan_batch(WantedBatch& batch) {
  BatchMistakes wrong;
  std::size_t refusals = 0;
  PlanOn on = PlanOn::rig;
  std::string why_not;
  for (std::size_t kind = 0; kind < batch.kinds.size() && refusals < kEnoughRefusals; ++kind) {
    RunRequest& run = batch.kinds[kind];
    auto plan = co_await host_.plan_entry(run, on);
    if (!plan) {
      ++refusals;
      const auto row = std::ranges::find(batch.kind_of_row, kind) - batch.kind_of_row.begin();
      const TextPosition at = batch.rows[static_cast<std::size_t>(row)].at;
      wrong.add(at, "", plan.error().what);
      continue;
    }
    if (plan->duration_s) {
      on = PlanOn::as_seen;
    } else if (on == PlanOn::nothing) {
      plan->why_not = why_not;
    } else {
      on = PlanOn::nothing;
      why_not = plan->why_not;
    }
    batch.plans.push_back(std::move(*plan));
  }
  co_return wrong.result(batch.table.source, batch.table.text);
}

namespace {

BatchAdded sum_of_batch(const WantedBatch& batch) {
  BatchAdded out;
  out.entries = static_cast<std::int64_t>(batch.turns.size());
  for (const BatchTurn& turn : batch.turns) {
    const EntryPlan& plan = batch.plans[batch.kind_of_row[turn.row]];
    out.duration_s += plan.duration_s.value_or(0);
    out.measure_readings += plan.measure_readings;
    out.bytes += plan.bytes;
    if (!plan.pressure.empty() &&
        std::ranges::find(out.pressures, plan.pressure) == out.pressures.end()) {
      out.pressures.push_back(plan.pressure);
    }
    if (plan.duration_s) continue;
    ++out.unplanned;
    out.why_not = plan.why_not;
  }
  return out;
}

// Queues the runs that were read and planned.
Result<std::vector<std::int64_t>> store_batch(const Database& db, const BatchAdd& wanted,
                                              const WantedBatch& batch, const QueueActor& who) {
  StoredBatch stored;
  stored.name = wanted.name;
  stored.file_name = wanted.file_name;
  stored.order = wanted.order;
  if (wanted.order != BatchOrder::given) stored.seed = wanted.seed;
  QueuedRun run;
  std::size_t made = batch.rows.size();  // the row from which `run` was made
  const auto run_at = [&](std::size_t i) {
    const BatchTurn& turn = batch.turns[i];
    if (turn.row != made) {
      const std::size_t kind = batch.kind_of_row[turn.row];
      run = stored_form(batch.kinds[kind], batch.terms_of_row[turn.row], batch.plans[kind]);
      run.note = batch.rows[turn.row].note;
      made = turn.row;
    }
    BatchedRun out;
    out.run = &run;
    out.line = batch.rows[turn.row].at.line;
    out.repeat = turn.repeat;
    return out;
  };
  return add_batch_to_queue(db, stored, wanted.table, batch.turns.size(), run_at, wanted.place,
                            who);
}

}  // namespace

Task<Result<BatchAdded>> QueueRunner::add_batch(BatchAdd wanted, PeerCredentials peer) {
  const QueueActor who = co_await actor(std::move(peer));
  if (auto can = check_begin(wanted.terms, clock_.unix_ns() / kSecond_ns); !can) {
    co_return fail(can.error());
  }
  if (wanted.operator_name.empty()) wanted.operator_name = who.user;
  const auto read = [&wanted, &who](const Database& db) -> Result<WantedBatch> {
    if (auto free = not_locked(db, who); !free) return fail(free.error());
    if (auto unused = check_batch_name(db, wanted.name); !unused) return fail(unused.error());
    return read_wanted_batch(wanted);
  };
  auto batch = co_await store_.with(read);
  if (!batch) co_return fail(batch.error());
  auto planned = co_await plan_batch(*batch);
  if (!planned) co_return fail(planned.error());
  BatchAdded out = sum_of_batch(*batch);
  const auto store = [&](const Database& db) -> Result<std::vector<std::int64_t>> {
    if (auto may = may_add(db, who, out.bytes); !may) return fail(may.error());
    return store_batch(db, wanted, *batch, who);
  };
  auto entries = co_await store_.with(store);
  if (!entries) co_return fail(entries.error());
  out.first_entry = entries->front();
  out.last_entry = entries->back();
  co_await tell_change();
  co_return out;
}

}  // namespace lcrig
