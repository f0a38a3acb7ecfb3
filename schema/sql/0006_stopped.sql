-- SPDX-License-Identifier: Apache-2.0
-- A run may end as `stopped`: it finished what somebody asked it to finish, and unloaded
-- (docs/protocol-file.md). SQLite cannot change a CHECK, so the table is made anew with the same
-- rows; the hash chain covers the rows, which are as they were.

DROP VIEW v_run;

CREATE TABLE run_end_anew (
  run_id INTEGER PRIMARY KEY REFERENCES run (id),
  exit_status TEXT NOT NULL
    CHECK (exit_status IN ('success', 'abort', 'fail', 'interrupted', 'stopped')),
  reason TEXT NOT NULL,
  ended_mono_ns INTEGER,  -- NULL: not known (interrupted)
  ended_unix_ns INTEGER NOT NULL
) STRICT;
INSERT INTO run_end_anew SELECT run_id, exit_status, reason, ended_mono_ns, ended_unix_ns
FROM run_end;
DROP TABLE run_end;
ALTER TABLE run_end_anew RENAME TO run_end;

CREATE TRIGGER run_end_no_update BEFORE UPDATE ON run_end BEGIN
  SELECT RAISE(ABORT, 'run_end rows are append-only');
END;
CREATE TRIGGER run_end_no_delete BEFORE DELETE ON run_end BEGIN
  SELECT RAISE(ABORT, 'run_end rows are append-only');
END;

CREATE VIEW v_run AS
SELECT
  r.id AS run,
  strftime('%Y-%m-%dT%H:%M:%SZ', r.started_unix_ns / 1000000000, 'unixepoch') AS started_utc,
  r.protocol_name AS protocol,
  r.specimen_name AS specimen,
  r.operator,
  r.simulated,
  coalesce(e.exit_status, 'open') AS exit_status,  -- open: it goes on, or was never closed
  coalesce(e.reason, '') AS reason,
  (e.ended_mono_ns - r.started_mono_ns) / 1e9 AS duration_s,
  r.probe_diameter_m * 1e3 AS probe_diameter_mm,
  r.parameters_json,
  r.lcr_identity,
  r.frame_identity,
  r.bench_name AS bench,
  r.software_version,
  r.note
FROM run AS r
LEFT JOIN run_end AS e ON e.run_id = r.id;
