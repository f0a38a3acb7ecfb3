-- SPDX-License-Identifier: Apache-2.0
-- When a rehearsal was made. Its own clock, of which started_unix_ns is, begins at the same instant
-- whenever it is made, so that it gives the same rows. The hash chain does not cover this time.

CREATE TABLE run_made (
  run_id INTEGER PRIMARY KEY REFERENCES run (id),
  made_unix_ns INTEGER NOT NULL
) STRICT;

CREATE TRIGGER run_made_no_update BEFORE UPDATE ON run_made BEGIN
  SELECT RAISE(ABORT, 'run_made rows are append-only');
END;
CREATE TRIGGER run_made_no_delete BEFORE DELETE ON run_made BEGIN
  SELECT RAISE(ABORT, 'run_made rows are append-only');
END;

DROP VIEW v_run;
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
  r.note,
  r.uuid,
  coalesce(c.recorded_run, r.id) AS recorded_run,
  -- The true time, also of a rehearsal.
  strftime('%Y-%m-%dT%H:%M:%SZ', coalesce(m.made_unix_ns, r.started_unix_ns) / 1000000000,
    'unixepoch') AS made_utc
FROM run AS r
LEFT JOIN run_end AS e ON e.run_id = r.id
LEFT JOIN run_copy AS c ON c.run_id = r.id
LEFT JOIN run_made AS m ON m.run_id = r.id;
