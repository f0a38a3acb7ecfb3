# SPDX-License-Identifier: Apache-2.0
"""When a command is refused, and what the device must watch (docs/frame-link.md, section 4).

Pure functions of the situation. If several reasons apply, the order is: bad_value, unsupported,
not_armed, busy, not_ready, machine_limits, limits, overload, no_contact.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from .backend import Capabilities, Refused, State, Window


@dataclass(frozen=True)
class Situation:
    capabilities: Capabilities
    limits: Window | None  # None: not armed
    state: State
    busy: str  # the motion under way, in words for people; empty: none


def require(condition: bool, code: str, text: str) -> None:
    if not condition:
        raise Refused(code, text)


def check_limits(wanted: Window, s: Situation) -> None:
    require(wanted.force_min_N < wanted.force_max_N, "bad_value",
            "force_min_N must be less than force_max_N")
    require(wanted.travel_min_mm < wanted.travel_max_mm, "bad_value",
            "travel_min_mm must be less than travel_max_mm")
    require(wanted.speed_max_mm_s > 0, "bad_value", "speed_max_mm_s must be above 0")
    require(not s.busy, "busy", f"limits cannot be replaced: {s.busy}")
    can = s.capabilities
    require(-can.force_max_N <= wanted.force_min_N and wanted.force_max_N <= can.force_max_N,
            "machine_limits", f"the load cell is valid in +-{can.force_max_N:g} N")
    require(can.travel_min_mm <= wanted.travel_min_mm and wanted.travel_max_mm <= can.travel_max_mm,
            "machine_limits", "travel of this machine, as shown at present: "
            f"{can.travel_min_mm:g} to {can.travel_max_mm:g} mm")
    require(can.speed_min_mm_s <= wanted.speed_max_mm_s <= can.speed_max_mm_s, "machine_limits",
            f"speed of this machine: {can.speed_min_mm_s:g} to {can.speed_max_mm_s:g} mm/s")


def check_ready(s: Situation) -> Window:
    """What every motion needs, including force control. Returns the limits."""
    require(s.capabilities.motion, "unsupported", "this gateway moves nothing")
    if s.limits is None:
        raise Refused("not_armed", "send LIMITS first")
    require(not s.busy, "busy", s.busy)
    require(not s.state.not_ready, "not_ready", s.state.not_ready)
    require(s.state.travel_mm is not None, "not_ready", "the travel is not known")
    require(s.state.force_N is not None or s.state.overload, "not_ready", "the force is not known")
    return s.limits


def check_speed(speed_mm_s: float, s: Situation, limits: Window) -> None:
    slowest = s.capabilities.speed_min_mm_s
    require(speed_mm_s >= slowest, "machine_limits", f"slower than speed_min_mm_s={slowest:g}")
    require(speed_mm_s <= limits.speed_max_mm_s, "limits",
            f"faster than speed_max_mm_s={limits.speed_max_mm_s:g} of LIMITS")


def check_travel(name: str, travel_mm: float, s: Situation, limits: Window) -> None:
    """Checks a target. The limits were inside the machine's own when they were accepted, but a ZERO
    may have moved them since. The machine's own limits never move."""
    require(limits.travel_min_mm <= travel_mm <= limits.travel_max_mm, "limits",
            f"{name}={travel_mm:g} is outside LIMITS, {limits.travel_min_mm:g} to "
            f"{limits.travel_max_mm:g} mm")
    can = s.capabilities
    require(can.travel_min_mm <= travel_mm <= can.travel_max_mm, "machine_limits",
            f"{name}={travel_mm:g} is outside the machine's own travel, {can.travel_min_mm:g} to "
            f"{can.travel_max_mm:g} mm as shown at present")


def check_force(force_N: float, limits: Window) -> None:
    require(limits.force_min_N <= force_N <= limits.force_max_N, "limits",
            f"force_N={force_N:g} is outside LIMITS, {limits.force_min_N:g} to "
            f"{limits.force_max_N:g} N")


def window(direction: int, s: Situation, limits: Window) -> Window:
    """What the device watches during a motion in this direction (+1: towards the specimen). These
    are the limits, widened where the motion is the way back from beyond one of them."""
    return _travel_window(direction, s, _force_window(direction, s, limits))


def _force_window(direction: int, s: Situation, limits: Window) -> Window:
    state = s.state
    if state.overload:
        require(direction < 0, "overload", "the load cell is beyond its range: only less travel is allowed")
        return replace(limits, force_max_N=float("inf"))
    force_N = state.force_N
    assert force_N is not None  # check_ready has made sure of this
    # Both the present force and the force watched later are noisy.
    noise_N = 2 * state.force_noise_N
    if force_N > limits.force_max_N:
        require(direction < 0, "limits", f"the force, {force_N:g} N, is beyond force_max_N: "
                "only less travel is allowed")
        return replace(limits, force_max_N=force_N + noise_N)
    if force_N < limits.force_min_N:
        require(direction > 0, "limits", f"the force, {force_N:g} N, is beyond force_min_N: "
                "only more travel is allowed")
        return replace(limits, force_min_N=force_N - noise_N)
    return limits


def _travel_window(direction: int, s: Situation, limits: Window) -> Window:
    travel_mm = s.state.travel_mm
    assert travel_mm is not None
    if travel_mm > limits.travel_max_mm:
        require(direction < 0, "limits", f"travel_mm={travel_mm:g} is beyond travel_max_mm: "
                "only less travel is allowed")
        return replace(limits, travel_max_mm=travel_mm)
    if travel_mm < limits.travel_min_mm:
        require(direction > 0, "limits", f"travel_mm={travel_mm:g} is beyond travel_min_mm: "
                "only more travel is allowed")
        return replace(limits, travel_min_mm=travel_mm)
    return limits
