-- SPDX-License-Identifier: Apache-2.0
-- Open and short corrections that lcrig made, one row for each that the meter accepted
-- (docs/database.md). The hash chain does not cover them. It covers correction_json of a run, which
-- says what was known of the meter's corrections when the run began.

CREATE TABLE lcr_correction (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  kind TEXT NOT NULL CHECK (kind IN ('open', 'short')),
  meter TEXT NOT NULL CHECK (meter <> ''),  -- model and serial number
  lcr_identity TEXT NOT NULL,  -- the reply exactly as sent
  simulated INTEGER NOT NULL CHECK (simulated IN (0, 1)),
  operator TEXT NOT NULL,
  operator_uid INTEGER NOT NULL,
  made_unix_ns INTEGER NOT NULL
) STRICT;
CREATE INDEX lcr_correction_by_meter ON lcr_correction (meter, kind);

CREATE TRIGGER lcr_correction_no_update BEFORE UPDATE ON lcr_correction BEGIN
  SELECT RAISE(ABORT, 'lcr_correction rows are append-only');
END;
CREATE TRIGGER lcr_correction_no_delete BEFORE DELETE ON lcr_correction BEGIN
  SELECT RAISE(ABORT, 'lcr_correction rows are append-only');
END;

CREATE VIEW v_correction AS
SELECT
  id AS correction,
  kind,
  meter,
  strftime('%Y-%m-%dT%H:%M:%SZ', made_unix_ns / 1000000000, 'unixepoch') AS made_utc,
  operator,
  simulated
FROM lcr_correction;
