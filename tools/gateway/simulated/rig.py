# SPDX-License-Identifier: Apache-2.0
"""The parameters of the simulated machine: its true properties and what it declares.

Each key has its unit in its name. Unknown keys are refused.
"""

from __future__ import annotations

import difflib
import json
import math
from dataclasses import MISSING, Field, dataclass, field, fields, replace
from typing import Any, Iterator, Mapping

STEP_S = 0.0002  # step of the physics


class BadRig(Exception):
    """What is wrong with a rig file or a --set, for the user."""


def _p(default: Any, meaning: str, low: float = -math.inf, high: float = math.inf) -> Any:
    return field(default=default, metadata={"meaning": meaning, "low": low, "high": high})


def _declared(meaning: str) -> Any:
    return _p(None, f"declared in CAPS: {meaning}; null: what is true, with a margin")


@dataclass(frozen=True)
class Rig:
    # --- identity ---
    maker: str = _p("lcrig", "HELLO: maker")
    model: str = _p("simulated-frame", "HELLO: model")
    serial: str = _p("sim-1", "HELLO: serial number")

    # --- drive ---
    travel_min_mm: float = _p(0.0, "lower soft end, machine's own travel")
    travel_max_mm: float = _p(60.0, "upper soft end, machine's own travel")
    start_travel_mm: float = _p(10.0, "where the machine stands at the start, machine's own travel")
    travel_zero_mm: float = _p(0.0, "machine's own travel that is shown as 0 at the start")
    travel_resolution_mm: float = _p(0.0001, "shown travel is a multiple of this; 0: exact", 0)
    speed_min_mm_s: float = _p(0.0001, "slowest speed", 1e-9)
    speed_max_mm_s: float = _p(20.0, "fastest speed", 1e-9)
    acceleration_mm_s2: float = _p(100.0, "of every start", 1e-3)
    deceleration_mm_s2: float = _p(100.0, "of every stop", 1e-3)
    drive_reaction_s: float = _p(0.002, "from any order to the drive until it follows, STOP included",
                                 0, 10)

    # --- specimen and all that gives way in series with it ---
    contact_travel_mm: float = _p(20.0, "machine's own travel at which the probe touches")
    stiffness_N_mm: float = _p(5.0, "k of force = k d (1 + c d), d: travel beyond contact", 1e-6)
    stiffness_curvature_per_mm: float = _p(0.2, "c of force = k d (1 + c d)")
    stiffness_least_N_mm: float = _p(0.05, "the slope of the force never falls below this", 1e-6)
    stiffness_most_N_mm: float = _p(50.0, "nor rises above this", 1e-6)
    creep_fraction: float = _p(0.0, "part of the compression that creeps away in the end; 0: none",
                               0, 0.9)
    creep_time_s: float = _p(10.0, "time constant of the creep", 1e-3)

    # --- load cell ---
    cell_nominal_N: float = _p(20.0, "beyond this, tension or compression, it is in overload", 1e-6)
    cell_resolution_N: float = _p(0.0005, "shown force is a multiple of this; 0: exact", 0)
    cell_noise_N: float = _p(0.0005, "standard deviation of a reading", 0)
    cell_offset_N: float = _p(0.0, "untared reading without load")
    cell_drift_N_s: float = _p(0.0, "drift of the reading without load")
    cell_gain_ratio: float = _p(1.0, "reading per true force", 0.1, 10)
    zero_force: bool = _p(True, "ZERO force=1 works")
    zero_travel: bool = _p(True, "ZERO travel=1 works")
    zero_average_s: float = _p(0.1, "ZERO takes the mean reading of so long a standstill, at most",
                               0, 10)

    # --- device: what ends a motion by itself ---
    device_stop: bool = _p(True, "force is watched inside the device; 0: by polling")
    device_cycle_s: float = _p(0.001, "cycle of the controller: readings, watching, force loop",
                               STEP_S, 1)
    device_reaction_s: float = _p(0.002, "device_stop=1: from the cycle that sees the force to the "
                                  "order to the drive", 0, 10)
    poll_cycle_s: float = _p(0.05, "device_stop=0: the force is looked at so often", STEP_S, 10)
    poll_reaction_s: float = _p(0.03, "device_stop=0: from the look to the order to the drive", 0, 10)

    # --- force loop ---
    force_loop: bool = _p(True, "RAMPF and HOLD mode=force work")
    loop_speed_mm_s: float = _p(0.5, "fastest speed in force control and in its approach", 1e-6)
    loop_contact_N: float = _p(0.02, "shown force at which contact counts as made", 1e-6)
    loop_rate_max_N_s: float = _p(2.0, "fastest ramp", 1e-6)
    loop_response_s: float = _p(0.05, "time constant with which the loop follows", 1e-3)
    loop_delay_s: float = _p(0.008, "age of the reading that the loop acts on", 0)
    loop_ripple_N: float = _p(0.001, "amplitude of a disturbance of the held force", 0)
    loop_ripple_hz: float = _p(2.0, "its frequency", 0, 100)
    loop_stiffness_max_N_mm: float = _p(60.0, "the loop is stable up to this stiffness", 1e-6)

    # --- samples and answers ---
    rate_max_hz: float = _p(500.0, "fastest sample rate", 1e-3, 1000)
    device_clock: bool = _p(True, "samples carry t_s")
    clock_start_s: float = _p(1000.0, "t_s at the start")
    clock_error_ppm: float = _p(20.0, "the device's seconds are shorter by this", -500000, 500000)
    delivery_delay_s: float = _p(0.0, "from the device to the gateway: samples and ends of motions",
                                 0, 60)
    burst_period_s: float = _p(0.0, "samples are handed over only so often, all at once; 0: as they "
                               "come", 0, 60)
    lost_probability: float = _p(0.0, "that a sample is lost (a hole in seq)", 0, 1)
    missing_t_probability: float = _p(0.0, "that a sample lacks t_s", 0, 1)
    missing_force_probability: float = _p(0.0, "that a sample lacks force_N", 0, 1)
    missing_travel_probability: float = _p(0.0, "that a sample lacks travel_mm", 0, 1)
    missing_flags_probability: float = _p(0.0, "that a sample lacks its flags", 0, 1)
    answer_delay_s: float = _p(0.0, "OK and ERR come so late; STOP does not wait for them", 0, 60)

    # --- what CAPS declare, where it is not the truth ---
    declared_force_max_N: float | None = _declared("force_max_N")
    declared_speed_min_mm_s: float | None = _declared("speed_min_mm_s")
    declared_speed_max_mm_s: float | None = _declared("speed_max_mm_s")
    declared_rate_max_hz: float | None = _declared("rate_max_hz")
    declared_reaction_s: float | None = _declared("reaction_s")
    declared_deceleration_mm_s2: float | None = _declared("deceleration_mm_s2")
    declared_force_approach_mm_s: float | None = _declared("force_approach_mm_s")
    declared_force_contact_N: float | None = _declared("force_contact_N")
    declared_force_rate_max_N_s: float | None = _declared("force_rate_max_N_s")
    declared_force_lag_s: float | None = _declared("force_lag_s")
    declared_force_ripple_N: float | None = _declared("force_ripple_N")
    declared_force_stiffness_max_N_mm: float | None = _declared("force_stiffness_max_N_mm")
    declared_force_class: float | None = _declared("force_class")
    declared_travel_step_um: float | None = _declared("travel_step_um")
    declared_force_step_mN: float | None = _declared("force_step_mN")
    declared_filter_s: float | None = _declared("filter_s")
    declared_play_um: float | None = _declared("play_um")

    def watch_cycle_s(self) -> float:
        return self.device_cycle_s if self.device_stop else self.poll_cycle_s

    def watch_reaction_s(self) -> float:
        return self.device_reaction_s if self.device_stop else self.poll_reaction_s


