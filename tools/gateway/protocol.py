# SPDX-License-Identifier: Apache-2.0
"""Lines of frame-link/1 (docs/frame-link.md, section 1): a strict writer and a tolerant reader."""

from __future__ import annotations

import math
import re
import unicodedata
from dataclasses import dataclass, field
from decimal import Decimal
from typing import Iterator, Mapping, Sequence, Union

MAX_LINE_BYTES = 65536
MAX_FIELDS = 100
MAX_TEXT_CHARACTERS = 1000  # of our own texts, so that none fills a line

_REAL = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)\Z")  # section 1 has no exponents
_WORD = re.compile(r"[A-Za-z][A-Za-z0-9_]*\Z")
_KEY = re.compile(r"[A-Za-z0-9_]+\Z")
_PLAIN_TEXT = re.compile(r"[A-Za-z_][A-Za-z0-9_.:/-]*\Z")
_COMMAND = re.compile(r"#([0-9]{1,18})\Z")
_COMMAND_HINT = re.compile(rb" *(?:[A-Za-z][A-Za-z0-9_]* +)?#([0-9]{1,18})(?=[^0-9]|\Z)")
_TOKEN = re.compile(
    r' *(?:(?P<key>[^ ="]*)=(?:"(?P<quoted>(?:[^"\\]|\\["\\])*)"|(?P<bare>[^ "]*))|(?P<word>[^ ="]+))'
    r"(?= |\Z)"
)
_ESCAPED = re.compile(r'\\(["\\])')


class Malformed(Exception):
    """A line that counts as not received. `command` is its number if one can be read."""

    def __init__(self, why: str, command: int | None = None) -> None:
        super().__init__(why)
        self.command = command


class Missing(Exception):
    """A received line that lacks a field."""


@dataclass(frozen=True)
class Line:
    """A word, perhaps a command number, and fields as text. real(), flag() and others read the
    values."""

    word: str
    command: int | None = None
    fields: Mapping[str, str] = field(default_factory=dict)

    def _text(self, key: str) -> str:
        if key not in self.fields:
            raise Missing(f"{self.word} lacks the field {key}")
        return self.fields[key]

    def text(self, key: str, default: str | None = None) -> str:
        return default if default is not None and key not in self.fields else self._text(key)

    def real(self, key: str, default: float | None = None) -> float:
        """A finite number. Raises Missing, or Malformed for a comma, NaN, an exponent and the
        like."""
        if default is not None and key not in self.fields:
            return default
        value = self._text(key)
        # A number of 400 digits has a valid form but is infinite.
        if not _REAL.match(value) or not math.isfinite(float(value)):
            raise Malformed(f"{key}={_shown(value)} is not a number", self.command)
        return float(value)

    def flag(self, key: str) -> bool:
        """1 or 0; an absent flag is 0."""
        value = self.real(key, 0.0)
        if value not in (0.0, 1.0):
            raise Malformed(f"{key}={_shown(self.fields[key])} is neither 0 nor 1", self.command)
        return value == 1.0


def _shown(text: str) -> str:
    """A part of a bad line for a message, short and printable."""
    return "".join(c if c.isprintable() else "?" for c in text[:40])


def parse(raw: bytes) -> Line:
    """Reads one line (without its LF). Raises Malformed."""
    hint = _COMMAND_HINT.match(raw[:100])
    command = int(hint.group(1)) if hint else None
    try:
        return _parse_text(_decoded(raw))
    except Malformed as bad:
        raise Malformed(str(bad), command) from None


def _decoded(raw: bytes) -> str:
    raw = raw.removesuffix(b"\r")
    if len(raw) > MAX_LINE_BYTES:
        raise Malformed(f"a line of more than {MAX_LINE_BYTES} bytes")
    try:
        text = raw.decode("utf-8")
    except UnicodeDecodeError as error:
        raise Malformed(f"byte {error.start} is not UTF-8") from None
    # isprintable() is fast, and most lines pass it. Category Cc contains C0, DEL and C1.
    if not text.isprintable() and any(unicodedata.category(c) == "Cc" for c in text):
        raise Malformed("a control character")
    return text


