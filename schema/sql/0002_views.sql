-- SPDX-License-Identifier: Apache-2.0
-- Views for people who read the database with SQL, in the units and words of the exported files
-- (docs/database.md). lcrig itself reads the tables.

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

CREATE VIEW v_reading AS
SELECT
  l.run_id AS run,
  l.seq,
  (l.last_byte_mono_ns - r.started_mono_ns) / 1e9 AS t_s,
  (l.asked_mono_ns - r.started_mono_ns) / 1e9 AS t_asked_s,
  l.step_id AS step,
  l.repeat,
  l.level,
  l.reading_index AS reading,
  l.fresh,
  trim(
    CASE WHEN l.flags & 1 THEN ' overload_primary' ELSE '' END ||
    CASE WHEN l.flags & 2 THEN ' overload_secondary' ELSE '' END ||
    CASE WHEN l.flags & 4 THEN ' after_resync' ELSE '' END ||
    CASE WHEN l.flags & 8 THEN ' after_set_up' ELSE '' END ||
    CASE WHEN l.flags & 16 THEN ' after_gap' ELSE '' END
  ) AS flags,
  l.function,
  l.capacitance_F * 1e12 AS capacitance_pF,
  l.dissipation,
  l.resistance_ohm,
  l.reactance_ohm,
  l.impedance_ohm,
  l.phase_rad,
  l.phase_deg,
  l.status
FROM lcr_reading AS l
JOIN run AS r ON r.id = l.run_id;

CREATE VIEW v_sample AS
SELECT
  s.run_id AS run,
  s.seq,
  (s.received_mono_ns - r.started_mono_ns) / 1e9 AS t_received_s,
  s.device_time_s,
  s.force_N,
  s.travel_m * 1e3 AS travel_mm,
  s.force_N / (r.probe_diameter_m * r.probe_diameter_m * 0.78539816339744831) / 1e3 AS pressure_kPa,
  trim(
    CASE WHEN s.flags & 1 THEN ' moving' ELSE '' END ||
    CASE WHEN s.flags & 2 THEN ' force_control' ELSE '' END ||
    CASE WHEN s.flags & 4 THEN ' force_overload' ELSE '' END ||
    CASE WHEN s.flags & 8 THEN ' after_gap' ELSE '' END
  ) AS flags
FROM frame_sample AS s
JOIN run AS r ON r.id = s.run_id;

CREATE VIEW v_level AS
SELECT
  v.run_id AS run,
  v.level,
  v.step_id AS step,
  v.repeat,
  v.level_index AS index_in_repeat,
  (v.begin_mono_ns - r.started_mono_ns) / 1e9 AS begin_s,
  v.target_force_N,
  v.target_pressure_Pa / 1e3 AS target_pressure_kPa,
  v.planned_readings,
  EXISTS (
    SELECT 1 FROM event AS e
    WHERE e.run_id = v.run_id AND e.kind = 'level_abandoned'
      AND json_extract(e.detail, '$.level') = v.level
  ) AS abandoned  -- an instrument was lost in it: its readings count for nothing
FROM level AS v
JOIN run AS r ON r.id = v.run_id;
