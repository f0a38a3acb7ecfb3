-- SPDX-License-Identifier: Apache-2.0
-- A reading counts only between two equal read-backs of the meter's settings (docs/database.md,
-- "Proven readings"). Readings never change: events `read_back` and `unproven` say which of them
-- are proven. Runs without an event `read_back` are older, and nothing is known of theirs.
-- storage/proof.cpp has the same rule for the programs.

-- The spans of readings that are not proven, and the read-backs. Few rows of a run are in them.
CREATE INDEX event_unproven ON event (
  run_id,
  CASE WHEN json_valid(detail) THEN json_extract(detail, '$.asked_from_mono_ns') END,
  CASE WHEN json_valid(detail) THEN json_extract(detail, '$.asked_to_mono_ns') END
) WHERE kind = 'unproven';
CREATE INDEX event_read_back ON event (run_id) WHERE kind = 'read_back';
CREATE INDEX event_proof ON event (run_id, at_mono_ns)
WHERE CASE kind
  WHEN 'settings' THEN 1
  WHEN 'read_back' THEN CASE WHEN json_valid(detail) THEN json_extract(detail, '$.equal') END
END;

DROP VIEW v_reading;
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
    CASE WHEN l.flags & 16 THEN ' after_gap' ELSE '' END ||
    CASE WHEN l.flags & 32 THEN ' out_of_range' ELSE '' END ||
    CASE
      WHEN NOT EXISTS (
        SELECT 1 FROM event AS e INDEXED BY event_read_back
        WHERE e.run_id = l.run_id AND e.kind = 'read_back'
      ) THEN ''
      WHEN NOT EXISTS (
        SELECT 1 FROM event AS e INDEXED BY event_proof
        WHERE e.run_id = l.run_id AND e.at_mono_ns > l.asked_mono_ns
          AND CASE e.kind
            WHEN 'settings' THEN 1
            WHEN 'read_back' THEN
              CASE WHEN json_valid(e.detail) THEN json_extract(e.detail, '$.equal') END
          END
      ) THEN ' unproven'
      WHEN EXISTS (
        SELECT 1 FROM event AS e INDEXED BY event_unproven
        WHERE e.run_id = l.run_id AND e.kind = 'unproven'
          AND CASE WHEN json_valid(e.detail)
            THEN json_extract(e.detail, '$.asked_from_mono_ns') END <= +l.asked_mono_ns
          AND CASE WHEN json_valid(e.detail)
            THEN json_extract(e.detail, '$.asked_to_mono_ns') END >= +l.asked_mono_ns
      ) THEN ' unproven'
      ELSE ''
    END
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

DROP VIEW v_level;
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
  (
    SELECT count(*) FROM v_reading AS n
    WHERE n.run = v.run_id AND n.level = v.level AND n.reading IS NOT NULL
      AND n.flags NOT LIKE '%unproven%'
  ) AS proven_readings,  -- of the planned ones; where nothing was read back: all that were taken
  EXISTS (
    SELECT 1 FROM event AS e
    WHERE e.run_id = v.run_id AND e.kind = 'level_abandoned'
      AND json_extract(e.detail, '$.level') = v.level
  ) AS abandoned  -- an instrument was lost in it: its readings count for nothing
FROM level AS v
JOIN run AS r ON r.id = v.run_id;
