-- SPDX-License-Identifier: Apache-2.0
-- How many links the chain of a run had when the run ended, and the hash of the last one: what the
-- journal, the exported files and the report know, too (docs/database.md). Runs that ended under an
-- older schema have no such row. Notes that are added later make further links.

CREATE TABLE run_anchor (
  run_id INTEGER PRIMARY KEY REFERENCES run (id),
  links INTEGER NOT NULL CHECK (links >= 1),
  sha256 BLOB NOT NULL CHECK (length(sha256) = 32)
) STRICT;

CREATE TRIGGER run_anchor_no_update BEFORE UPDATE ON run_anchor BEGIN
  SELECT RAISE(ABORT, 'run_anchor rows are append-only');
END;
CREATE TRIGGER run_anchor_no_delete BEFORE DELETE ON run_anchor BEGIN
  SELECT RAISE(ABORT, 'run_anchor rows are append-only');
END;
