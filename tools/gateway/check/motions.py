# SPDX-License-Identifier: Apache-2.0
"""Sections 4, 6 and 7 on a machine that moves, but only within what the user allows."""

from __future__ import annotations

from .bench import Bench, check, flags, now_s, require, travels_mm, values
from .client import Client, Received, Skipped, seconds

_NEAR_MM = 0.05  # within which any machine must stand


def _go(bench: Bench, client: Client, text: str) -> tuple[int, int]:
    """Prints what will move, and moves it. Returns number and mark."""
    bench.say(f"moves: {text}")
    mark = client.mark()
    return client.accepted(text), mark


def _patience_s(bench: Bench) -> float:
    low, high = bench.travel_mm
    return (high - low) / bench.speed_mm_s + 3 * bench.patience


def _begin(bench: Bench) -> Client:
    """A session with limits and samples, and the machine at the lower end of the allowed range."""
    client = bench.session(bench.rate_hz())
    try:
        bench.arm(client)
        if abs(bench.present_travel_mm(client) - bench.travel_mm[0]) > _NEAR_MM:
            _back(bench, client)
        return client
    except BaseException:
        client.close()
        raise


def _back(bench: Bench, client: Client) -> None:
    number, mark = _go(bench, client,
                       f"MOVE travel_mm={bench.travel_mm[0]:f} speed_mm_s={bench.speed_mm_s:f}")
    done = client.done(number, mark, _patience_s(bench))
    require(done.line.fields.get("reason") == "target", f"the way back ended with {done.text}")


def _middle_mm(bench: Bench) -> float:
    """A travel that is reached in about half a second."""
    low, high = bench.travel_mm
    return min(high, low + 0.5 * bench.speed_mm_s)


def _require_standing(bench: Bench, client: Client) -> float:
    mark = client.mark()
    first = bench.present_travel_mm(client)
    seconds(0.2)
    lines = client.since(mark, ["S"])
    require(not any("M" in word for word in flags(lines[-1])), "flags still say M")
    last = bench.present_travel_mm(client)
    require(abs(last - first) < _NEAR_MM, f"it still moved, from {first:g} to {last:g} mm")
    return last


@check("move", "4", "MOVE ends with target, standing there, after its last sample", moves=True)
def move(bench: Bench) -> None:
    with _begin(bench) as client:
        goal = _middle_mm(bench)
        number, mark = _go(bench, client, f"MOVE travel_mm={goal:f} speed_mm_s={bench.speed_mm_s:f}")
        done = client.done(number, mark, _patience_s(bench))
        require(done.line.fields.get("reason") == "target", f"expected reason=target: {done.text}")
        require(abs(done.line.real("travel_mm") - goal) < _NEAR_MM, f"it stands elsewhere: {done.text}")
        lines = client.since(mark, ["S"])
        require(any("M" in word for r in lines for word in flags(r)), "no sample of the motion has M")
        before = [r for r in lines if r.arrived_s <= done.arrived_s]
        travels = [t for r in before for t in travels_mm(r)]
        slack_mm = _NEAR_MM + 2 * bench.speed_mm_s / bench.rate_hz()
        require(bool(travels) and abs(travels[-1] - goal) < slack_mm,
                "the last sample before DONE is not of the end of the motion")
        _require_standing(bench, client)


@check("target_limits", "4", "a target outside LIMITS is refused", moves=True)
def target_limits(bench: Bench) -> None:
    with _begin(bench) as client:
        low, high = bench.travel_mm
        speed = bench.speed_mm_s
        client.refused(f"MOVE travel_mm={high + 0.1:f} speed_mm_s={speed:f}", "limits")
        client.refused(f"MOVE travel_mm={low - 0.1:f} speed_mm_s={speed:f}", "limits")
        client.refused(f"MOVEF force_N={2 * bench.force_max_N:f} speed_mm_s={speed:f} guard_mm={high:f}",
                       "limits")
        client.refused(f"MOVEF force_N=0 speed_mm_s={-speed:f} guard_mm={low - 0.1:f}", "limits")


@check("busy", "4", "a second motion, LIMITS and ZERO are refused while it moves; RATE is not", moves=True)
def busy(bench: Bench) -> None:
    low, high = bench.travel_mm
    with _begin(bench) as client:
        number, mark = _go(bench, client, _slow_move(bench))
        client.refused(f"MOVE travel_mm={low:f} speed_mm_s={bench.speed_mm_s:f}", "busy")
        client.refused(f"LIMITS force_min_N={-bench.force_max_N:f} force_max_N={bench.force_max_N:f} "
                       f"travel_min_mm={low:f} travel_max_mm={high:f} "
                       f"speed_max_mm_s={bench.fastest_mm_s():f}", "busy")
        if bench.cap("zero_force"):
            client.refused("ZERO force=1", "busy")
        client.accepted(f"RATE hz={bench.rate_hz():g}")
        require(not client.since(mark, ["DONE"]), "the motion ended meanwhile")
        client.accepted("HOLD mode=travel")
        done = client.done(number, mark, 3 * bench.patience)
        require(done.line.fields.get("reason") == "stop", f"after HOLD mode=travel: {done.text}")


