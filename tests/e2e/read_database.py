#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""read_database.py DATABASE EXPORT: compares the views of a database, read by Python's own sqlite3,
with the exported CSV files of run 1, row by row."""

import csv
import math
import sqlite3
import sys
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


def same(column, text, value):
    if value is None or text == "":
        return value in (None, "") and text == ""
    if isinstance(value, str):
        return text == value
    if column == "pressure_kPa":  # computed: the file has no digits that the force does not have
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
    levels = connection.execute("SELECT count(*) FROM v_level WHERE run = 1").fetchone()[0]
    run = connection.execute("SELECT * FROM v_run").fetchone()
    print(f"{compared} cells, {levels} levels, {run['protocol']}, {run['exit_status']}")


main(*sys.argv[1:])
