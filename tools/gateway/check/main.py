# SPDX-License-Identifier: Apache-2.0
"""Command line of the check. Exit codes: 0 all promises kept, 1 one was not, 2 wrong usage."""

from __future__ import annotations

import argparse
import sys
from typing import Sequence

from . import lines, motions, orders, sessions, signs
from .bench import CHECKS, Bench, Check
from .client import Failed, Skipped

_ORDER = [module.__name__ for module in (lines, sessions, orders, signs, motions)]

_ABOUT = """Checks a gateway as a daemon would meet it, section by section of docs/frame-link.md.
Without --move nothing is moved and without --zero no zero is changed, as far as the gateway keeps its
promises: stay near the E-stop all the same. With --move the machine moves back and forth inside
--travel-mm and presses with up to --force-max-N; each motion is announced before it begins."""

_EXAMPLES = """examples:
  check_gateway.py 127.0.0.1 4710
  check_gateway.py 127.0.0.1 4710 --move --travel-mm 10:22 --force-max-N 1 --speed-mm-s 2 --zero
"""


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="check_gateway.py", description=_ABOUT, epilog=_EXAMPLES,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("host")
    parser.add_argument("port", type=int)
    parser.add_argument("--move", action="store_true", help="motions too")
    parser.add_argument("--travel-mm", metavar="A:B", help="of all motions, as the samples show it")
    parser.add_argument("--force-max-N", type=float, metavar="F", help="limit of all motions")
    parser.add_argument("--speed-mm-s", type=float, default=1.0, metavar="V", help="of the motions; 1")
    parser.add_argument("--zero", action="store_true", help="ZERO too")
    parser.add_argument("--panel", metavar="HOST:PORT", help="back door of the simulated machine")
    parser.add_argument("--patience", type=float, default=1.0, metavar="X",
                        help="factor on the times that a slow computer may exceed; 1")
    parser.add_argument("--only", action="append", default=[], metavar="NAME",
                        help="only the check of this name; may be repeated")
    return parser


def _range(text: str) -> tuple[float, float]:
    low, colon, high = text.partition(":")
    return (float(low), float(high)) if colon else (0.0, 0.0)


def _bench(options: argparse.Namespace, parser: argparse.ArgumentParser) -> Bench:
    bench = Bench(options.host, options.port, options.patience, options.move, options.zero,
                  speed_mm_s=options.speed_mm_s, say=lambda text: print(f"      {text}", flush=True))
    if options.move:
        if not options.travel_mm or not options.force_max_N:
            parser.error("--move needs --travel-mm A:B and --force-max-N F: the limits of all motions")
        try:
            bench.travel_mm = _range(options.travel_mm)
        except ValueError:
            parser.error(f"--travel-mm {options.travel_mm}: expected two numbers, A:B")
        bench.force_max_N = options.force_max_N
        if not (bench.travel_mm[0] < bench.travel_mm[1] and bench.force_max_N > 0 < bench.speed_mm_s):
            parser.error("--travel-mm A:B with A less than B, --force-max-N and --speed-mm-s above 0")
    if options.panel:
        host, _, port = options.panel.removeprefix("tcp://").rpartition(":")
        bench.panel = (host, int(port))
    return bench


def _meet(bench: Bench) -> None:
    """Find out who is there, for the checks that depend on it."""
    with bench.connect() as client:
        hello, caps = bench.open(client)
        bench.hello, bench.caps = hello.line.fields, caps.line.fields
    fields = bench.hello
    print(f"gateway: {fields.get('maker')} {fields.get('model')}, revision {bench.revision}"
          f"{', simulated' if fields.get('simulated') == '1' else ''}")


def _run(check: Check, bench: Bench) -> str:
    label = f"section {check.section}  {check.name}: {check.promise}"
    try:
        if check.moves and not bench.move:
            raise Skipped("needs --move")
        check.run(bench)
    except Skipped as reason:
        print(f"skip  {label}: {reason}", flush=True)
        return "skipped"
    except Exception as error:  # a bug on either side must not hide the other checks
        kind = "" if isinstance(error, Failed) else f"{type(error).__name__}: "
        print(f"FAIL  {label}: {kind}{error}", flush=True)
        return "failed"
    print(f"ok    {label}", flush=True)
    return "passed"


def _check_form(bench: Bench) -> str:
    label = "section 1  form: every line that the gateway wrote has the right form"
    if not bench.ill_formed:
        print(f"ok    {label}")
        return "passed"
    print(f"FAIL  {label}: {len(bench.ill_formed)} did not; the first: {bench.ill_formed[0]}")
    return "failed"


def main(arguments: Sequence[str] | None = None) -> int:
    parser = _parser()
    options = parser.parse_args(arguments)
    bench = _bench(options, parser)
    CHECKS.sort(key=lambda c: _ORDER.index(c.run.__module__))
    names = [c.name for c in CHECKS]
    if set(options.only) - set(names):
        parser.error(f"--only: no such check; there are {', '.join(names)}")
    wanted = [c for c in CHECKS if not options.only or c.name in options.only]
    try:
        _meet(bench)
    except (Failed, Skipped, OSError) as error:
        print(f"FAIL  section 2  hello: no session with {bench.host}:{bench.port}: {error}")
        return 1
    counts = dict.fromkeys(("passed", "failed", "skipped"), 0)
    for check in wanted:
        counts[_run(check, bench)] += 1
    counts[_check_form(bench)] += 1
    print(", ".join(f"{count} {verdict}" for verdict, count in counts.items()))
    return 1 if counts["failed"] else 0


if __name__ == "__main__":
    sys.exit(main())
