# SPDX-License-Identifier: Apache-2.0
"""Sections 5 and 6 on a machine that stands: samples, heartbeats and silence."""

from __future__ import annotations

from itertools import pairwise

from .bench import Bench, check, now_s, require, values
from .client import Received, seconds


@check("samples", "5", "samples come in order, at their rate, at most 100 ms in a line")
def samples(bench: Bench) -> None:
    hz = bench.rate_hz()
    with bench.session(hz) as client:
        bench.last_sample(client)
        mark, begin_s = client.mark(), now_s()
        seconds(1.2)
        lines = client.since(mark, ["S"])
        lasted_s = now_s() - begin_s
    count = sum(int(r.line.fields["n"]) for r in lines)
    require(abs(count / lasted_s / hz - 1) < 0.1 + 0.02 * bench.patience,
            f"{count} samples in {lasted_s:.2f} s, asked for {hz:g}/s")
    for line in lines:
        length = int(line.line.fields["n"])
        require(length == 1 or (length - 1) / hz <= 0.1001, f"more than 100 ms in a line: {line.text[:60]}")
    for before, after in pairwise(lines):
        next_seq = int(before.line.fields["seq"]) + int(before.line.fields["n"])
        require(int(after.line.fields["seq"]) >= next_seq,
                f"seq runs back: {before.text[:40]} then {after.text[:40]}")
    for key, has in (("force_N", bench.cap("force")), ("travel_mm", bench.cap("travel"))):
        seen = any(key in r.line.fields for r in lines)
        require(seen == bool(has), f"CAPS and samples disagree on {key}")
    _check_clock(bench, lines)


def _check_clock(bench: Bench, lines: list[Received]) -> None:
    stamped = [(r.arrived_s, t) for r in lines for t in values(r, "t_s")[-1:] if t is not None]
    if len(stamped) < 3:
        return
    times = [t for r in lines for t in values(r, "t_s") if t is not None]
    require(all(a < b for a, b in pairwise(times)), "t_s does not grow")
    ages = [arrived - t for arrived, t in stamped]
    late_s = max(ages) - min(ages)
    require(late_s <= 0.2 * bench.patience, f"samples came {late_s:.2f} s later than the quickest")
    rate = (stamped[-1][1] - stamped[0][1]) / (stamped[-1][0] - stamped[0][0])
    require(abs(rate - 1) < 0.1 + 0.02 * bench.patience, f"t_s runs at {rate:.2f} s per second")


@check("life_signs", "6", "a gateway that has nothing to say sends HB after 250 ms, and HB keeps the session")
def life_signs(bench: Bench) -> None:
    with bench.session() as client:
        mark, begin_s = client.mark(), now_s()
        seconds(1.3)
        times = [begin_s] + [r.arrived_s for r in client.since(mark)] + [now_s()]
        gap_s = max(b - a for a, b in pairwise(times))
        require(gap_s < 0.25 + 0.1 * bench.patience, f"nothing came for {gap_s:.2f} s")
        require(not [r for r in client.since(mark, ["EVENT"]) if r.line.fields.get("kind") == "watchdog"],
                "the gateway says that the daemon was silent, and it was not")


@check("silence", "6", "1 s of silence of the daemon: EVENT kind=watchdog, and limits are forgotten")
def silence(bench: Bench) -> None:
    with bench.session(bench.rate_hz()) as client:
        travel_mm = bench.present_travel_mm(client)
        client.accepted(bench.widest_limits())
        client.keep_alive = False
        silent_s = client.send("HB")
        mark = client.mark()
        event = client.expect("EVENT kind=watchdog", mark,
                              lambda r: r.word == "EVENT" and r.line.fields.get("kind") == "watchdog",
                              1.0 + 0.5 * bench.patience)
        waited_s = event.arrived_s - silent_s
        require(waited_s > 0.9, f"it came after {waited_s:.2f} s already")
        client.keep_alive = True
        if bench.cap("motion"):
            client.refused(f"MOVE travel_mm={travel_mm:f} speed_mm_s={bench.cap('speed_min_mm_s')}",
                           "not_armed")


@check("silence_malformed", "6", "lines that count as not received are no life sign")
def silence_malformed(bench: Bench) -> None:
    with bench.session() as client:
        client.keep_alive = False
        mark, begin_s = client.mark(), now_s()
        while now_s() - begin_s < 1.0 + 0.5 * bench.patience:
            client.send("HB x=1 x=2")
            seconds(0.1)
            if any(r.line.fields.get("kind") == "watchdog" for r in client.since(mark, ["EVENT"])):
                return
        require(False, "EVENT kind=watchdog did not come")