def _slow_speed_mm_s(bench: Bench) -> float:
    """A speed at which the whole way takes at least 4 s."""
    low, high = bench.travel_mm
    return max(min(bench.speed_mm_s, (high - low) / 4), bench.cap("speed_min_mm_s"))


def _slow_move(bench: Bench) -> str:
    return f"MOVE travel_mm={bench.travel_mm[1]:f} speed_mm_s={_slow_speed_mm_s(bench):f}"


@check("stop", "4", "STOP ends a motion: DONE, then STOPPED, within its time; limits stay", moves=True)
def stop(bench: Bench) -> None:
    with _begin(bench) as client:
        number, mark = _go(bench, client, _slow_move(bench))
        seconds(0.4)
        before = bench.last_sample(client, client.mark())
        sent_s = client.send("STOP")
        stopped = client.expect("STOPPED", mark, lambda r: r.word == "STOPPED", 2.0 * bench.patience)
        done = client.done(number, mark, 0.1 * bench.patience)
        require(done.line.fields.get("reason") == "stop", f"expected reason=stop: {done.text}")
        order = [r.word for r in client.since(mark, ["DONE", "STOPPED"])]
        require(order == ["DONE", "STOPPED"], f"expected DONE, then STOPPED, found {order}")
        _check_way(bench, before, sent_s, stopped)
        _require_standing(bench, client)
        _back(bench, client)  # the limits have not changed


def _check_way(bench: Bench, before: Received, sent_s: float, stopped: Received) -> None:
    """Checks the stopping distance from the place at STOP: 20 ms, then the deceleration, and the
    age of the sample."""
    at = travels_mm(before)[-1]
    end = stopped.line.real("travel_mm")
    v = _slow_speed_mm_s(bench)
    age_s = sent_s - before.arrived_s + 0.1 + 1 / bench.rate_hz()
    slack_s = 0.02 + age_s + 0.03 * bench.patience
    most_mm = v * slack_s + v * v / (2 * bench.cap("deceleration_mm_s2"))
    require(abs(end - at) <= most_mm,
            f"it went on for {abs(end - at):.3f} mm, expected at most {most_mm:.3f} mm")


@check("guard", "4", "MOVEF stands at guard_mm at the latest", moves=True)
def guard(bench: Bench) -> None:
    with _begin(bench) as client:
        goal = _middle_mm(bench)
        number, mark = _go(bench, client, f"MOVEF force_N={bench.force_max_N:f} "
                           f"speed_mm_s={bench.speed_mm_s:f} guard_mm={goal:f}")
        done = client.done(number, mark, _patience_s(bench))
        if done.line.fields.get("reason") == "target":
            raise Skipped("the force was reached before the guard; give a lower --travel-mm")
        require(done.line.fields.get("reason") == "travel_limit", f"expected travel_limit: {done.text}")
        require(done.line.real("travel_mm") <= goal + 0.001, f"it stands beyond {goal:g} mm: {done.text}")


@check("movef", "4", "MOVEF stops at the force; the way back is open, further on is closed", moves=True)
def movef(bench: Bench) -> None:
    wanted_N = bench.force_max_N / 2
    high = bench.travel_mm[1]
    with _begin(bench) as client:
        number, mark = _go(bench, client, f"MOVEF force_N={wanted_N:f} speed_mm_s={bench.speed_mm_s:f} "
                           f"guard_mm={high:f}")
        done = client.done(number, mark, _patience_s(bench))
        if done.line.fields.get("reason") == "travel_limit":
            raise Skipped(f"no specimen: {wanted_N:g} N were not reached")
        require(done.line.fields.get("reason") == "target", f"expected target: {done.text}")
        reached_N = done.line.real("force_N")
        require(reached_N > 0.8 * wanted_N, f"it stands at {reached_N:g} N, not at {wanted_N:g} N")
        bench.arm(client, force_max_N=reached_N / 2)
        _check_forward_is_closed(bench, client)
        _back(bench, client)
        bench.arm(client)


def _check_forward_is_closed(bench: Bench, client: Client) -> None:
    text = f"MOVE travel_mm={bench.travel_mm[1]:f} speed_mm_s={bench.speed_mm_s:f}"
    bench.say(f"moves, unless it is refused as it should be: {text}")
    mark = client.mark()
    answer = client.command(text)
    if answer.word == "ERR":
        return
    assert answer.line.command is not None
    done = client.done(answer.line.command, mark, _patience_s(bench))
    require(done.line.fields.get("reason") == "force_limit",
            f"force beyond its limit, and it moved on: {done.text}")