def _parse_text(text: str) -> Line:
    words: list[str] = []
    fields: dict[str, str] = {}
    end = len(text.rstrip(" "))
    at = 0
    while at < end:
        token = _TOKEN.match(text, at, end)
        if token is None:
            raise Malformed(f"cannot read {_shown(text[at:].lstrip())!r}")
        at = token.end()
        if token["word"] is not None:
            if fields:
                raise Malformed(f"{_shown(token['word'])!r} is no field key=value")
            words.append(token["word"])
        else:
            _add_field(fields, token)
    return _line(words, fields)


def _add_field(fields: dict[str, str], token: re.Match[str]) -> None:
    key, quoted = token["key"], token["quoted"]
    if not _KEY.match(key):
        raise Malformed(f"{_shown(key)!r} is no key: letters, digits and _")
    if key in fields:
        raise Malformed(f"the key {key} comes twice")
    if len(fields) == MAX_FIELDS:
        raise Malformed(f"more than {MAX_FIELDS} fields")
    fields[key] = token["bare"] if quoted is None else _ESCAPED.sub(r"\1", quoted)


def _line(words: list[str], fields: dict[str, str]) -> Line:
    """Both `#17 MOVE` and `OK #17`: the number may be before or after the word."""
    numbers = [word for word in words if word.startswith("#")]
    others = [word for word in words if not word.startswith("#")]
    if len(others) != 1 or len(numbers) > 1 or not _WORD.match(others[0]):
        raise Malformed("expected a word, perhaps a command number, then key=value fields")
    if not numbers:
        return Line(others[0], None, fields)
    command = _COMMAND.match(numbers[0])
    if command is None or int(command.group(1)) == 0:
        raise Malformed(f"{_shown(numbers[0])!r} is no command number")
    return Line(others[0], int(command.group(1)), fields)


@dataclass(frozen=True)
class Column:
    """One value per sample, None where a value is missing (section 5)."""

    values: Sequence[Union[float, str, None]]


Value = Union[bool, int, float, str, Column, None]


def format_real(value: float) -> str:
    """All digits of a number, with a decimal point and without an exponent."""
    if not math.isfinite(value):
        raise ValueError(f"{value} cannot be written: leave the field out")
    text = repr(float(value))
    if "e" in text:
        text = format(Decimal(text), "f")
    return text.removesuffix(".0")


def _format_text(text: str) -> str:
    if _PLAIN_TEXT.match(text):
        return text
    clean = "".join("?" if unicodedata.category(c) in ("Cc", "Cs") else c for c in text)
    clean = clean[:MAX_TEXT_CHARACTERS].replace("\\", "\\\\").replace('"', '\\"')
    return f'"{clean}"'


def _format_value(value: Value) -> str:
    if isinstance(value, Column):
        return ",".join("" if v is None else v if isinstance(v, str) else format_real(v)
                        for v in value.values)
    if isinstance(value, bool):
        return "1" if value else "0"
    if isinstance(value, int):
        return str(value)
    return format_real(value) if isinstance(value, float) else _format_text(str(value))


def write(word: str, fields: Mapping[str, Value] | None = None, answer_to: int | None = None,
          command: int | None = None) -> bytes:
    """One line with its LF. Fields that are None are left out."""
    parts = [f"#{command}"] if command is not None else []
    parts.append(word)
    if answer_to is not None:
        parts.append(f"#{answer_to}")
    parts += [f"{key}={_format_value(v)}" for key, v in (fields or {}).items() if v is not None]
    raw = " ".join(parts).encode("utf-8") + b"\n"
    if len(raw) > MAX_LINE_BYTES:
        raise ValueError(f"a line of {len(raw)} bytes; at most {MAX_LINE_BYTES} are allowed")
    return raw


class LineSplitter:
    """Cuts a stream into lines. Of a line that is too long only the beginning is kept. parse() then
    refuses it, and a peer that never sends an LF cannot fill the memory."""

    def __init__(self) -> None:
        self._rest = bytearray()

    def feed(self, data: bytes) -> Iterator[bytes]:
        pieces = data.split(b"\n")
        for piece in pieces[:-1]:
            self._keep(piece)
            yield bytes(self._rest)
            self._rest.clear()
        self._keep(pieces[-1])

    def _keep(self, piece: bytes) -> None:
        # one byte for CR, one to see that the line is too long
        room = MAX_LINE_BYTES + 2 - len(self._rest)
        self._rest += piece[:max(room, 0)]
