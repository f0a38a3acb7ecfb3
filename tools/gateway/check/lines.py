# SPDX-License-Identifier: Apache-2.0
"""Section 1: what a reader must forgive and what it must refuse."""

from __future__ import annotations

from .bench import Bench, check, require
from .client import seconds

_BAD = [  # each asks for samples, so that obeying it would show
    ("a control character", b"#%d RATE hz=50 x=\x01"),
    ("a tab", b"#%d RATE\thz=50"),
    ("CR in the middle", b"#%d RATE hz=50\r x=1"),
    ("a NUL", b"#%d RATE hz=50 x=\x00"),
    ("a key twice", b"#%d RATE hz=50 hz=50"),
    ("a decimal comma", b"#%d RATE hz=50,5"),
    ("NaN", b"#%d RATE hz=nan"),
    ("infinity", b"#%d RATE hz=inf"),
    ("infinity in digits", b"#%d RATE hz=" + b"9" * 400),
    ("a word for a number", b"#%d RATE hz=fast"),
    ("a quote that does not end", b'#%d RATE hz=50 x="a'),
    ("more than 100 fields", b"#%d RATE hz=50 " + b" ".join(b"x%d=1" % i for i in range(150))),
]


@check("forgives", "1", "CR before LF, several blanks, a leading + and unknown fields are forgiven")
def forgives(bench: Bench) -> None:
    with bench.session() as client:
        for text in ("STATUS\r", "  STATUS   ", "STATUS colour=blue", 'STATUS x="a \\"b\\" \\\\ ="',
                     "RATE hz=+0", "STATUS " + " ".join(f"x{i}=1" for i in range(99)),
                     "STATUS x=" + "a" * 65000):
            client.accepted(text)


@check("refuses", "1", "a line with a forbidden form is answered ERR and not obeyed")
def refuses(bench: Bench) -> None:
    with bench.session() as client:
        mark = client.mark()
        for what, form in _BAD:
            number = client.number()
            client.send_raw(form % number + b"\n")
            answer = client.answer(what, number, mark)
            require(answer.word == "ERR", f"{what}: expected ERR, found {answer.text}")
            code = answer.line.fields.get("code")
            require(code in ("syntax", "bad_value"), f"{what}: expected code=syntax, found {answer.text}")
        seconds(0.25)
        require(not client.since(mark, ["S"]), "samples came: one of the lines was obeyed")


@check("long", "1", "a line of more than 65,536 bytes is not obeyed, and the session goes on")
def long_line(bench: Bench) -> None:
    with bench.session() as client:
        mark = client.mark()
        for size in (66000, 300000):
            client.send(f"#{client.number()} RATE hz=50 x=" + "a" * size)
        client.accepted("STATUS")
        seconds(0.25)
        require(not client.since(mark, ["S"]), "samples came: the long line was obeyed")


@check("unknown", "1", "an unknown word is ignored and reported")
def unknown(bench: Bench) -> None:
    with bench.session() as client:
        mark = client.mark()
        client.send("GREETINGS to=you")
        client.expect("EVENT about an unknown word", mark, lambda r: r.word == "EVENT",
                      1.0 * bench.patience)
        client.refused("GREETINGS to=you", "unknown_command")
        client.accepted("STATUS")
