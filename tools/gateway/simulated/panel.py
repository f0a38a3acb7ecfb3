# SPDX-License-Identifier: Apache-2.0
"""The back door of the simulated machine: what a person at its panel can do, whoever commands the
link. Lines over TCP in the form of the link (`MOVE travel_mm=12 speed_mm_s=0.5`, `STOP`, `ZERO
force=1 travel=0`) are answered by `OK` or `ERR text=".."`. Travel is as shown. There is also one
order that no person could give: `LIE text="creep,speed_um_s=5"` works like --lie, from now on."""

from __future__ import annotations

import socketserver
import threading

from ..backend import Refused
from ..protocol import Malformed, Missing, parse, write
from . import lie_options
from .machine import SimulatedMachine


class _Handler(socketserver.StreamRequestHandler):
    server: "_Server"

    def handle(self) -> None:
        for raw in self.rfile:
            try:
                _obey(self.server.machine, raw.rstrip(b"\n"))
                self.wfile.write(write("OK"))
            except (Malformed, Missing, Refused, lie_options.BadLie) as error:
                self.wfile.write(write("ERR", {"text": str(error)}))
            except OSError:
                return  # the person has gone


class _Server(socketserver.ThreadingTCPServer):
    allow_reuse_address = True
    daemon_threads = True
    machine: SimulatedMachine


def _obey(machine: SimulatedMachine, raw: bytes) -> None:
    line = parse(raw)
    if line.word == "MOVE":
        machine.panel_move(line.real("travel_mm"), line.real("speed_mm_s"))
    elif line.word == "STOP":
        machine.stop()
    elif line.word == "ZERO":
        machine.panel_zero(line.flag("force"), line.flag("travel"))
    elif line.word == "LIE":
        machine.panel_lie(lie_options.parse(line.text("text")))
    else:
        raise Missing(f"{line.word}: the panel knows MOVE, STOP, ZERO and LIE")


class Panel:
    def __init__(self, machine: SimulatedMachine, port: int) -> None:
        self._server = _Server(("127.0.0.1", port), _Handler)
        self._server.machine = machine
        self.address = f"tcp://127.0.0.1:{self._server.server_address[1]}"
        self._thread = threading.Thread(target=self._server.serve_forever, args=(0.05,), name="panel",
                                        daemon=True)
        self._thread.start()

    def close(self) -> None:
        self._server.shutdown()
        self._server.server_close()