def _fields() -> dict[str, Field[Any]]:
    return {f.name: f for f in fields(Rig)}


def _checked(key: str, value: Any) -> Any:
    known = _fields()
    if key not in known:
        near = difflib.get_close_matches(key, known, 1)
        hint = f"; did you mean {near[0]}?" if near else "; --print-rig lists all keys"
        raise BadRig(f"{key}: no such parameter{hint}")
    default = known[key].default
    if isinstance(default, str):
        if not isinstance(value, str):
            raise BadRig(f"{key}: expected a text, found {json.dumps(value)}")
        return value
    if isinstance(default, bool):
        if value not in (True, False, 0, 1):
            raise BadRig(f"{key}: expected true or false, found {json.dumps(value)}")
        return bool(value)
    return None if value is None and default is None else _checked_number(known[key], value)


def _checked_number(known: Field[Any], value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise BadRig(f"{known.name}: expected a number, found {json.dumps(value)}")
    low, high = known.metadata["low"], known.metadata["high"]
    if not low <= value <= high:
        raise BadRig(f"{known.name}: {value:g} is outside {low:g} to {high:g}")
    return float(value)


def with_values(rig: Rig, values: Mapping[str, Any]) -> Rig:
    """The rig with these parameters changed. Raises BadRig."""
    changed = replace(rig, **{key: _checked(key, value) for key, value in values.items()})
    _check_together(changed)
    return changed


def _check_together(rig: Rig) -> None:
    for low, inside, high in (
        ("travel_min_mm", "start_travel_mm", "travel_max_mm"),
        ("stiffness_least_N_mm", "stiffness_N_mm", "stiffness_most_N_mm"),
        ("speed_min_mm_s", "loop_speed_mm_s", "speed_max_mm_s"),
    ):
        if not getattr(rig, low) <= getattr(rig, inside) <= getattr(rig, high):
            raise BadRig(f"{inside}: {getattr(rig, inside):g} is not between {low} and {high}")
    if rig.loop_delay_s + rig.drive_reaction_s > rig.loop_response_s / 3:
        raise BadRig("loop_response_s: must be three times loop_delay_s + drive_reaction_s, else the "
                     "loop is not stable")


def parse_text(text: str, name: str) -> dict[str, Any]:
    """Reads a rig file: one JSON object, in which lines that begin with // are remarks. Raises
    BadRig."""
    bare = "\n".join("" if line.lstrip().startswith("//") else line for line in text.splitlines())
    try:
        found = json.loads(bare, object_pairs_hook=_no_doubles)
    except (json.JSONDecodeError, BadRig) as error:
        raise BadRig(f"{name}: {error}") from None
    if not isinstance(found, dict):
        raise BadRig(f"{name}: expected one JSON object, {{\"stiffness_N_mm\": 5, ...}}")
    return found


def _no_doubles(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for key, value in pairs:
        if key in found:
            raise BadRig(f"the key {key} comes twice")
        found[key] = value
    return found


def parse_setting(text: str) -> tuple[str, Any]:
    """Reads key=value of --set. A value that is not JSON is taken as text."""
    key, equals, value = text.partition("=")
    if not equals:
        raise BadRig(f"--set {text}: expected key=value")
    try:
        return key, json.loads(value)
    except json.JSONDecodeError:
        return key, value


def describe(rig: Rig) -> Iterator[str]:
    """The lines of a rig file with all parameters and their meaning."""
    known = list(_fields().values())
    yield "{"
    for f in known:
        assert f.default is not MISSING
        comma = "" if f is known[-1] else ","
        yield f"  // {f.metadata['meaning']}"
        yield f"  {json.dumps(f.name)}: {json.dumps(getattr(rig, f.name))}{comma}"
    yield "}"
