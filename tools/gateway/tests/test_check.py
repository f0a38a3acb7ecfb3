# SPDX-License-Identifier: Apache-2.0
import sys
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import contextlib
import io
import subprocess
import threading
from dataclasses import replace
from typing import Any, Iterator
from unittest import mock

from gateway.backend import State, Window
from gateway.check import main as check_main
from gateway.check.bench import CHECKS, STATED_NUMBERS
from gateway.server import Server
from gateway.simulated.caps import declare
from gateway.simulated.machine import SimulatedMachine
from gateway.simulated.panel import Panel
from gateway.simulated.rig import Rig, with_values
from gateway.tests.support import Gateway
from gateway.transport import TcpPort

RIG = {"start_travel_mm": 19.5}
MOVES = ["--move", "--zero", "--travel-mm", "19.5:20.4", "--force-max-N", "1", "--speed-mm-s", "1"]
SCRIPT = Path(check_main.__file__).resolve().parents[1] / "check_gateway.py"


class Runs:
    """The whole check as a program, against the simulated gateway of one revision. The checks are
    divided among several gateways, which run at the same time."""

    def __init__(self, revision: int, hands: int) -> None:
        self._stack = contextlib.ExitStack()
        self._gateways = [self._stack.enter_context(Gateway("--revision", str(revision), **RIG))
                          for _ in range(hands)]
        self._runs: list[subprocess.Popen[str]] = []

    def begin(self) -> "Runs":
        names = [check.name for check in CHECKS]
        hands = len(self._gateways)
        for hand, gateway in enumerate(self._gateways):
            self._runs.append(self._run(gateway, names[hand::hands]))
        return self

    def _run(self, gateway: Gateway, names: list[str]) -> subprocess.Popen[str]:
        host, port = gateway.address()
        return subprocess.Popen(
            ["/usr/bin/python3", "-W", "error", str(SCRIPT), host, str(port), *MOVES,
             *[f"--only={name}" for name in names], "--patience", "4", "--panel", gateway.ready["panel"]],
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)

    def outputs(self) -> tuple[list[int], str]:
        """Exit codes, and what was printed."""
        with self._stack:
            outputs = [run.communicate(timeout=60)[0] for run in self._runs]
        return [run.returncode for run in self._runs], "".join(outputs)


_RUNS: dict[int, Runs] = {}


def setUpModule() -> None:
    """Starts the checks, which mostly wait, so that the other tests run meanwhile."""
    _RUNS.update({3: Runs(3, 6), 2: Runs(2, 6), 1: Runs(1, 3)})
    for runs in _RUNS.values():
        runs.begin()


def tearDownModule() -> None:
    for revision in list(_RUNS):
        _RUNS.pop(revision).outputs()


class Conformance(unittest.TestCase):
    def kept(self, revision: int) -> list[str]:
        codes, output = _RUNS.pop(revision).outputs()
        self.assertEqual(set(codes), {0}, output)
        return output.splitlines()

    def skipped(self, lines: list[str]) -> set[str]:
        return {line.split(":")[0].split()[-1] for line in lines if line.startswith("skip")}

    def test_revisions_2_and_3_keep_every_promise(self) -> None:
        for revision in (2, 3):
            lines = self.kept(revision)
            self.assertEqual(self.skipped(lines), {"revision_1"})
            self.assertEqual(sum(line.startswith("ok") for line in lines), len(CHECKS) - 1 + 6)

    def test_revision_1_keeps_its_own(self) -> None:
        lines = self.kept(1)
        self.assertEqual(self.skipped(lines), {c.name for c in CHECKS if c.name.startswith("observe")}
                         | {"rampf", "close_stops"})


