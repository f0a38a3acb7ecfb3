// SPDX-License-Identifier: Apache-2.0
// The rows of a run besides its samples: what is known before the first sample, how it ended,
// notes, and queries for lists. Written by the daemon, read by analysis and the command line.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/exit_status.hpp"
#include "base/program_version.hpp"
#include "base/time.hpp"
#include "storage/anchor.hpp"
#include "storage/copied_from.hpp"
#include "storage/corrections.hpp"
#include "storage/sqlite.hpp"

namespace lcrig {

// Everything known before the first sample. `*_json` are JSON texts; "{}" means nothing is known.
struct RunRow {
  std::string uuid;  // empty: insert_run makes one; or of a schema without them
  std::string protocol_name, protocol_text;
  std::string parameters_json = "{}";
  std::optional<std::int64_t> specimen_id;  // StoredSpecimen::id
  std::string specimen_name, specimen_text;
  std::optional<double> probe_diameter_m;
  std::string lcr_identity, frame_identity;  // replies exactly as sent
  std::string lcr_settings_json = "{}";  // as read back from the meter
  std::string frame_capabilities_json = "{}", frame_limits_json = "{}";
  std::string correction_json = "{}";  // MeterCorrections
  // Of a new run: insert_run makes correction_json of it, with when each was made last.
  std::optional<MeterCorrections> corrections;
  std::string bench_name, bench_text;
  bool simulated = false;
  std::optional<std::int64_t> seed;
  std::optional<std::string> model_level, model_error_json;  // of a simulated run
  std::string software_version = std::string(program_version());
  std::string operator_name, note;
  std::int64_t started_unix_ns = 0;  // the same instant on both clocks
  MonoTime started;
  std::string boot_id;
  std::optional<std::int64_t> queue_entry;  // whose turn it is; in a table of its own
  std::optional<CopiedFrom> copied_from;  // as get_run finds it; a new run is recorded here

  std::optional<double> probe_area_m2() const;  // pressure is force over it
};

struct RunEnd {
  ExitStatus status = ExitStatus::success;
  std::string reason;
  std::optional<MonoTime> ended;  // absent: not known (interrupted)
  std::int64_t ended_unix_ns = 0;
  std::optional<Anchor> anchor;  // of the chain; known once it is stored
  bool moved = false;  // the file is not under its name any more; likewise
};

struct RunNote {
  std::int64_t seq = 0;
  std::string operator_name, text;
  std::int64_t added_unix_ns = 0;
};

// One line of `lcrig runs`. Counts are as of the last commit.
struct RunListing {
  std::int64_t run = 0;
  std::string uuid;  // empty: its schema is older
  std::vector<std::string> tags;  // in the order of the alphabet
  std::string protocol_name, specimen_name, operator_name;
  bool simulated = false;
  std::int64_t started_unix_ns = 0;
  std::optional<ExitStatus> exit_status;  // absent: it goes on, or was cut off
  bool goes_on = false;
  std::string reason;
  std::optional<std::int64_t> ended_unix_ns;
  std::int64_t lcr_readings = 0, frame_samples = 0, levels = 0, events = 0;
};

// Which runs are meant: those to which everything applies that is given.
struct RunFilter {
  std::string specimen, protocol, operator_name;  // empty: any
  std::string status;  // as status_of() says it; empty: any
  std::string tag;  // empty: any, and none
  std::optional<std::int64_t> since_unix_ns;  // begun then or later
};

// How the run ended; "running", or "cut off" when it has no end and nobody records it.
std::string_view status_of(const RunListing& listing);

// The bench of a run that plays a recording back is "replay:DIR".
std::string replay_bench(std::string_view directory);
std::optional<std::string> replay_directory(std::string_view bench);  // nullopt: a real bench

// The kernel's id of this boot; empty when it has none.
std::string read_boot_id();

// Only the sole writer of runs knows it for sure.
Result<std::int64_t> next_run_number(const Database& db);

// Writers. Each is one transaction and one link of the run's hash chain. An entry of the queue
// begins in that transaction, too (claim_queue_entry: storage/queue_run.hpp).
Result<std::int64_t> insert_run(const Database& db, const RunRow& row);
Result<> insert_run_end(const Database& db, std::int64_t run, const RunEnd& end);
Result<> add_run_note(const Database& db, std::int64_t run, std::string_view operator_name,
                      std::string_view text, std::int64_t now_unix_ns);  // to a run that has ended
// Closes runs without an end as `interrupted`. Only the sole writer may call it, while no run is
// active.
Result<std::vector<std::int64_t>> unfinished_runs(const Database& db);  // without an end
Result<std::vector<std::int64_t>> close_orphaned_runs(const Database& db, std::int64_t now_unix_ns);

// `text` is "12", "last", or the beginning of a uuid. Errors: no such run, several, none of these.
Result<std::int64_t> find_run(const Database& db, std::string_view text);
// End of the last run that was recorded here and ended; nullopt: none has.
Result<std::optional<std::int64_t>> last_run_end_unix_ns(const Database& db);
Result<std::vector<RunListing>> list_runs(const Database& db,
                                          const RunFilter& filter = {});  // newest first
Result<RunListing> get_run_listing(const Database& db, std::int64_t run);
Result<RunRow> get_run(const Database& db, std::int64_t run);
Result<std::vector<RunNote>> get_run_notes(const Database& db, std::int64_t run);

}  // namespace lcrig
