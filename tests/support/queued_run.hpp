// SPDX-License-Identifier: Apache-2.0
// Entries of a stored queue and the runs that they become, for tests without a daemon.
#pragma once

#include <string>
#include <vector>

#include "storage/queue_run.hpp"
#include "storage/runs.hpp"

namespace lcrig {

inline QueuedRun queued(const std::string& specimen, const std::string& protocol = "press") {
  QueuedRun out;
  out.protocol_name = protocol;
  out.protocol_text = "text of " + protocol;
  out.specimen_name = specimen;
  out.specimen_text = "file of " + specimen;
  return out;
}

inline QueueActor by(const std::string& user, std::int64_t uid = 1000) {
  QueueActor out;
  out.user = user;
  out.uid = uid;
  out.now_unix_ns = 1;
  return out;
}

inline Result<std::int64_t> add_one(const Database& db, const QueuedRun& run,
                                    QueuePlace place = QueuePlace()) {
  const std::vector<QueuedRun> runs{run};
  auto entries = add_to_queue(db, runs, place, by("lab"));
  if (!entries) return fail(entries.error());
  return entries->front();
}

// Inserts the row of the run that carries out this entry.
inline Result<std::int64_t> begin_entry(const Database& db, std::int64_t entry,
                                        const std::string& specimen = "s") {
  RunRow row;
  row.protocol_name = "press";
  row.specimen_name = specimen;
  row.started_unix_ns = 1;
  row.queue_entry = entry;
  return insert_run(db, row);
}

inline Result<> close_run(const Database& db, std::int64_t run, ExitStatus status) {
  RunEnd end;
  end.status = status;
  if (status != ExitStatus::success) end.reason = "a reason";
  end.ended = MonoTime(Duration(1));
  return insert_run_end(db, run, end);
}

inline std::vector<std::int64_t> order_of(const Database& db) {
  std::vector<std::int64_t> out;
  const auto entries = list_queue(db, 0, 1'000'000).value();
  out.reserve(entries.size());
  for (const auto& e : entries) out.push_back(e.entry);
  return out;
}

}  // namespace lcrig
