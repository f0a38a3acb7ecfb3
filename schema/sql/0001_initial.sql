-- SPDX-License-Identifier: Apache-2.0
-- Runs and everything recorded in them. Coherent SI, the unit is in the name; times are integer
-- nanoseconds: `_mono_ns` of the run's monotonic clock, `_unix_ns` where a wall clock is meant.
-- NULL means missing. No stored row is ever changed or deleted; a correction is a new row.

CREATE TABLE specimen (
  id INTEGER PRIMARY KEY,
  name TEXT NOT NULL CHECK (name <> ''),
  version INTEGER NOT NULL CHECK (version >= 1),  -- 1, 2, ... of this name
  sha256 TEXT NOT NULL CHECK (length(sha256) = 64),  -- of `text`, hex
  text TEXT NOT NULL,  -- the file as it was
  added_unix_ns INTEGER NOT NULL,
  UNIQUE (name, version)
) STRICT;

-- Everything known before the first sample.
CREATE TABLE run (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  protocol_name TEXT NOT NULL,
  protocol_text TEXT NOT NULL,
  protocol_sha256 TEXT NOT NULL CHECK (length(protocol_sha256) = 64),
  parameters_json TEXT NOT NULL CHECK (json_valid(parameters_json)),
  specimen_id INTEGER REFERENCES specimen (id),
  specimen_name TEXT NOT NULL,
  specimen_text TEXT NOT NULL,
  probe_diameter_m REAL CHECK (probe_diameter_m > 0),
  lcr_identity TEXT NOT NULL,
  frame_identity TEXT NOT NULL,
  lcr_settings_json TEXT NOT NULL CHECK (json_valid(lcr_settings_json)),  -- as read back
  frame_capabilities_json TEXT NOT NULL CHECK (json_valid(frame_capabilities_json)),
  frame_limits_json TEXT NOT NULL CHECK (json_valid(frame_limits_json)),
  correction_json TEXT NOT NULL CHECK (json_valid(correction_json)),
  bench_name TEXT NOT NULL,
  bench_text TEXT NOT NULL,
  simulated INTEGER NOT NULL CHECK (simulated IN (0, 1)),
  seed INTEGER,
  model_level TEXT,  -- of a simulated run
  model_error_json TEXT CHECK (model_error_json IS NULL OR json_valid(model_error_json)),
  software_version TEXT NOT NULL,
  operator TEXT NOT NULL,
  note TEXT NOT NULL,
  started_unix_ns INTEGER NOT NULL,  -- the same instant ...
  started_mono_ns INTEGER NOT NULL,  -- ... on both clocks
  boot_id TEXT NOT NULL  -- monotonic times compare only within one boot
) STRICT;

CREATE TABLE run_end (
  run_id INTEGER PRIMARY KEY REFERENCES run (id),
  exit_status TEXT NOT NULL CHECK (exit_status IN ('success', 'abort', 'fail', 'interrupted')),
  reason TEXT NOT NULL,
  ended_mono_ns INTEGER,  -- NULL: not known (interrupted)
  ended_unix_ns INTEGER NOT NULL
) STRICT;

CREATE TABLE run_note (
  run_id INTEGER NOT NULL REFERENCES run (id),
  seq INTEGER NOT NULL CHECK (seq >= 1),
  operator TEXT NOT NULL,
  text TEXT NOT NULL CHECK (text <> ''),
  added_unix_ns INTEGER NOT NULL,
  PRIMARY KEY (run_id, seq)
) STRICT, WITHOUT ROWID;

-- A `measure` step as it was executed.
CREATE TABLE level (
  run_id INTEGER NOT NULL REFERENCES run (id),
  seq INTEGER NOT NULL CHECK (seq >= 1),
  level INTEGER NOT NULL CHECK (level >= 1),
  step_id TEXT NOT NULL,
  repeat INTEGER NOT NULL CHECK (repeat >= 0),
  level_index INTEGER NOT NULL CHECK (level_index >= 0),  -- within the repeat
  target_force_N REAL,
  target_pressure_Pa REAL,
  planned_readings INTEGER NOT NULL CHECK (planned_readings >= 0),
  begin_mono_ns INTEGER NOT NULL,
  PRIMARY KEY (run_id, seq)
) STRICT, WITHOUT ROWID;
CREATE UNIQUE INDEX level_by_number ON level (run_id, level);

CREATE TABLE event (
  run_id INTEGER NOT NULL REFERENCES run (id),
  seq INTEGER NOT NULL CHECK (seq >= 1),
  at_mono_ns INTEGER NOT NULL,
  kind TEXT NOT NULL CHECK (kind <> ''),
  step_id TEXT NOT NULL,
  detail TEXT NOT NULL,
  PRIMARY KEY (run_id, seq)
) STRICT, WITHOUT ROWID;

