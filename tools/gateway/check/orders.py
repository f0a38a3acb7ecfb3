# SPDX-License-Identifier: Apache-2.0
"""Section 4 on a machine that stands: numbers, refusals, LIMITS, ZERO and STOP."""

from __future__ import annotations

from .bench import Bench, check, require
from .client import Failed, Skipped, seconds


@check("numbers", "4", "the number of a command is larger than every one before")
def numbers(bench: Bench) -> None:
    with bench.session() as client:
        for number, word in ((5, "OK"), (5, "ERR"), (4, "ERR"), (6, "OK"), (100000, "OK")):
            answer = client.command("STATUS", number)
            require(answer.word == word, f"#{number}: expected {word}, found {answer.text}")


@check("not_armed", "4", "no motion before LIMITS")
def not_armed(bench: Bench) -> None:
    if not bench.cap("motion"):
        raise Skipped("this gateway moves nothing")
    slow = bench.cap("speed_min_mm_s")
    with bench.session(bench.rate_hz()) as client:
        travel_mm = bench.present_travel_mm(client)
        # None of these would move the machine if it were accepted by mistake.
        client.refused(f"MOVE travel_mm={travel_mm:f} speed_mm_s={slow:f}", "not_armed")
        client.refused(f"MOVEF force_N=0 speed_mm_s={-slow:f} guard_mm={travel_mm:f}", "not_armed")
        force_codes = ("not_armed",) if bench.cap("force_hold") else ("not_armed", "unsupported")
        client.refused("RAMPF force_N=0 rate_N_s=0.001", *force_codes)
        client.refused("HOLD mode=force force_N=0", *force_codes)


@check("bad_values", "4", "a lacking field is syntax, a value that can never be right bad_value")
def bad_values(bench: Bench) -> None:
    with bench.session(bench.rate_hz()) as client:
        travel_mm = bench.present_travel_mm(client)
        client.accepted(bench.widest_limits())
        client.refused(f"MOVE travel_mm={travel_mm:f}", "syntax")
        client.refused("RATE", "syntax")
        client.refused("HOLD", "syntax")
        client.refused(f"MOVE travel_mm={travel_mm:f} speed_mm_s=0", "bad_value")
        client.refused(f"MOVE travel_mm={travel_mm:f} speed_mm_s=-1", "bad_value")
        client.refused(f"MOVEF force_N=0 speed_mm_s=0 guard_mm={travel_mm:f}", "bad_value")
        client.refused("RATE hz=-1", "bad_value")
        client.refused("HOLD mode=breath", "bad_value", "syntax")
        unsupported = () if bench.cap("force_hold") else ("unsupported",)
        client.refused("RAMPF force_N=0 rate_N_s=0", "bad_value", *unsupported)


@check("machine_limits", "4", "LIMITS and RATE beyond what CAPS say are refused")
def machine_limits(bench: Bench) -> None:
    with bench.session() as client:
        most_N, fast = bench.cap("force_max_N"), bench.cap("speed_max_mm_s")
        low, high = bench.cap("travel_min_mm"), bench.cap("travel_max_mm")
        for change in ({"force_max_N": 1.1 * most_N}, {"force_min_N": -1.1 * most_N},
                       {"travel_min_mm": low - 1}, {"travel_max_mm": high + 1},
                       {"speed_max_mm_s": 1.1 * fast}):
            client.refused(bench.widest_limits(**change), "machine_limits")
        client.refused(bench.widest_limits(force_min_N=most_N, force_max_N=-most_N), "bad_value",
                       "machine_limits")
        client.refused(f"RATE hz={2 * bench.cap('rate_max_hz'):f}", "machine_limits")
        client.accepted(bench.widest_limits())
        client.accepted(bench.widest_limits(force_max_N=most_N / 2))