@contextlib.contextmanager
def served(**rig: Any) -> Iterator[list[str]]:
    """Serves the simulated gateway in this process, so that a test can break it. Yields the address
    for the check."""
    machine = SimulatedMachine(with_values(Rig(), {**RIG, **rig}))
    port = TcpPort("127.0.0.1", 0)
    panel = Panel(machine, 0)
    server = Server(port, machine)
    thread = threading.Thread(target=server.run)
    thread.start()
    try:
        yield ["127.0.0.1", port.address.rsplit(":", 1)[1], "--panel", panel.address, "--patience", "1"]
    finally:
        server.end()
        thread.join(10)
        panel.close()


class BrokenGateways(unittest.TestCase):
    """The check must find a gateway that breaks a promise."""

    def fails(self, name: str, *patches: Any, moves: bool = False) -> None:
        output = io.StringIO()
        with contextlib.ExitStack() as stack:
            for patch in patches:
                stack.enter_context(patch)
            address = stack.enter_context(served())
            stack.enter_context(contextlib.redirect_stdout(output))
            only = [] if name == "form" else [f"--only={name}"]
            only = only or ["--only=hello"]
            code = check_main.main([*address, *only, *(MOVES if moves else [])])
        self.assertEqual(code, 1, output.getvalue())
        self.assertRegex(output.getvalue(), rf"FAIL  section \d  {name}:")

    def test_motion_before_limits(self) -> None:
        window = Window(-20, 20, 0, 60, 20)
        self.fails("not_armed", mock.patch("gateway.rules.check_ready", lambda s: window))

    def test_steps_that_are_not_stated(self) -> None:
        for key in STATED_NUMBERS["force"]:
            self.fails("hello", mock.patch("gateway.simulated.device.declare",
                                           lambda *given: replace(declare(*given), **{key: None})))

    def test_no_watchdog(self) -> None:
        self.fails("silence", mock.patch("gateway.session.SILENCE_S", 1e9))

    def test_no_life_signs(self) -> None:
        self.fails("life_signs", mock.patch("gateway.session.HEARTBEAT_S", 0.9))

    def test_stops_are_not_counted(self) -> None:
        self.fails("stops", mock.patch("gateway.session.Session._begin", _begin_counting_on))

    def test_lines_cover_too_much(self) -> None:
        self.fails("samples", mock.patch("gateway.sample_lines.LINE_COVERS_S", 0.4))

    def test_observer_that_stops_the_machine(self) -> None:
        def closed(session: Any) -> None:
            session._backend.stop()

        self.fails("observe_motion", mock.patch("gateway.session.Session.closed", closed), moves=True)

    def test_guard_that_is_passed(self) -> None:
        def beyond(self: Any, target_mm: float, speed_mm_s: float) -> bool:
            return step_to(self, target_mm + 0.1, speed_mm_s)

        from gateway.simulated.physics import Drive
        step_to = Drive.step_to
        self.fails("guard", mock.patch("gateway.simulated.physics.Drive.step_to", beyond), moves=True)

    def test_busy_that_is_not_seen(self) -> None:
        def blind(executor: Any) -> Any:
            from gateway.rules import Situation
            return Situation(executor._backend.capabilities(), executor.limits,
                             executor._backend.state(), "")

        self.fails("busy", mock.patch("gateway.executor.Executor._situation", blind), moves=True)

    def test_exponents(self) -> None:
        self.fails("form", mock.patch("gateway.protocol.format_real", lambda value: f"{value:e}"))

    def test_stopped_while_it_still_moves(self) -> None:
        def liar(self: SimulatedMachine) -> State:
            return State(False, False, 0.0, 19.6, False, 0.01)

        self.fails("stop", mock.patch.object(SimulatedMachine, "state", liar),
                   mock.patch("gateway.executor.Executor.moves", lambda self: False), moves=True)


def _begin_counting_on(session: Any, kind: Any, hz: float = 0.0) -> None:
    session.kind, session._last_number, session._stops = kind, 0, session._stops + 1
    session._executor.begin_session(hz)


if __name__ == "__main__":
    unittest.main()
