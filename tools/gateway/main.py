# SPDX-License-Identifier: Apache-2.0
"""Command line of the gateway. Exit codes: 0 ok, 1 failed, 2 wrong usage."""

from __future__ import annotations

import argparse
import importlib
import json
import os
import sys
from pathlib import Path
from typing import Any, Callable, Sequence

from . import __version__
from .backend import Backend
from .server import Server
from .simulated import lie_options, rig as rigs
from .simulated.caps import dishonest
from .simulated.lies import Lies
from .simulated.machine import SimulatedMachine
from .simulated.panel import Panel
from .simulated.truth import Truth
from .transport import Port, SerialPort, TcpPort
from .witness import Witness

_EXAMPLES = """examples:
  lcrig-gateway --port 4710                                  a simulated machine
  lcrig-gateway --set stiffness_N_mm=20 --truth truth.jsonl  a stiffer one, and what it truly did
  lcrig-gateway --print-rig > rig.json                       all its parameters, to edit
  lcrig-gateway --lie creep,speed_um_s=5 --lie estop,motion=3,after_s=1,for_s=0.05
  lcrig-gateway --backend my_machine:open_machine --port 4710
  lcrig-gateway check 127.0.0.1 4710                         does a gateway keep its promises?
"""


class Usage(Exception):
    """The user asked for something that is not possible."""


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="lcrig-gateway", description="Gateway between lcrigd and a load frame (frame-link/1).",
        epilog=_EXAMPLES + "\nlies:\n" + "\n".join(lie_options.overview()), formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--version", action="version", version=__version__)
    link = parser.add_argument_group("link")
    link.add_argument("--host", default="127.0.0.1", metavar="ADDRESS", help="to listen on")
    link.add_argument("--port", type=int, default=0, metavar="N", help="TCP port; 0: any free one")
    link.add_argument("--serial", metavar="PATH", help="a serial line, 115200 8N1, instead of TCP")
    link.add_argument("--revision", type=int, choices=(1, 2, 3), default=3,
                      help="2: as a gateway that states no steps, filter, class and play in CAPS; "
                           "1: nor knows OBSERVE, origin and force loop in CAPS")
    link.add_argument("--ready-file", metavar="PATH", help="gets the ready line too")
    machine = parser.add_argument_group("machine")
    machine.add_argument("--backend", metavar="MODULE:FUNCTION",
                         help="called with --backend-config, returns a Backend; default: simulated")
    machine.add_argument("--backend-config", metavar="FILE", help="whatever that back end reads")
    simulated = parser.add_argument_group("simulated machine")
    simulated.add_argument("--rig", metavar="FILE", help="its parameters (JSON)")
    simulated.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", dest="settings",
                           help="one parameter; goes before --rig")
    simulated.add_argument("--seed", type=int, default=1, metavar="N", help="of noise and losses")
    simulated.add_argument("--print-rig", action="store_true", help="all parameters, then exit")
    simulated.add_argument("--truth", metavar="FILE", help="what truly happens, as JSON lines")
    simulated.add_argument("--lie", action="append", default=[], metavar="NAME,KEY=VALUE,...",
                           dest="lies", help="a lie of the machine, for drills; again for more")
    simulated.add_argument("--list-lies", action="store_true",
                           help="all lies with their parameters, then exit")
    simulated.add_argument("--panel-port", type=int, metavar="N",
                           help="back door: a person at the machine; 0: any free port")
    return parser


def _rig(options: argparse.Namespace) -> rigs.Rig:
    values: dict[str, Any] = {}
    if options.rig:
        try:
            values = rigs.parse_text(Path(options.rig).read_text(encoding="utf-8"), options.rig)
        except (OSError, UnicodeDecodeError) as error:
            raise Usage(f"--rig {options.rig}: {error}") from None
    values.update(rigs.parse_setting(text) for text in options.settings)
    return rigs.with_values(rigs.Rig(), values)


