-- SPDX-License-Identifier: Apache-2.0
-- A name of each run that stays when it is copied into another database, tags, and where a copied
-- run is from (docs/database.md).

DROP TRIGGER run_no_update;
ALTER TABLE run ADD COLUMN uuid TEXT CHECK (length(uuid) = 36);

-- A run that was recorded before gets its name from its first link, as storage/uuid.cpp makes it:
-- so two copies of one database give a run the same name, and the chain covers it.
UPDATE run SET uuid = (
  SELECT substr(h, 1, 8) || '-' || substr(h, 9, 4) || '-8' || substr(h, 13, 3) || '-8' ||
    substr(h, 16, 3) || '-' || substr(h, 19, 12)
  FROM (SELECT lower(hex(sha256)) AS h FROM chain WHERE run_id = run.id AND seq = 1)
);
-- Without a link, or with that of another run, it is not as it was recorded; but it has a name.
UPDATE run SET uuid = lower(
    hex(randomblob(4)) || '-' || hex(randomblob(2)) || '-4' || substr(hex(randomblob(2)), 2) ||
    '-8' || substr(hex(randomblob(2)), 2) || '-' || hex(randomblob(6)))
WHERE uuid IS NULL OR id NOT IN (SELECT min(id) FROM run GROUP BY uuid);

CREATE UNIQUE INDEX run_by_uuid ON run (uuid);
-- What a list of runs shows, without the long texts of their rows.
CREATE INDEX run_listing ON run (id, started_unix_ns, protocol_name, specimen_name, operator,
  simulated, uuid);
CREATE TRIGGER run_no_update BEFORE UPDATE ON run BEGIN
  SELECT RAISE(ABORT, 'run rows are append-only');
END;
CREATE TRIGGER run_has_uuid BEFORE INSERT ON run WHEN NEW.uuid IS NULL BEGIN
  SELECT RAISE(ABORT, 'a run has a uuid');
END;

-- What people call a run, one row each time that somebody put a tag on it or took it off. The hash
-- chain does not cover it.
CREATE TABLE run_tag (
  run_id INTEGER NOT NULL REFERENCES run (id),
  seq INTEGER NOT NULL CHECK (seq >= 1),
  tag TEXT NOT NULL CHECK (tag <> ''),
  present INTEGER NOT NULL CHECK (present IN (0, 1)),  -- 0: it was taken off
  operator TEXT NOT NULL,
  at_unix_ns INTEGER NOT NULL,
  PRIMARY KEY (run_id, seq)
) STRICT, WITHOUT ROWID;
CREATE INDEX run_tag_by_tag ON run_tag (tag);

-- Runs that were recorded into another database. The hash chain covers their numbers of there.
CREATE TABLE run_copy (
  run_id INTEGER PRIMARY KEY REFERENCES run (id),
  recorded_run INTEGER NOT NULL,
  recorded_specimen_id INTEGER,
  copied_from TEXT NOT NULL,  -- the file
  copied_by TEXT NOT NULL,
  copied_unix_ns INTEGER NOT NULL
) STRICT;

CREATE TRIGGER run_tag_no_update BEFORE UPDATE ON run_tag BEGIN
  SELECT RAISE(ABORT, 'run_tag rows are append-only');
END;
CREATE TRIGGER run_tag_no_delete BEFORE DELETE ON run_tag BEGIN
  SELECT RAISE(ABORT, 'run_tag rows are append-only');
END;
CREATE TRIGGER run_copy_no_update BEFORE UPDATE ON run_copy BEGIN
  SELECT RAISE(ABORT, 'run_copy rows are append-only');
END;
CREATE TRIGGER run_copy_no_delete BEFORE DELETE ON run_copy BEGIN
  SELECT RAISE(ABORT, 'run_copy rows are append-only');
END;

CREATE VIEW v_tag AS
SELECT
  t.run_id AS run,
  t.tag,
  t.operator,
  strftime('%Y-%m-%dT%H:%M:%SZ', t.at_unix_ns / 1000000000, 'unixepoch') AS since_utc
FROM run_tag AS t
WHERE t.present AND NOT EXISTS (
  SELECT 1 FROM run_tag AS later
  WHERE later.run_id = t.run_id AND later.tag = t.tag AND later.seq > t.seq
);

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
  coalesce(c.recorded_run, r.id) AS recorded_run
FROM run AS r
LEFT JOIN run_end AS e ON e.run_id = r.id
LEFT JOIN run_copy AS c ON c.run_id = r.id;
