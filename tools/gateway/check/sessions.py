# SPDX-License-Identifier: Apache-2.0
"""Sections 2 and 3: HELLO, CAPS and observer sessions."""

from __future__ import annotations

from ..protocol import Line, Malformed, Missing
from .bench import (CAPS_FLAGS, CAPS_NUMBERS, FORCE_CLASSES, HELLO, LOOP_NUMBERS, NOT_NEGATIVE, OBSERVE,
                    STATED_NUMBERS, Bench, check, now_s, require, travels_mm)
from .client import Client, Failed, Skipped, seconds

_QUIET_S = 0.3  # time in which nothing may arrive


@check("hello", "2", "HELLO is answered by HELLO and CAPS, with all required fields")
def hello(bench: Bench) -> None:
    with bench.connect() as client:
        said, caps = bench.open(client)
    fields = said.line.fields
    require(said.arrived_s <= caps.arrived_s, "CAPS came before HELLO")
    require(fields.get("proto") == "1" and fields.get("side") == "gateway",
            f"expected proto=1 side=gateway: {said.text}")
    wanted = ["maker", "model", "serial", "version"] + ["origin"] * (bench.revision >= 2)
    lacking = [key for key in wanted if key not in fields]
    require(not lacking, f"HELLO lacks {', '.join(lacking)}")
    _check_caps(caps.line, bench)


def _check_caps(line: Line, bench: Bench) -> None:
    numbers = list(CAPS_NUMBERS)
    try:
        for key in CAPS_FLAGS:
            require(key in line.fields, f"CAPS lack {key}")
            line.flag(key)
        if line.flag("force_hold") and bench.revision >= 2:
            numbers += LOOP_NUMBERS
        if bench.revision >= 3:
            numbers += [key for flag, keys in STATED_NUMBERS.items() if line.flag(flag) for key in keys]
        if "force_class" in line.fields:
            numbers += ["force_class"]
        found = {key: line.real(key) for key in numbers}
    except (Missing, Malformed) as error:
        raise Failed(str(error)) from None
    for key in found:
        positive = key not in ("travel_min_mm", "travel_max_mm", *NOT_NEGATIVE)
        require(not positive or found[key] > 0, f"CAPS: {key} must be above 0")
        require(key not in NOT_NEGATIVE or found[key] >= 0, f"CAPS: {key} must not be below 0")
    stated = found.get("force_class", 1.0)
    require(stated in FORCE_CLASSES, f"CAPS: force_class={stated:g} is no class of ISO 7500-1")
    require(found["travel_min_mm"] < found["travel_max_mm"], "CAPS: travel_min_mm is not the least")
    require(found["speed_min_mm_s"] < found["speed_max_mm_s"], "CAPS: speed_min_mm_s is not the least")


@check("before", "2", "before HELLO no command is accepted, and STOP is answered")
def before_hello(bench: Bench) -> None:
    with bench.connect() as client:
        mark = client.mark()
        client.send("#1 STATUS")
        client.send("#2 RATE hz=10")
        seconds(_QUIET_S)
        came = client.since(mark, ["OK", "S", "HELLO"])
        require(not came, f"without a session came: {came[0].text if came else ''}")
        require(client.stop().line.fields.get("stops") == "1", "STOPPED did not count one STOP")


@check("again", "2", "HELLO in a session begins anew: numbers, rate, seq, stops and limits")
def hello_again(bench: Bench) -> None:
    hz = bench.rate_hz()
    with bench.session(hz) as client:
        bench.last_sample(client)
        travel_mm = bench.present_travel_mm(client)
        client.accepted(bench.widest_limits())
        client.stop()
        bench.open(client)
        seconds(0.05)
        mark = client.mark()
        seconds(_QUIET_S)
        require(not client.since(mark, ["S"]), "samples went on after HELLO: the rate was not 0")
        mark = client.mark()
        client.accepted(f"RATE hz={hz:g}")  # is #1 again
        first = bench.last_sample(client, mark)
        require(first.line.fields["seq"] == "1", f"seq did not begin at 1: {first.text[:60]}")
        require(client.stop().line.fields.get("stops") == "1", "stops were not counted anew")
        client.refused(_stay(bench, travel_mm), "not_armed")


def _stay(bench: Bench, travel_mm: float) -> str:
    """A motion to the present place, which does no harm if it is accepted by mistake."""
    return f"MOVE travel_mm={travel_mm:f} speed_mm_s={bench.cap('speed_min_mm_s')}"


@check("proto", "2", "another proto than 1 is answered by HELLO and nothing else")
def other_proto(bench: Bench) -> None:
    with bench.connect() as client:
        mark = client.mark()
        client.send("HELLO proto=2 side=host")
        client.expect("HELLO", mark, lambda r: r.word == "HELLO", 1.0 * bench.patience)
        seconds(_QUIET_S)
        require(not client.since(mark, ["CAPS"]), "CAPS came too")
        client.send("#1 STATUS")
        seconds(_QUIET_S)
        require(not client.since(mark, ["OK"]), "a command was accepted")


@check("observe", "3", "OBSERVE is answered by HELLO, CAPS and samples from seq 1; commands are refused")
def observe(bench: Bench) -> None:
    bench.need_revision_2()
    hz = bench.rate_hz()
    with bench.connect() as client:
        bench.open(client, f"{OBSERVE} hz={hz:g}")
        first = bench.last_sample(client)
        require(first.line.fields["seq"] == "1", f"seq did not begin at 1: {first.text[:60]}")
        for text in ("STATUS", "RATE hz=1", bench.widest_limits(), "HOLD mode=travel", "NONSENSE"):
            client.refused(text, "observer")
        bench.open(client, f"{OBSERVE} hz=0")
        seconds(0.1)
        mark = client.mark()
        seconds(_QUIET_S)
        require(not client.since(mark, ["S"]), "samples came with hz=0")