def _foreign_backend(options: argparse.Namespace) -> Backend:
    module, colon, function = options.backend.partition(":")
    if not colon:
        raise Usage(f"--backend {options.backend}: expected MODULE:FUNCTION")
    sys.path.insert(0, os.getcwd())
    try:
        make: Callable[[str | None], Backend] = getattr(importlib.import_module(module), function)
    except (ImportError, AttributeError) as error:
        raise Usage(f"--backend {options.backend}: {error}") from None
    machine = make(options.backend_config)
    if not isinstance(machine, Backend):
        raise Usage(f"--backend {options.backend}: returned no gateway.backend.Backend")
    return machine


def _port(options: argparse.Namespace) -> Port:
    if options.serial:
        if not Path(options.serial).exists():
            print(f"lcrig-gateway: warning: no {options.serial} yet; waiting for it", file=sys.stderr)
        return SerialPort(options.serial)
    try:
        return TcpPort(options.host, options.port)
    except OSError as error:
        raise Usage(f"cannot listen on {options.host}, port {options.port}: {error.strerror}; "
                    "--port 0 takes any free one") from None


def _tell_ready(options: argparse.Namespace, port: Port, panel: Panel | None) -> None:
    ready = {"frame": port.address, "panel": panel.address if panel else None,
             "revision": options.revision, "pid": os.getpid()}
    line = json.dumps(ready)
    if options.ready_file:
        # Renamed in one step, so that nobody sees an incomplete file.
        part = Path(options.ready_file + ".part")
        part.write_text(line + "\n", encoding="utf-8")
        part.replace(options.ready_file)
    print(line, flush=True)


# Time in s after which Python switches threads. STOP must not wait long for the simulated machine.
_SWITCH_S = 0.0005


def _serve(options: argparse.Namespace, backend: Backend, truth: Truth | None, lies: Lies) -> None:
    port = _port(options)
    panel = None
    if options.panel_port is not None:
        if not isinstance(backend, SimulatedMachine):
            raise Usage("--panel-port: only the simulated machine has this back door")
        panel = Panel(backend, options.panel_port)
    server = Server(port, backend, options.revision, truth or Witness(), lies.withholds)
    if isinstance(backend, SimulatedMachine):
        backend.hang_up = server.hang_up
    server.end_on_signals()
    sys.setswitchinterval(_SWITCH_S)
    try:
        server.run(lambda: _tell_ready(options, port, panel))
    finally:
        if panel:
            panel.close()


def serve(arguments: Sequence[str]) -> int:
    options = _parser().parse_args(arguments)
    truth = None
    try:
        rig = _rig(options)
        if options.print_rig:
            print("\n".join(rigs.describe(rig)))
            return 0
        lies = lie_options.parse_all(options.lies)
        if options.list_lies:
            print("\n".join(lie_options.describe()))
            return 0
        if options.backend:
            if options.lies:
                raise Usage("--lie: only the simulated machine lies at will")
            backend = _foreign_backend(options)
        else:
            for lie in dishonest(rig):
                print(f"lcrig-gateway: warning: {lie}", file=sys.stderr)
            truth = Truth(open(options.truth, "w", encoding="utf-8")) if options.truth else None
            backend = SimulatedMachine(rig, options.seed, truth, lies)
        _serve(options, backend, truth, lies)
        return 0
    except (Usage, rigs.BadRig, lie_options.BadLie) as error:
        print(f"lcrig-gateway: {error}", file=sys.stderr)
        return 2
    except OSError as error:
        print(f"lcrig-gateway: {error}", file=sys.stderr)
        return 1
    finally:
        if truth:
            truth.close()


def main(arguments: Sequence[str] | None = None) -> int:
    given = list(sys.argv[1:] if arguments is None else arguments)
    if given[:1] == ["check"]:
        from .check.main import main as check  # a program of its own, not needed to serve
        return check(given[1:])
    return serve(given)
