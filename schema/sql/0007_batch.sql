-- SPDX-License-Identifier: Apache-2.0
-- Tables of runs that were queued together (docs/batch-file.md): where each entry is from, and the
-- order that was drawn. Rows never change.

CREATE TABLE batch (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  name TEXT NOT NULL UNIQUE CHECK (name <> ''),
  file_name TEXT NOT NULL,
  file_sha256 TEXT NOT NULL REFERENCES queue_text (sha256),  -- the table as it was written
  run_order TEXT NOT NULL CHECK (run_order IN ('given', 'blocks', 'random')),
  seed INTEGER,  -- of the order; NULL: it was given
  added_by TEXT NOT NULL,
  added_uid INTEGER NOT NULL,
  added_unix_ns INTEGER NOT NULL,
  CHECK ((seed IS NULL) = (run_order = 'given'))
) STRICT;

CREATE TABLE batch_entry (
  batch_id INTEGER NOT NULL REFERENCES batch (id),
  position INTEGER NOT NULL CHECK (position >= 1),  -- in the order that was drawn
  entry_id INTEGER NOT NULL UNIQUE REFERENCES queue_entry (id),
  line INTEGER NOT NULL,  -- of the file, where its row begins
  repeat INTEGER NOT NULL CHECK (repeat >= 1),
  PRIMARY KEY (batch_id, position)
) STRICT, WITHOUT ROWID;

CREATE TRIGGER batch_no_update BEFORE UPDATE ON batch BEGIN
  SELECT RAISE(ABORT, 'batch rows are append-only');
END;
CREATE TRIGGER batch_no_delete BEFORE DELETE ON batch BEGIN
  SELECT RAISE(ABORT, 'batch rows are append-only');
END;
CREATE TRIGGER batch_entry_no_update BEFORE UPDATE ON batch_entry BEGIN
  SELECT RAISE(ABORT, 'batch_entry rows are append-only');
END;
CREATE TRIGGER batch_entry_no_delete BEFORE DELETE ON batch_entry BEGIN
  SELECT RAISE(ABORT, 'batch_entry rows are append-only');
END;