-- The two values of a reading stand in the columns that its function names.
CREATE TABLE lcr_reading (
  run_id INTEGER NOT NULL REFERENCES run (id),
  seq INTEGER NOT NULL CHECK (seq >= 1),
  asked_mono_ns INTEGER NOT NULL,
  first_byte_mono_ns INTEGER NOT NULL,
  last_byte_mono_ns INTEGER NOT NULL,
  planned_mono_ns INTEGER,
  step_id TEXT NOT NULL,
  repeat INTEGER NOT NULL CHECK (repeat >= 0),
  level INTEGER CHECK (level >= 1),  -- NULL: not one of a `measure` step
  reading_index INTEGER CHECK (reading_index >= 1),  -- within the level; NULL: not counted
  fresh INTEGER NOT NULL CHECK (fresh IN (0, 1)),  -- 0: the meter repeated its last value
  flags INTEGER NOT NULL CHECK (flags >= 0),  -- storage/flags.hpp
  function TEXT NOT NULL,
  status TEXT NOT NULL,  -- comparator words as sent
  capacitance_F REAL,
  dissipation REAL,
  resistance_ohm REAL,
  reactance_ohm REAL,
  impedance_ohm REAL,
  phase_rad REAL,
  phase_deg REAL,
  CHECK (asked_mono_ns <= first_byte_mono_ns AND first_byte_mono_ns <= last_byte_mono_ns),
  PRIMARY KEY (run_id, seq)
) STRICT, WITHOUT ROWID;

CREATE TABLE frame_sample (
  run_id INTEGER NOT NULL REFERENCES run (id),
  seq INTEGER NOT NULL CHECK (seq >= 1),
  received_mono_ns INTEGER NOT NULL,
  device_seq INTEGER NOT NULL,
  device_time_s REAL,
  force_N REAL,
  travel_m REAL,  -- of the machine, not the gap
  flags INTEGER NOT NULL CHECK (flags >= 0),  -- storage/flags.hpp
  PRIMARY KEY (run_id, seq)
) STRICT, WITHOUT ROWID;

-- One link per commit: the last row of each table that it holds, and the hash over all rows of this
-- commit and the link before (storage/chain.hpp).
CREATE TABLE chain (
  run_id INTEGER NOT NULL REFERENCES run (id),
  seq INTEGER NOT NULL CHECK (seq >= 1),
  level_seq INTEGER NOT NULL,
  event_seq INTEGER NOT NULL,
  lcr_reading_seq INTEGER NOT NULL,
  frame_sample_seq INTEGER NOT NULL,
  run_note_seq INTEGER NOT NULL,
  run_end INTEGER NOT NULL CHECK (run_end IN (0, 1)),  -- 1: the run's end was stored by then
  sha256 BLOB NOT NULL CHECK (length(sha256) = 32),
  PRIMARY KEY (run_id, seq)
) STRICT, WITHOUT ROWID;

CREATE INDEX run_by_start ON run (started_unix_ns);

CREATE TRIGGER specimen_no_update BEFORE UPDATE ON specimen BEGIN
  SELECT RAISE(ABORT, 'specimen rows are append-only');
END;
CREATE TRIGGER specimen_no_delete BEFORE DELETE ON specimen BEGIN
  SELECT RAISE(ABORT, 'specimen rows are append-only');
END;
CREATE TRIGGER run_no_update BEFORE UPDATE ON run BEGIN
  SELECT RAISE(ABORT, 'run rows are append-only');
END;
CREATE TRIGGER run_no_delete BEFORE DELETE ON run BEGIN
  SELECT RAISE(ABORT, 'run rows are append-only');
END;
CREATE TRIGGER run_end_no_update BEFORE UPDATE ON run_end BEGIN
  SELECT RAISE(ABORT, 'run_end rows are append-only');
END;
CREATE TRIGGER run_end_no_delete BEFORE DELETE ON run_end BEGIN
  SELECT RAISE(ABORT, 'run_end rows are append-only');
END;
CREATE TRIGGER run_note_no_update BEFORE UPDATE ON run_note BEGIN
  SELECT RAISE(ABORT, 'run_note rows are append-only');
END;
CREATE TRIGGER run_note_no_delete BEFORE DELETE ON run_note BEGIN
  SELECT RAISE(ABORT, 'run_note rows are append-only');
END;
CREATE TRIGGER level_no_update BEFORE UPDATE ON level BEGIN
  SELECT RAISE(ABORT, 'level rows are append-only');
END;
CREATE TRIGGER level_no_delete BEFORE DELETE ON level BEGIN
  SELECT RAISE(ABORT, 'level rows are append-only');
END;
CREATE TRIGGER event_no_update BEFORE UPDATE ON event BEGIN
  SELECT RAISE(ABORT, 'event rows are append-only');
END;
CREATE TRIGGER event_no_delete BEFORE DELETE ON event BEGIN
  SELECT RAISE(ABORT, 'event rows are append-only');
END;
CREATE TRIGGER lcr_reading_no_update BEFORE UPDATE ON lcr_reading BEGIN
  SELECT RAISE(ABORT, 'lcr_reading rows are append-only');
END;
CREATE TRIGGER lcr_reading_no_delete BEFORE DELETE ON lcr_reading BEGIN
  SELECT RAISE(ABORT, 'lcr_reading rows are append-only');
END;
CREATE TRIGGER frame_sample_no_update BEFORE UPDATE ON frame_sample BEGIN
  SELECT RAISE(ABORT, 'frame_sample rows are append-only');
END;
CREATE TRIGGER frame_sample_no_delete BEFORE DELETE ON frame_sample BEGIN
  SELECT RAISE(ABORT, 'frame_sample rows are append-only');
END;
CREATE TRIGGER chain_no_update BEFORE UPDATE ON chain BEGIN
  SELECT RAISE(ABORT, 'chain rows are append-only');
END;
CREATE TRIGGER chain_no_delete BEFORE DELETE ON chain BEGIN
  SELECT RAISE(ABORT, 'chain rows are append-only');
END;
