-- SPDX-License-Identifier: Apache-2.0
-- What people answered to the `ask` steps of a run, one row for each answer (docs/database.md). The
-- rows are those of the events of kind `answer`.

CREATE VIEW v_answer AS
SELECT
  e.run_id AS run,
  e.seq,
  (e.at_mono_ns - r.started_mono_ns) / 1e9 AS t_s,
  e.step_id AS step,
  json_extract(e.detail, '$.repeat') AS repeat,
  json_extract(e.detail, '$.question') AS question,
  json_extract(e.detail, '$.type') AS type,
  CAST(json_extract(e.detail, '$.number') AS REAL) AS number,
  json_extract(e.detail, '$.unit') AS unit,
  json_extract(e.detail, '$.text') AS text,
  json_extract(e.detail, '$.source') AS source,
  json_extract(e.detail, '$.by') AS answered_by,
  json_extract(e.detail, '$.from_run') AS from_run
FROM event AS e
JOIN run AS r ON r.id = e.run_id
WHERE e.kind = 'answer';