@check("speed_limit", "4", "a speed beyond LIMITS is refused")
def speed_limit(bench: Bench) -> None:
    if not bench.cap("motion"):
        raise Skipped("this gateway moves nothing")
    slow, fast = bench.cap("speed_min_mm_s"), bench.cap("speed_max_mm_s")
    with bench.session(bench.rate_hz()) as client:
        travel_mm = bench.present_travel_mm(client)
        client.accepted(bench.widest_limits(speed_max_mm_s=(slow + fast) / 2))
        client.refused(f"MOVE travel_mm={travel_mm:f} speed_mm_s={fast:f}", "limits")
        client.refused(f"MOVE travel_mm={travel_mm:f} speed_mm_s={slow / 2:.9f}", "machine_limits")


@check("stops", "4", "STOPPED counts the STOPs; one answer may stand for several")
def stops(bench: Bench) -> None:
    with bench.session() as client:
        require(client.stop().line.fields.get("stops") == "1", "the first STOPPED must say stops=1")
        mark = client.mark()
        client.send_raw(b"STOP\nSTOP\nSTOP\n")
        client.expect("STOPPED stops=4", mark,
                      lambda r: r.word == "STOPPED" and r.line.fields.get("stops") == "4",
                      2.0 * bench.patience)
        came = [int(r.line.fields.get("stops", "0")) for r in client.since(mark, ["STOPPED"])]
        require(came == sorted(set(came)), f"answers out of order or twice: {came}")
        client.accepted("STATUS")


@check("stop_first", "4", "STOP is not queued: it is answered while commands wait")
def stop_first(bench: Bench) -> None:
    with bench.session() as client:
        mark = client.mark()
        numbers_sent = [client.number() for _ in range(20)]
        lines = [f"#{n} STATUS" for n in numbers_sent] + ["STOP"]
        sent_s = client.send_raw("\n".join(lines).encode() + b"\n")
        stopped = client.expect("STOPPED", mark, lambda r: r.word == "STOPPED", 1.5 * bench.patience)
        require(stopped.arrived_s - sent_s < 0.5 * bench.patience,
                f"STOPPED came after {stopped.arrived_s - sent_s:.2f} s on a machine that stands")
        client.expect("the answer to the last STATUS", mark, lambda r: r.answers(numbers_sent[-1]),
                      len(numbers_sent) * bench.patience)


@check("zero", "4", "ZERO makes the present force 0 and changes the origin")
def zero(bench: Bench) -> None:
    with bench.session(bench.rate_hz()) as client:
        for channel in ("force", "travel"):
            if not bench.cap(f"zero_{channel}"):
                client.refused(f"ZERO {channel}=1", "unsupported")
        if not bench.zero:
            raise Skipped("needs --zero: it changes the zero of force")
        if not bench.cap("zero_force"):
            raise Skipped("this machine cannot zero its force")
        bench.say("sets the zero of force (ZERO force=1)")
        answer = client.command("ZERO force=1 travel=0")
        require(answer.word == "OK", f"ZERO was refused: {answer.text}")
    if bench.revision >= 2:
        _check_origin(bench, answer.line.fields.get("origin"))


def _check_origin(bench: Bench, said: str | None) -> None:
    require(said is not None, "OK to ZERO carries no origin")
    require(said != bench.hello.get("origin"), f"the origin is still {said!r}")
    with bench.connect() as client:
        hello, _ = bench.open(client)
        now = hello.line.fields.get("origin")
        require(now == said, f"ZERO said origin={said!r}, HELLO says {now!r}")
        bench.hello = hello.line.fields


@check("quick", "4", "a command is answered within 1 s")
def quick(bench: Bench) -> None:
    with bench.session() as client:
        slowest_s = 0.0
        for _ in range(10):
            sent_s = client.send(f"#{(number := client.number())} STATUS")
            answer = client.answer("STATUS", number, 0)
            slowest_s = max(slowest_s, answer.arrived_s - sent_s)
            seconds(0.01)
        if slowest_s > 1.0 * bench.patience:
            raise Failed(f"it took {slowest_s:.2f} s")
