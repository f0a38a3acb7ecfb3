-- SPDX-License-Identifier: Apache-2.0
-- Runs that wait for their turn (docs/queue.md). What was asked for never changes: only an entry's
-- place and state do, and each change leaves a row in queue_act.

-- Files of protocols and specimens as they were when they were queued, each once.
CREATE TABLE queue_text (
  sha256 TEXT PRIMARY KEY CHECK (length(sha256) = 64),
  text TEXT NOT NULL
) STRICT, WITHOUT ROWID;

CREATE TABLE queue_entry (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  place INTEGER,  -- orders the entries; NULL: it has left the queue
  state TEXT NOT NULL CHECK (state IN
    ('waiting', 'running', 'interrupted', 'failed', 'done', 'skipped', 'removed')),
  resumes_run INTEGER REFERENCES run (id),  -- a person said that it goes on where this run stopped
  protocol_name TEXT NOT NULL,
  protocol_sha256 TEXT NOT NULL REFERENCES queue_text (sha256),
  parameters_json TEXT NOT NULL CHECK (json_valid(parameters_json)),  -- as somebody typed them
  specimen_name TEXT NOT NULL,
  specimen_sha256 TEXT NOT NULL REFERENCES queue_text (sha256),
  operator TEXT NOT NULL,
  note TEXT NOT NULL,
  terms_json TEXT NOT NULL CHECK (json_valid(terms_json)),  -- what is done after a failure, ...
  plan_json TEXT NOT NULL CHECK (json_valid(plan_json)),  -- what it will take; null: not known
  added_by TEXT NOT NULL,
  added_uid INTEGER NOT NULL,
  added_unix_ns INTEGER NOT NULL,
  CHECK ((place IS NULL) = (state IN ('done', 'skipped', 'removed'))),
  CHECK (resumes_run IS NULL OR state = 'waiting')
) STRICT;
CREATE UNIQUE INDEX queue_entry_by_place ON queue_entry (place) WHERE place IS NOT NULL;

-- Each time that an entry was begun. Written with the row of the run, in one transaction.
CREATE TABLE queue_attempt (
  entry_id INTEGER NOT NULL REFERENCES queue_entry (id),
  attempt INTEGER NOT NULL CHECK (attempt >= 1),
  run_id INTEGER NOT NULL UNIQUE REFERENCES run (id),
  PRIMARY KEY (entry_id, attempt)
) STRICT, WITHOUT ROWID;

-- What was done with the queue, and by whom.
CREATE TABLE queue_act (
  seq INTEGER PRIMARY KEY AUTOINCREMENT,
  at_unix_ns INTEGER NOT NULL,
  act TEXT NOT NULL CHECK (act <> ''),
  entry_id INTEGER REFERENCES queue_entry (id),
  user TEXT NOT NULL,
  uid INTEGER,  -- NULL: lcrigd itself
  detail TEXT NOT NULL
) STRICT;
CREATE INDEX queue_act_by_entry ON queue_act (entry_id);

-- One row.
CREATE TABLE queue_state (
  id INTEGER PRIMARY KEY CHECK (id = 1),
  going INTEGER NOT NULL CHECK (going IN (0, 1)),
  held_cause TEXT NOT NULL,  -- of a queue that does not go
  held_why TEXT NOT NULL,
  failures_in_row INTEGER NOT NULL CHECK (failures_in_row >= 0),
  on_rig TEXT,  -- the specimen, as a person or the last run said; NULL: nobody knows
  locked_by TEXT,
  locked_uid INTEGER,
  locked_why TEXT,
  CHECK ((locked_by IS NULL) = (locked_uid IS NULL) AND (locked_by IS NULL) = (locked_why IS NULL))
) STRICT;
INSERT INTO queue_state (id, going, held_cause, held_why, failures_in_row)
VALUES (1, 0, 'not_started', 'nobody has started it', 0);

CREATE TRIGGER queue_text_no_update BEFORE UPDATE ON queue_text BEGIN
  SELECT RAISE(ABORT, 'queue_text rows are append-only');
END;
CREATE TRIGGER queue_text_no_delete BEFORE DELETE ON queue_text BEGIN
  SELECT RAISE(ABORT, 'queue_text rows are append-only');
END;
CREATE TRIGGER queue_entry_no_change BEFORE UPDATE OF id, protocol_name, protocol_sha256,
  parameters_json, specimen_name, specimen_sha256, operator, note, terms_json, plan_json, added_by,
  added_uid, added_unix_ns ON queue_entry BEGIN
  SELECT RAISE(ABORT, 'what a queue_entry asks for does not change');
END;
CREATE TRIGGER queue_entry_no_return BEFORE UPDATE ON queue_entry WHEN OLD.place IS NULL BEGIN
  SELECT RAISE(ABORT, 'a queue_entry that has left the queue does not return');
END;
CREATE TRIGGER queue_entry_no_delete BEFORE DELETE ON queue_entry BEGIN
  SELECT RAISE(ABORT, 'queue_entry rows are not deleted');
END;
CREATE TRIGGER queue_attempt_no_update BEFORE UPDATE ON queue_attempt BEGIN
  SELECT RAISE(ABORT, 'queue_attempt rows are append-only');
END;
CREATE TRIGGER queue_attempt_no_delete BEFORE DELETE ON queue_attempt BEGIN
  SELECT RAISE(ABORT, 'queue_attempt rows are append-only');
END;
CREATE TRIGGER queue_act_no_update BEFORE UPDATE ON queue_act BEGIN
  SELECT RAISE(ABORT, 'queue_act rows are append-only');
END;
CREATE TRIGGER queue_act_no_delete BEFORE DELETE ON queue_act BEGIN
  SELECT RAISE(ABORT, 'queue_act rows are append-only');
END;
CREATE TRIGGER queue_state_no_delete BEFORE DELETE ON queue_state BEGIN
  SELECT RAISE(ABORT, 'queue_state is one row');
END;
