# SPDX-License-Identifier: Apache-2.0
"""A session without threads, sockets and real time, and a gateway as a process."""

from __future__ import annotations

import functools
import json
import socket
import subprocess
import tempfile
import time
from pathlib import Path
from typing import Any, Callable, Iterator

from gateway.backend import (Backend, Capabilities, Ended, ForceLoop, HoldForce, Identity, Listener,
                             Motion, Sample, State, Window)
from gateway.protocol import Line, parse
from gateway.session import Session

LOOP = ForceLoop(0.5, 0.02, 2.0, 0.02, 0.005, 50.0)
CAPABILITIES = Capabilities(True, True, True, True, True, True, True, 20.0, 0.001, 10.0, -30.0, 30.0,
                            500.0, 0.01, 100.0, LOOP, 1.0, 0.1, 0.5, 0.02, 3.0)
STANDING = State(False, False, 0.0, 0.0, False, 0.002)
LIMITS = ("LIMITS force_min_N=-0.2 force_max_N=1.5 travel_min_mm=-5 travel_max_mm=5 "
          "speed_max_mm_s=1")
PROGRAM = Path(__file__).resolve().parents[1] / "lcrig-gateway"


class FakeMachine(Backend):
    """Does nothing by itself and records its calls."""

    def __init__(self) -> None:
        self.calls: list[Any] = []
        self.now = STANDING
        self.can = CAPABILITIES
        self.zeros = 0
        self.refuses: Exception | None = None

    def stop(self) -> None:
        self.calls.append("stop")

    def state(self) -> State:
        return self.now

    def identity(self) -> Identity:
        return Identity("maker", "a model", "1", "1.0", simulated=True)

    def capabilities(self) -> Capabilities:
        return self.can

    def origin(self) -> str:
        return f"o{self.zeros}"

    def refresh(self) -> None:
        self.calls.append("refresh")

    def arm(self, window: Window) -> None:
        self._do(window)

    def start(self, motion: Motion) -> None:
        self._do(motion)

    def hold_force(self, hold: HoldForce) -> None:
        self._do(hold)

    def zero(self, force: bool, travel: bool) -> None:
        self._do(("zero", force, travel))
        self.zeros += 1

    def set_rate(self, hz: float) -> None:
        self._do(("rate", hz))

    def open(self, listener: Listener) -> None: ...

    def close(self) -> None: ...

    def _do(self, what: object) -> None:
        if self.refuses:
            raise self.refuses
        self.calls.append(what)

    def motion(self) -> Any:
        """The last motion that was started."""
        return [c for c in self.calls if hasattr(c, "token")][-1]

    def stops(self) -> int:
        return self.calls.count("stop")


class Desk:
    """A session together with its daemon, its machine and its clock."""

    def __init__(self, revision: int = 3) -> None:
        self.machine = FakeMachine()
        self.time_s = 100.0
        self.waiting: list[Callable[[], None]] = []
        self.blocked = False  # commands stay in the command thread until release()
        self._lines: list[bytes] = []
        self.session = Session(self.machine, self, revision)
        self.session.opened()

    # --- Host ---

    def now_s(self) -> float:
        return self.time_s

    def send(self, line: bytes) -> None:
        self._lines.append(line)

    def send_samples(self, line: bytes) -> None:
        self.send(line)

    def run_command(self, work: Callable[[], object], done: Callable[[object, Any], None]) -> None:
        def carry_out() -> None:
            try:
                result = work()
            except Exception as error:
                done(None, error)
                return
            done(result, None)

        self.waiting.append(carry_out)
        if not self.blocked:
            self.release()

    # --- for tests ---

    def release(self, count: int = 1000) -> None:
        while self.waiting and count:
            self.waiting.pop(0)()
            count -= 1

    def say(self, *texts: str) -> list[Line]:
        """The daemon sends these lines. Returns what the gateway answers."""
        for text in texts:
            self.session.received(text.encode())
        return self.said()

    def said(self) -> list[Line]:
        lines, self._lines = self._lines, []
        return [parse(raw.rstrip(b"\n")) for raw in lines]

    def one(self, text: str) -> Line:
        lines = self.say(text)
        assert len(lines) == 1, lines
        return lines[0]

    def code(self, text: str) -> str:
        """OK, or the code of the refusal, as the answer to a command."""
        line = self.one(text)
        return line.fields["code"] if line.word == "ERR" else line.word

    def wait(self, seconds: float, step_s: float = 0.01) -> list[Line]:
        """Lets time pass while the daemon is silent."""
        for _ in range(round(seconds / step_s)):
            self.time_s += step_s
            self.session.tick()
        return self.said()

    def armed(self) -> "Desk":
        self.say("HELLO proto=1 revision=2 side=host", f"#1 {LIMITS}")
        self.machine.calls.clear()
        return self

    def end(self, reason: str, text: str = "") -> list[Line]:
        """Ends the last motion."""
        self.session.ended(Ended(self.machine.motion().token, reason, text, 0.5, 1.0))
        return self.said()


