#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The table of docs/model.md, "Judged", from the rows of model_study, also of a run that was stopped.

    python3 tests/model_study/table.py ROWS.csv...
"""
import collections
import sys

LEAST_JUDGED = 1e-7  # estimates and errors below it count as met


def rows(paths):
    for path in paths:
        with open(path, encoding="utf-8") as file:
            for line in file:
                cells = line.strip().split(",")
                if len(cells) == 10 and cells[0].isdigit():
                    yield cells


def negligible(level):
    return float(level.split()[1]) / 10 if level.startswith("auto") else LEAST_JUDGED


def print_level(name, answers, level):
    ratios, met, without = [], 0, 0
    for cells in answers:
        estimate, error, doubt = (float(cell) for cell in cells[4:7])
        if max(estimate, error, doubt) <= negligible(level):
            met += 1
        elif cells[9] == "1":
            ratios.append(estimate / error)
        else:
            without += 1
    if not ratios:
        print(f"| {name} | 0 | {met} | {without} | | | | | |")
        return
    ratios.sort()
    count = len(ratios)
    half, below, good = (sum(low <= r <= high for r in ratios)
                         for low, high in ((0, 0.5), (0, 1 - 1e-12), (1, 10)))
    print(f"| {name} | {count} | {met} | {without} | {half} | {below} ({100 * below / count:.2g} %) | "
          f"{100 * good / count:.1f} % | {ratios[count // 2]:.1f} | "
          f"{ratios[0]:.2f}, {ratios[-1]:.3g} |")


def main():
    by_level, stacks, refused = collections.defaultdict(list), set(), collections.defaultdict(list)
    for cells in rows(sys.argv[1:]):
        stacks.add(cells[0])
        if cells[2].endswith("refused"):
            refused[cells[2]].append(cells)
        else:
            mesh = f", mesh {cells[3]}" if cells[2].startswith("fem") else ""
            by_level[(cells[2], mesh)].append(cells)
    print(f"{len(stacks)} stacks\n")
    print("| level | answers judged | met | without a truth | below 0.5 | below 1 | 1 to 10 | median |"
          " least, most |\n| --- | --- | --- | --- | --- | --- | --- | --- | --- |")
    for (level, mesh), answers in sorted(by_level.items()):
        print_level(level + mesh, answers, level)
    for level, answers in sorted(refused.items()):
        judged = [cells for cells in answers if float(cells[6]) <= float(cells[5]) / 10]
        could = sum(float(cells[5]) <= float(cells[4]) for cells in judged)
        print(f"\n{level} {len(answers)} times, {len(judged)} of them judged; a judged level was good"
              f" enough in {could}")


main()
