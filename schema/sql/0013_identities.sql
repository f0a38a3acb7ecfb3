-- SPDX-License-Identifier: Apache-2.0
-- Shows which load cell and probe a run states. They stand in frame_capabilities_json, so the hash
-- chain covers them; of older runs they are NULL.

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
    'unixepoch') AS made_utc,
  json_extract(r.frame_capabilities_json, '$.cell_serial') AS cell_serial,
  json_extract(r.frame_capabilities_json, '$.probe_serial') AS probe_serial,
  json_extract(r.frame_capabilities_json, '$.probe_name') AS probe_name
FROM run AS r
LEFT JOIN run_end AS e ON e.run_id = r.id
LEFT JOIN run_copy AS c ON c.run_id = r.id
LEFT JOIN run_made AS m ON m.run_id = r.id;
