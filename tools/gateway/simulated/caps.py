# SPDX-License-Identifier: Apache-2.0
"""What the simulated machine declares in CAPS, and whether it keeps that."""

from __future__ import annotations

from typing import Iterator

from ..backend import Capabilities, ForceLoop
from .rig import STEP_S, Rig

_LESS_IS_SAFER = ("declared_deceleration_mm_s2", "declared_force_max_N", "declared_speed_max_mm_s",
                  "declared_rate_max_hz", "declared_force_rate_max_N_s",
                  "declared_force_stiffness_max_N_mm")


def _truth(rig: Rig) -> dict[str, float]:
    """The worst case of this machine, with the names of its declarations."""
    # The force is noticed at the next watch. With polling, it is noticed in a reading of the last
    # device cycle.
    cycles_s = rig.watch_cycle_s() + (0.0 if rig.device_stop else rig.device_cycle_s)
    # A creeping specimen loses force at no more than twice the rate of one that does not creep.
    creep_N_s = 2 * rig.cell_nominal_N * rig.creep_fraction / rig.creep_time_s
    return {
        "declared_force_max_N": rig.cell_nominal_N,
        "declared_speed_min_mm_s": rig.speed_min_mm_s,
        "declared_speed_max_mm_s": rig.speed_max_mm_s,
        "declared_rate_max_hz": rig.rate_max_hz,
        "declared_reaction_s": cycles_s + rig.watch_reaction_s() + rig.drive_reaction_s + STEP_S,
        "declared_deceleration_mm_s2": rig.deceleration_mm_s2,
        "declared_force_approach_mm_s": rig.loop_speed_mm_s,
        "declared_force_contact_N": rig.loop_contact_N,
        "declared_force_rate_max_N_s": rig.loop_rate_max_N_s,
        "declared_force_lag_s": (rig.loop_delay_s + 2 * rig.device_cycle_s
                                 + rig.loop_speed_mm_s / rig.deceleration_mm_s2),
        "declared_force_ripple_N": (rig.loop_ripple_N + 5 * rig.cell_noise_N + rig.cell_resolution_N
                                    + creep_N_s * (rig.loop_response_s + rig.loop_delay_s)),
        "declared_force_stiffness_max_N_mm": rig.loop_stiffness_max_N_mm,
        "declared_force_class": _class(rig),
        "declared_travel_step_um": round(rig.travel_resolution_mm * 1e3, 9),
        "declared_force_step_mN": round(rig.cell_resolution_N * 1e3, 9),
        "declared_filter_s": 0.0,  # the cell shows each reading at once
        "declared_play_um": 0.0,
    }


def _class(rig: Rig) -> float:
    """The class of ISO 7500-1 that the gain keeps; 3 if it keeps none."""
    error_percent = abs(rig.cell_gain_ratio - 1) * 100
    return next((limit for limit in (0.5, 1.0, 2.0) if error_percent <= limit), 3.0)


def _with_margin(name: str, value: float) -> float:
    if name in ("declared_reaction_s", "declared_force_lag_s"):
        return round(value * 1.2 + 0.001, 6)
    if name == "declared_deceleration_mm_s2":
        return value * 0.95
    if name == "declared_force_ripple_N":
        return value * 1.5
    return value


def _declared(rig: Rig) -> dict[str, float]:
    said = {}
    for name, value in _truth(rig).items():
        given = getattr(rig, name)
        said[name] = _with_margin(name, value) if given is None else given
    return said


def declare(rig: Rig, travel_zero_mm: float) -> Capabilities:
    said = {name.removeprefix("declared_"): value for name, value in _declared(rig).items()}
    loop = ForceLoop(**{name: said.pop(name) for name in ForceLoop.__dataclass_fields__})
    return Capabilities(
        motion=True, device_stop=rig.device_stop, force_hold=rig.force_loop, force=True, travel=True,
        zero_force=rig.zero_force, zero_travel=rig.zero_travel,
        travel_min_mm=round(rig.travel_min_mm - travel_zero_mm, 9),
        travel_max_mm=round(rig.travel_max_mm - travel_zero_mm, 9),
        loop=loop if rig.force_loop else None, **said)


def dishonest(rig: Rig) -> Iterator[str]:
    """Declarations that promise more than the machine keeps."""
    said, true = _declared(rig), _truth(rig)
    for name, value in true.items():
        too_much = said[name] > value if name in _LESS_IS_SAFER else said[name] < value
        if too_much and name != "declared_speed_min_mm_s":
            yield f"{name}={said[name]:g}, but it is {value:g}"
