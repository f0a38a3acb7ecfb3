#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""python_page.py DATABASE EXPORT FOLDER: runs the blocks of docs/python.md in FOLDER on run 1 of a
database and on its export. Without pandas or matplotlib it runs the queries alone that stand in such
a block."""

import importlib.util
import os
import re
import shutil
import sqlite3
import subprocess
import sys
from pathlib import Path

LIBRARIES = ("pandas", "matplotlib")


def run_block(block, folder):
    environment = dict(os.environ, MPLBACKEND="Agg", MPLCONFIGDIR=str(folder))
    done = subprocess.run([sys.executable, "-"], input=block, cwd=folder, env=environment,
                          capture_output=True, text=True, timeout=120, check=False)
    if done.returncode != 0:
        sys.exit(f"{block}\n{done.stderr}")
    shown = re.search(r'savefig\("(.*)"\)', block)
    if not done.stdout and (shown and (folder / shown[1]).stat().st_size == 0 or "print(" in block):
        sys.exit(f"{block}\nshows nothing")


def run_queries(block, folder):
    database = re.search(r'sqlite3\.connect\("(.*)", uri=True\)', block)
    queries = re.findall(r'"(SELECT [^"]*)"', block)
    if not database or not queries:
        sys.exit(f"{block}\nhas no database or no query")
    os.chdir(folder)
    connection = sqlite3.connect(database[1], uri=True)
    for query in queries:
        if not connection.execute(query).fetchall():
            sys.exit(f"{query}\ngives nothing")


def main(database, export, folder):
    folder = Path(folder)
    folder.mkdir()
    page = Path("docs/python.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    shutil.copy(database, folder / "lcrig.db")
    shutil.copytree(export, folder / "run1")
    whole = 0
    for block in blocks:
        needed = [name for name in LIBRARIES if re.search(rf"^import {name}\b", block, re.MULTILINE)]
        if all(importlib.util.find_spec(name) for name in needed):
            run_block(block, folder)
            whole += 1
        else:
            run_queries(block, folder)
    print(f"{len(blocks)} blocks, {whole} of them whole")


if __name__ == "__main__":
    main(*sys.argv[1:])