@check("observe_fast", "3", "a rate beyond rate_max_hz counts as rate_max_hz")
def observe_fast(bench: Bench) -> None:
    bench.need_revision_2()
    with bench.connect() as client:
        bench.open(client, f"{OBSERVE} hz={10 * bench.cap('rate_max_hz'):g}")
        bench.last_sample(client)
        mark, begin_s = client.mark(), now_s()
        seconds(0.5)
        lines = client.since(mark, ["S"])
        lasted_s = now_s() - begin_s
        hz = sum(int(r.line.fields["n"]) for r in lines) / lasted_s
        most = bench.cap("rate_max_hz")
        require(0.7 * most < hz < 1.3 * most, f"{hz:.0f} samples/s came, rate_max_hz is {most:g}")


@check("observe_silence", "3", "an observer that is silent for 1 s gets no more samples")
def observe_silence(bench: Bench) -> None:
    bench.need_revision_2()
    with bench.connect() as client:
        bench.open(client, f"{OBSERVE} hz={bench.rate_hz():g}")
        client.keep_alive = False
        silent_s = client.send("HB")
        seconds(1.0 + 0.3 * bench.patience)
        late = client.since(0, ["S"])[-1].arrived_s - silent_s
        require(late > 0.7, f"the samples ended {late:.2f} s after the last life sign, not 1 s")
        mark = client.mark()
        seconds(_QUIET_S)
        require(not client.since(mark, ["S"]), "samples still came after 1 s of silence")
        require(not client.closed_by_gateway, "the connection was closed")


@check("observe_stop", "3", "STOP is obeyed in an observer session")
def observe_stop(bench: Bench) -> None:
    bench.need_revision_2()
    with bench.connect() as client:
        bench.open(client, f"{OBSERVE} hz=0")
        require(client.stop().line.fields.get("stops") == "1", "STOPPED did not count one STOP")


@check("observe_back", "3", "HELLO ends an observer session, OBSERVE one that may command")
def observe_back(bench: Bench) -> None:
    bench.need_revision_2()
    with bench.connect() as client:
        bench.open(client, f"{OBSERVE} hz=0")
        bench.open(client, HELLO)
        client.accepted("STATUS")
        bench.open(client, f"{OBSERVE} hz=0")
        client.refused("STATUS", "observer")


@check("revision_1", "3", "a gateway of revision 1 does not answer OBSERVE with HELLO")
def revision_1(bench: Bench) -> None:
    if bench.revision >= 2:
        raise Skipped(f"the gateway has revision {bench.revision}")
    with bench.connect() as client:
        mark = client.mark()
        client.send(f"{OBSERVE} hz=50")
        seconds(_QUIET_S)
        came = client.since(mark, ["HELLO", "CAPS", "S"])
        require(not came, f"came: {came[0].text if came else ''}")


@check("observe_motion", "3", "an observer session changes nothing: begun, silent, closed, a motion goes on",
       moves=True)
def observe_motion(bench: Bench) -> None:
    bench.need_revision_2()
    if bench.panel is None:
        raise Skipped("needs --panel, the back door of a simulated machine")
    _return_to_start(bench)
    low, high = bench.travel_mm
    speed = min(bench.speed_mm_s, (high - low) / 10)
    bench.say(f"moves: the panel moves to {high:g} mm at {speed:g} mm/s")
    try:
        ask_panel(bench, f"MOVE travel_mm={high:f} speed_mm_s={speed:f}")
        for silent in (True, False):
            with bench.connect() as client:
                bench.open(client, f"{OBSERVE} hz={bench.rate_hz():g}")
                _require_motion(bench, client, speed)
                client.keep_alive = not silent
                seconds(1.3 if silent else 0.1)
        with bench.connect() as client:
            bench.open(client, f"{OBSERVE} hz={bench.rate_hz():g}")
            _require_motion(bench, client, speed)
    finally:
        ask_panel(bench, "STOP")


def _return_to_start(bench: Bench) -> None:
    with bench.session(bench.rate_hz()) as client:
        bench.arm(client)
        low = bench.travel_mm[0]
        bench.say(f"moves: back to {low:g} mm at {bench.speed_mm_s:g} mm/s")
        way_mm = abs(bench.present_travel_mm(client) - low)
        mark = client.mark()
        number = client.accepted(f"MOVE travel_mm={low:f} speed_mm_s={bench.speed_mm_s:f}")
        client.done(number, mark, way_mm / bench.speed_mm_s + 2 * bench.patience)


def _require_motion(bench: Bench, client: Client, speed_mm_s: float) -> None:
    mark = client.mark()
    first = travels_mm(bench.last_sample(client, mark))[0]
    seconds(0.3)
    last = [t for r in client.since(mark, ["S"]) for t in travels_mm(r)][-1]
    require(last - first > 0.1 * speed_mm_s, "the motion had ended")


def ask_panel(bench: Bench, text: str) -> None:
    import socket
    assert bench.panel is not None
    with socket.create_connection(bench.panel, timeout=2) as panel:
        panel.sendall(text.encode() + b"\n")
        answer = panel.makefile().readline()
    require(answer.startswith("OK"), f"the panel refused {text}: {answer}")
