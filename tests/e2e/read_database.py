#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""read_database.py DATABASE EXPORT: compares the views of a database, read by Python's own sqlite3,
with the export of run 1, cell by cell: v_reading, v_sample and v_level with its CSV files, v_run with
its datapackage.json."""

import csv
import json
import math
import sqlite3
import sys
from datetime import datetime, timezone
from decimal import Decimal
from pathlib import Path

# CSV file, view, columns (the same names in both)
PAIRS = [
    ("lcr.csv", "v_reading",
     ["seq", "t_s", "t_asked_s", "step", "repeat", "level", "reading", "flags", "function",
      "capacitance_pF", "dissipation", "status"]),
    ("frame.csv", "v_sample",
     ["seq", "t_received_s", "device_time_s", "force_N", "travel_mm", "pressure_kPa", "flags"]),
]
# levels.csv has a line for each reading of a level. Its columns, and those of v_level
LEVEL = {"step": "step", "repeat": "repeat", "level_in_run": "level",
         "level_in_repeat": "index_in_repeat", "target_force_N": "target_force_N",
         "target_pressure_kPa": "target_pressure_kPa"}
# The file has only those digits of these columns that are significant.
COMPUTED = {"pressure_kPa", "target_force_N", "target_pressure_kPa"}


def same(column, text, value):
    if value is None or text == "":
        return value in (None, "") and text == ""
    if isinstance(value, str):
        return text == value
    if column in COMPUTED:
        shown = Decimal(text)
        return abs(shown - Decimal(value)) <= Decimal(6).scaleb(shown.as_tuple().exponent - 1)
    return math.isclose(float(text), value, rel_tol=1e-12, abs_tol=1e-12)


def main(database, export):
    connection = sqlite3.connect(f"file:{database}?mode=ro", uri=True)
    connection.row_factory = sqlite3.Row
    compared = 0
    for name, view, columns in PAIRS:
        rows = connection.execute(f"SELECT * FROM {view} WHERE run = 1 ORDER BY seq").fetchall()
        with open(Path(export) / name, encoding="utf-8", newline="") as file:
            lines = list(csv.DictReader(file))
        if len(rows) != len(lines) or not rows:
            sys.exit(f"{view}: {len(rows)} rows, {name}: {len(lines)}")
        for row, line in zip(rows, lines):
            for column in columns:
                if not same(column, line[column], row[column]):
                    sys.exit(f"{name}, row {line['seq']}, {column}: {line[column]!r}, "
                             f"{view}: {row[column]!r}")
                compared += 1
    levels, cells = compare_levels(connection, Path(export))
    run = compare_run(connection, Path(export))
    print(f"{compared + cells + len(run)} cells, {levels} levels, {run['protocol']}, "
          f"{run['exit_status']}")


def compare_levels(connection, export):
    rows = connection.execute("SELECT * FROM v_level WHERE run = 1 ORDER BY level").fetchall()
    with open(export / "levels.csv", encoding="utf-8", newline="") as file:
        lines = list(csv.DictReader(file))
    if {line["level_in_run"] for line in lines} != {str(row["level"]) for row in rows}:
        sys.exit("levels.csv has other levels than v_level")
    cells = 0
    for row in rows:
        of_level = [line for line in lines if line["level_in_run"] == str(row["level"])]
        if len(of_level) != row["planned_readings"] or row["abandoned"]:
            sys.exit(f"level {row['level']}: {len(of_level)} lines, v_level: {dict(row)}")
        for line in of_level:
            for column, name in LEVEL.items():
                if not same(column, line[column], row[name]):
                    sys.exit(f"levels.csv, reading {line['reading']} of level {row['level']}, "
                             f"{column}: {line[column]!r}, v_level: {row[name]!r}")
                cells += 1
        begin, first = row["begin_s"], float(of_level[0]["t_s"])
        if not begin <= first:
            sys.exit(f"level {row['level']} begins at {begin} s, its first reading is at {first} s")
    return len(rows), cells


def seconds(text):
    """Of an ISO 8601 time, which is UTC where it does not say more."""
    time = datetime.fromisoformat(text.replace("Z", "+00:00"))
    return (time if time.tzinfo else time.replace(tzinfo=timezone.utc)).timestamp()


def compare_run(connection, export):
    """The row of v_run, of which every column was compared."""
    run = dict(connection.execute("SELECT * FROM v_run WHERE run = 1").fetchone())
    package = json.loads((export / "datapackage.json").read_text(encoding="utf-8"))["lcrig"]
    exported = {name: package[name] for name in
                ("operator", "simulated", "exit_status", "reason", "lcr_identity", "frame_identity",
                 "bench", "software_version", "note", "uuid", "recorded_run")}
    exported |= {name: package["identity"][name] for name in ("run", "protocol", "specimen")}
    exported["probe_diameter_mm"] = package["probe_diameter_m"] * 1e3
    exported["parameters_json"] = package["parameters"]
    exported["started_utc"] = package["started"]
    exported["made_utc"] = package["made"]
    for name in ("cell_serial", "probe_serial", "probe_name"):
        exported[name] = package["frame_capabilities"].get(name)
    exported["duration_s"] = seconds(package["ended"]) - seconds(package["started"])
    if run.keys() != exported.keys():
        sys.exit(f"v_run has other columns than this test knows: {run.keys() ^ exported.keys()}")
    for name, value in run.items():
        other = exported[name]
        if name == "parameters_json":
            equal = json.loads(value) == other
        elif name in ("started_utc", "made_utc"):  # whole seconds
            equal = 0 <= seconds(other) - seconds(value) < 1
        elif name == "duration_s":  # difference of times in milliseconds
            equal = abs(value - other) < 2e-3
        elif isinstance(value, float):
            equal = math.isclose(value, other, rel_tol=1e-12)
        else:
            equal = value == other
        if not equal:
            sys.exit(f"datapackage.json, {name}: {other!r}, v_run: {value!r}")
    return run


main(*sys.argv[1:])
