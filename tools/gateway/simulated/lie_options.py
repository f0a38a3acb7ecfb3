# SPDX-License-Identifier: Apache-2.0
"""--lie NAME,KEY=VALUE,... of the command line."""

from __future__ import annotations

import difflib
import math
from typing import Iterable, Iterator, Mapping

from . import cell_lies, drive_lies
from .lies import CountedLie, Lie, Lies, Parameter, When

LIES: Mapping[str, type[Lie]] = {lie.name: lie for lie in (*cell_lies.ALL, *drive_lies.ALL)}

_WHEN = {
    "at_s": Parameter("so long after the start of the gateway", 0.0, 0),
    "motion": Parameter("from the n-th motion since the start on, instead of at_s", None, 1, 1e6, True),
    "after_s": Parameter("so long after that motion was accepted", 0.0, 0),
    "for_s": Parameter("for so long; else for ever", None, 0, optional=True),
}
_TIMES = {"times": Parameter("for so many motions; else for all", None, 1, optional=True)}


class BadLie(Exception):
    """What is wrong with a --lie, for the user."""


def parse(text: str) -> Lie:
    """One --lie. Raises BadLie."""
    name, *settings = text.split(",")
    if name not in LIES:
        near = difflib.get_close_matches(name, LIES, 1)
        hint = f"; did you mean {near[0]}?" if near else ""
        raise BadLie(f"--lie {text}: no such lie{hint} There are: {', '.join(LIES)}")
    kind = LIES[name]
    given = _settings(text, kind, settings)
    _check_when(text, given)
    when = When(given.pop("at_s", 0.0), int(given.pop("motion", 0)), given.pop("after_s", 0.0),
                given.pop("for_s", math.inf))
    times = given.pop("times", math.inf)
    return kind(when, _with_defaults(text, kind, given), times)


def parse_all(texts: Iterable[str]) -> Lies:
    """All --lie of a command line. Raises BadLie."""
    return Lies(parse(text) for text in texts)


def _allowed(kind: type[Lie]) -> Mapping[str, Parameter]:
    return {**kind.parameters, **_WHEN, **(_TIMES if issubclass(kind, CountedLie) else {})}


def _settings(text: str, kind: type[Lie], settings: Iterable[str]) -> dict[str, float]:
    allowed, given = _allowed(kind), dict[str, float]()
    for setting in settings:
        key, equals, value = setting.partition("=")
        if not equals:
            raise BadLie(f"--lie {text}: {setting}: expected key=value")
        if key not in allowed:
            raise BadLie(f"--lie {text}: {key}: {kind.name} takes {', '.join(allowed)}")
        if key in given:
            raise BadLie(f"--lie {text}: {key} comes twice")
        given[key] = _number(text, key, value, allowed[key])
    return given


def _number(text: str, key: str, value: str, parameter: Parameter) -> float:
    try:
        number = float(value)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise BadLie(f"--lie {text}: {key}: expected a number, found {value!r}")
    if not parameter.low <= number <= parameter.high:
        raise BadLie(f"--lie {text}: {key}: {number:g} is outside {parameter.low:g} to "
                     f"{parameter.high:g}")
    if key in ("motion", "times") and number != int(number):
        raise BadLie(f"--lie {text}: {key}: expected a whole number, found {value!r}")
    return number


def _check_when(text: str, given: Mapping[str, float]) -> None:
    if "at_s" in given and "motion" in given:
        raise BadLie(f"--lie {text}: at_s or motion, not both")
    if "after_s" in given and "motion" not in given:
        raise BadLie(f"--lie {text}: after_s needs motion; at_s is from the start of the gateway")


def _with_defaults(text: str, kind: type[Lie], given: Mapping[str, float]) -> dict[str, float]:
    values = dict(given)
    for key, parameter in kind.parameters.items():
        if key in values or parameter.optional:
            continue
        if parameter.default is None:
            raise BadLie(f"--lie {text}: {kind.name} needs {key}")
        values[key] = parameter.default
    return values


def overview() -> Iterator[str]:
    """One line for each lie."""
    for name, kind in LIES.items():
        yield f"  {name:18}{kind.meaning}"


def describe() -> Iterator[str]:
    """--list-lies."""
    for name, kind in LIES.items():
        yield f"{name:18}{kind.meaning}"
        yield from _parameters(kind.parameters)
    yield "every lie: when"
    yield from _parameters(_WHEN)
    counted = [name for name, kind in LIES.items() if issubclass(kind, CountedLie)]
    yield f"{', '.join(counted)}: how often"
    yield from _parameters(_TIMES)


def _parameters(parameters: Mapping[str, Parameter]) -> Iterator[str]:
    for key, parameter in parameters.items():
        needed = "" if parameter.optional else " (needed)"
        default = needed if parameter.default is None else f" ({parameter.default:g})"
        yield f"    {key:22}{parameter.meaning}{default}"