def sample(**changes: Any) -> Sample:
    values: dict[str, Any] = {"t_s": 1.0, "force_N": 0.5, "travel_mm": 2.0, **changes}
    return Sample(**values)


class Gateway:
    """The simulated gateway as a process."""

    def __init__(self, *options: str, **rig: float) -> None:
        self._folder = tempfile.TemporaryDirectory()
        self.truth_file = Path(self._folder.name) / "truth.jsonl"
        settings = [f"--set={key}={json.dumps(value)}" for key, value in rig.items()]
        self.process = subprocess.Popen(
            ["/usr/bin/python3", "-W", "error", str(PROGRAM), "--truth", str(self.truth_file),
             "--panel-port", "0", *settings, *options],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)

    @functools.cached_property
    def ready(self) -> dict[str, Any]:
        """Waits until the gateway is ready."""
        assert self.process.stdout
        line = self.process.stdout.readline()
        if not line:
            raise AssertionError(f"no gateway: {self.end()[1]}")
        ready: dict[str, Any] = json.loads(line)
        return ready

    def __enter__(self) -> "Gateway":
        return self

    def __exit__(self, *_: object) -> None:
        self.end()
        self._folder.cleanup()

    def address(self, name: str = "frame") -> tuple[str, int]:
        host, port = self.ready[name].removeprefix("tcp://").rsplit(":", 1)
        return host, int(port)

    def end(self) -> tuple[int, str]:
        """Sends SIGTERM. Returns the exit code and standard error."""
        if self.process.poll() is None:
            self.process.terminate()
        _, errors = self.process.communicate(timeout=10)
        return self.process.returncode, errors

    def truth(self) -> list[dict[str, Any]]:
        text = self.truth_file.read_text()
        return [json.loads(line) for line in text.splitlines() if line.endswith("}")]

    def events(self, name: str) -> list[dict[str, Any]]:
        return [line for line in self.truth() if line.get("event") == name]

    def await_event(self, name: str, timeout_s: float = 5.0) -> dict[str, Any]:
        deadline_s = time.monotonic() + timeout_s
        while time.monotonic() < deadline_s:
            found = self.events(name)
            if found:
                return found[-1]
            time.sleep(0.01)
        raise AssertionError(f"no event {name}")


class Link:
    """A plain connection to a gateway."""

    def __init__(self, address: tuple[str, int]) -> None:
        self.socket = socket.create_connection(address, timeout=5)
        self._file = self.socket.makefile("rb")

    def __enter__(self) -> "Link":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        self._file.close()
        self.socket.close()

    def send(self, *texts: str) -> None:
        self.socket.sendall("".join(f"{text}\n" for text in texts).encode())

    def lines(self) -> Iterator[Line]:
        for raw in self._file:
            yield parse(raw.rstrip(b"\n"))

    def until(self, word: str) -> Line:
        """The next line with this word. The socket's timeout is the deadline."""
        for line in self.lines():
            if line.word == word:
                return line
        raise AssertionError(f"closed before {word}")
