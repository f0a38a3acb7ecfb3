# SPDX-License-Identifier: Apache-2.0
"""Checks strictly the form of what a gateway writes. A reader must forgive some forms that a writer
must not use."""

from __future__ import annotations

import re
from typing import Iterator

from ..protocol import MAX_LINE_BYTES, Line, Malformed, parse

_NUMBER = re.compile(r"-?[0-9]+(\.[0-9]+)?\Z")
_NUMERIC = re.compile(r".*(_N|_mm|_mm_s|_mm_s2|_N_s|_N_mm|_s|_hz)\Z")
_INTEGERS = ("proto", "revision", "seq", "n", "stops")
_FLAGS = ("motion", "device_stop", "force_hold", "zero_force", "zero_travel", "simulated")
_WORDS = ("HELLO", "CAPS", "OK", "ERR", "DONE", "S", "HB", "EVENT", "STOPPED")
_CODES = ("syntax", "unknown_command", "bad_value", "not_armed", "limits", "machine_limits", "busy",
          "unsupported", "no_contact", "not_ready", "overload", "observer", "internal")
_REASONS = ("target", "force_limit", "travel_limit", "stop", "fault")


def complaints(raw: bytes) -> Iterator[str]:
    """Everything that is wrong with one line of the gateway."""
    if len(raw) >= MAX_LINE_BYTES:
        yield "more than 65,536 bytes"
    if raw.endswith(b"\r"):
        yield "CR before LF"
    try:
        line = parse(raw)
    except Malformed:
        return  # the reader reports it
    yield from _blanks(raw.decode("utf-8"))
    if line.word not in _WORDS:
        yield "no word of section 1 to 6"
    for key, value in line.fields.items():
        yield from _value(line, key, value)
    if line.word == "S":
        yield from _samples(line)


def _blanks(text: str) -> Iterator[str]:
    outside = re.sub(r'"(?:[^"\\]|\\.)*"', '""', text)
    if "  " in outside or outside != outside.strip(" "):
        yield "a blank too many"


def _value(line: Line, key: str, value: str) -> Iterator[str]:
    if line.word == "S" and key in ("t_s", "force_N", "travel_mm"):
        bad = [v for v in value.split(",") if v and not _NUMBER.match(v)]
        if bad:
            yield f"{key}: {bad[0]!r} is no number"
    elif key in _INTEGERS and not value.isdigit():
        yield f"{key}={value} is no whole number"
    elif key in _FLAGS and value not in ("0", "1"):
        yield f"{key}={value} is neither 0 nor 1"
    elif _NUMERIC.match(key) and not _NUMBER.match(value):
        yield f"{key}={value} is no number"
    if line.word == "ERR" and key == "code" and value not in _CODES:
        yield f"code={value} is not in section 4"
    if line.word == "DONE" and key == "reason" and value not in _REASONS:
        yield f"reason={value} is not in section 4"


def _samples(line: Line) -> Iterator[str]:
    fields = line.fields
    if not fields.get("seq", "").isdigit() or not fields.get("n", "").isdigit():
        yield "S without seq or n"
        return
    count = int(fields["n"])
    if count < 1 or int(fields["seq"]) < 1:
        yield "S with seq or n below 1"
    for key in ("t_s", "force_N", "travel_mm"):
        values = fields[key].split(",") if key in fields else []
        if key in fields and len(values) != count:
            yield f"{key} has {len(values)} values, n is {count}"
        if key in fields and not any(values):
            yield f"{key} has no value: it is to be left out"
    words = fields["flags"].split(",") if "flags" in fields else []
    if words and len(words) not in (1, count):
        yield f"flags has {len(words)} words, n is {count}"
    if any(not re.fullmatch(r"-|[MFO]{1,3}|", word) for word in words):
        yield f"flags={fields['flags']}: M, F, O or -"
    forces = fields["force_N"].split(",") if "force_N" in fields else []
    if len(words) == len(forces) and any("O" in w and f for w, f in zip(words, forces)):
        yield "a force beyond the load cell has a value"