@check("force_limit", "4", "a force limit ends a motion with force_limit", moves=True)
def force_limit(bench: Bench) -> None:
    with _begin(bench) as client:
        bench.arm(client, force_max_N=bench.force_max_N / 2)
        number, mark = _go(bench, client,
                           f"MOVE travel_mm={bench.travel_mm[1]:f} speed_mm_s={bench.speed_mm_s:f}")
        done = client.done(number, mark, _patience_s(bench))
        if done.line.fields.get("reason") == "target":
            raise Skipped("no specimen: the force limit was not reached")
        require(done.line.fields.get("reason") == "force_limit", f"expected force_limit: {done.text}")
        _back(bench, client)


@check("rampf", "4", "RAMPF reaches its force and holds it; LIMITS and HOLD mode=travel while it holds",
       moves=True)
def rampf(bench: Bench) -> None:
    if not bench.cap("force_hold"):
        raise Skipped("this machine has no force loop")
    bench.need_revision_2()
    wanted_N = bench.force_max_N / 2
    rate = min(bench.cap("force_rate_max_N_s"), wanted_N)
    with _begin(bench) as client:
        number, mark = _go(bench, client, f"RAMPF force_N={wanted_N:f} rate_N_s={rate:f}")
        way_s = (bench.travel_mm[1] - bench.travel_mm[0]) / bench.cap("force_approach_mm_s")
        done = client.done(number, mark, 4 * way_s + wanted_N / rate + 5 * bench.patience)
        if done.line.fields.get("reason") == "travel_limit":
            raise Skipped(f"no specimen: {wanted_N:g} N were not reached")
        require(done.line.fields.get("reason") == "target", f"expected target: {done.text}")
        bench.arm(client)
        _check_hold(bench, client, wanted_N)
        client.accepted("HOLD mode=travel")
        seconds(0.2)
        _require_standing(bench, client)
        require("F" not in flags(client.since(0, ["S"])[-1])[-1], "flags still say F")
        _back(bench, client)


def _check_hold(bench: Bench, client: Client, wanted_N: float) -> None:
    mark = client.mark()
    seconds(0.4)
    lines = client.since(mark, ["S"])
    require(bool(lines), "no samples came while the force was held")
    require(all("F" in word for r in lines for word in flags(r)), "a sample of the hold lacks the flag F")
    forces = [f for r in lines for f in values(r, "force_N") if f is not None]
    most_N = bench.cap("force_ripple_N")
    worst_N = max(abs(f - wanted_N) for f in forces)
    require(worst_N <= most_N, f"the held force strays by {worst_N:g} N, CAPS say {most_N:g} N")


@check("silence_stops", "6", "1 s of silence stops a motion: DONE reason=fault; then not_armed", moves=True)
def silence_stops(bench: Bench) -> None:
    with _begin(bench) as client:
        number, mark = _go(bench, client, _slow_move(bench))
        client.keep_alive = False
        silent_s = now_s()
        done = client.done(number, mark, 1.5 + 1.0 * bench.patience)
        require(done.line.fields.get("reason") == "fault", f"expected reason=fault: {done.text}")
        require(done.arrived_s - silent_s < 1.3 + 0.5 * bench.patience, "it came too late")
        client.keep_alive = True
        client.refused(_slow_move(bench), "not_armed")


@check("hello_stops", "2", "HELLO in the middle of a motion stops it", moves=True)
def hello_stops(bench: Bench) -> None:
    with _begin(bench) as client:
        _go(bench, client, _slow_move(bench))
        seconds(0.2)
        bench.open(client)
        client.accepted(f"RATE hz={bench.rate_hz():g}")
        seconds(0.2 + bench.speed_mm_s / bench.cap("deceleration_mm_s2"))
        _require_standing(bench, client)


@check("close_stops", "6", "the end of the connection stops a motion; so does OBSERVE", moves=True)
def close_stops(bench: Bench) -> None:
    bench.need_revision_2()
    observe = f"OBSERVE proto=1 revision=3 side=host hz={bench.rate_hz():g}"
    for closes in (True, False):
        client = _begin(bench)
        with client:
            _go(bench, client, _slow_move(bench))
            seconds(0.2)
            if not closes:
                bench.open(client, observe)
                seconds(0.1 + bench.speed_mm_s / bench.cap("deceleration_mm_s2"))
                _require_standing(bench, client)
        if closes:
            with bench.connect() as other:
                bench.open(other, observe)
                seconds(0.1 + bench.speed_mm_s / bench.cap("deceleration_mm_s2"))
                _require_standing(bench, other)
