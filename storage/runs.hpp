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

// Everything known before the first sample. `*_json` are JSON texts; "{}" means that nothing is
// known.
struct RunRow {
  std::string uuid;  // empty: insert_run makes one; or the schema is older than uuids
  std::string protocol_name, protocol_text;
  std::string parameters_json = "{}";
  std::optional<std::int64_t> specimen_id;  // StoredSpecimen::id
  std::string specimen_name, specimen_text;
  std::optional<double> probe_diameter_m;
  std::string lcr_identity, frame_identity;  // replies exactly as sent
  std::string lcr_settings_json = "{}";  // as read back from the meter
  std::string frame_capabilities_json = "{}", frame_limits_json = "{}";
  std::string correction_json = "{}";  // MeterCorrections
  // For a new run: insert_run adds when each was made, and stores it as correction_json.
  std::optional<MeterCorrections> corrections;
  std::string bench_name, bench_text;
  bool simulated = false;
  std::optional<std::int64_t> seed;
  std::optional<std::string> model_level, model_error_json;  // simulated runs only
  std::string software_version = std::string(program_version());
  std::string operator_name, note;
  std::int64_t started_unix_ns = 0;  // the same instant on both clocks
  MonoTime started;
  // Of a rehearsal, whose clock always begins at the same instant: when it was made.
  std::optional<std::int64_t> made_unix_ns;
  std::string boot_id;
  // The entry of the queue that this run belongs to; it is stored in table queue_attempt.
  std::optional<std::int64_t> queue_entry;
  std::optional<CopiedFrom> copied_from;  // set by get_run; empty for a new run

  std::optional<double> probe_area_m2() const;  // pressure is force divided by it
};

struct RunEnd {
  ExitStatus status = ExitStatus::success;
  std::string reason;
  std::optional<MonoTime> ended;  // absent: unknown (interrupted)
  std::int64_t ended_unix_ns = 0;
  std::optional<Anchor> anchor;  // of the chain; set once the end is stored
  bool moved = false;  // the file no longer has its name; set once the end is stored
};

struct RunNote {
  std::int64_t seq = 0;
  std::string operator_name, text;
  std::int64_t added_unix_ns = 0;
};

// One line of `lcrig runs`. Its counts are those of the last commit. `lcr_readings` has the proven
// readings (storage/proof.hpp), `unproven_readings` the others.
struct RunListing {
  std::int64_t run = 0;
  std::string uuid;  // empty: the schema is older
  std::vector<std::string> tags;  // in alphabetical order
  std::string protocol_name, specimen_name, operator_name;
  bool simulated = false;
  std::string bench_name;  // of a simulated run; may be that of a recording (replay_directory)
  std::int64_t started_unix_ns = 0;
  std::optional<std::int64_t> made_unix_ns;  // of a rehearsal (RunRow)
  std::optional<ExitStatus> exit_status;  // absent: the run goes on, or was cut off
  bool goes_on = false;
  std::string reason;
  std::optional<std::int64_t> ended_unix_ns;
  std::int64_t lcr_readings = 0, frame_samples = 0, levels = 0, events = 0;
  std::int64_t unproven_readings = 0;
};

// Selects the runs that meet all given conditions.
struct RunFilter {
  std::string specimen, protocol, operator_name;  // empty: any
  std::string status;  // a word of status_of(); empty: any
  std::string tag;  // empty: any or none
  std::optional<std::int64_t> since_unix_ns;  // truly made then or later
};

// When a run was truly made, whatever its own clock showed.
template <class Run>
std::int64_t true_time_ns(const Run& run) {
  return run.made_unix_ns.value_or(run.started_unix_ns);
}

// How the run ended; "running" while it is recorded; "cut off" when it has no end and no recorder.
std::string_view status_of(const RunListing& listing);

// The bench name of a run that plays a recording back: "replay:DIR".
std::string replay_bench(std::string_view directory);
std::optional<std::string> replay_directory(std::string_view bench);  // nullopt: a real bench

// What stood for the instruments of such a run: "simulated", or "replayed" for a recording.
std::string_view stand_in_word(std::string_view bench);

// The kernel's id of this boot; empty when it has none.
std::string read_boot_id();

// Certain only for the sole writer of runs.
Result<std::int64_t> next_run_number(const Database& db);

// Each writer is one transaction and one link of the run's hash chain. insert_run also begins the
// run's entry of the queue in its transaction (claim_queue_entry: storage/queue_run.hpp).
Result<std::int64_t> insert_run(const Database& db, const RunRow& row);
Result<> insert_run_end(const Database& db, std::int64_t run, const RunEnd& end);
Result<> add_run_note(const Database& db, std::int64_t run, std::string_view operator_name,
                      std::string_view text, std::int64_t now_unix_ns);  // the run must have ended
// close_orphaned_runs closes runs without an end as `interrupted`. Only the sole writer may call
// it, while no run is active.
Result<std::vector<std::int64_t>> unfinished_runs(const Database& db);  // without an end
Result<std::vector<std::int64_t>> close_orphaned_runs(const Database& db, std::int64_t now_unix_ns);

// `text` is "12", "last", or the beginning of a uuid. Errors: no such run, several such runs, or no
// valid text.
Result<std::int64_t> find_run(const Database& db, std::string_view text);
// When the last run ended that was recorded here; nullopt: there is none.
Result<std::optional<std::int64_t>> last_run_end_unix_ns(const Database& db);
Result<std::vector<RunListing>> list_runs(const Database& db,
                                          const RunFilter& filter = {});  // newest first
Result<RunListing> get_run_listing(const Database& db, std::int64_t run);
Result<RunRow> get_run(const Database& db, std::int64_t run);
Result<std::vector<RunNote>> get_run_notes(const Database& db, std::int64_t run);

}  // namespace lcrig
