# SPDX-License-Identifier: Apache-2.0
import sys
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import json
import os
import select
import socket
import subprocess
import threading
import time

from gateway.protocol import parse
from gateway.server import Server
from gateway.tests.support import PROGRAM, FakeMachine, Gateway, Link
from gateway.transport import SerialPort, TcpPort

HELLO = "HELLO proto=1 revision=2 side=host"


class Blocked(FakeMachine):
    """Hangs in every command until it is released, and tells when it was stopped."""

    def __init__(self) -> None:
        super().__init__()
        self.go = threading.Event()
        self.hangs = threading.Event()
        self.stopped = threading.Event()

    def refresh(self) -> None:
        self.hangs.set()
        self.go.wait(10)

    def stop(self) -> None:
        self.stopped.set()


class Running:
    """A server in a thread, with a fake machine."""

    def __init__(self, machine: FakeMachine) -> None:
        self.port = TcpPort("127.0.0.1", 0)
        self.server = Server(self.port, machine)
        self._thread = threading.Thread(target=self.server.run)
        self._thread.start()

    def link(self) -> Link:
        return Link(("127.0.0.1", int(self.port.address.rsplit(":", 1)[1])))

    def __enter__(self) -> "Running":
        return self

    def __exit__(self, *_: object) -> None:
        self.server.end()
        self._thread.join(10)


class Paths(unittest.TestCase):
    """Section 7, number 2: nothing delays STOP, silence or the end of a connection."""

    def hanging(self, machine: Blocked, link: Link) -> None:
        link.send(HELLO)
        link.until("CAPS")
        link.send("#1 STATUS")
        self.assertTrue(machine.hangs.wait(5))
        machine.stopped.clear()

    def test_stop_passes_a_command_that_hangs(self) -> None:
        machine = Blocked()
        with Running(machine) as running, running.link() as link:
            self.hanging(machine, link)
            link.send("STOP")
            self.assertTrue(machine.stopped.wait(5))
            link.until("STOPPED")
            machine.go.set()
            self.assertEqual(link.until("OK").command, 1)

    def test_silence_passes_a_command_that_hangs(self) -> None:
        machine = Blocked()
        with Running(machine) as running, running.link() as link:
            self.hanging(machine, link)
            self.assertTrue(machine.stopped.wait(5))
            self.assertEqual(link.until("EVENT").fields["kind"], "watchdog")
            machine.go.set()

    def test_the_end_of_a_connection_passes_a_command_that_hangs(self) -> None:
        machine = Blocked()
        with Running(machine) as running:
            with running.link() as link:
                self.hanging(machine, link)
            self.assertTrue(machine.stopped.wait(5))
            machine.go.set()


class Connections(unittest.TestCase):
    def test_one_daemon_at_a_time(self) -> None:
        with Running(FakeMachine()) as running, running.link() as first:
            first.send(HELLO)
            first.until("CAPS")
            with running.link() as second:
                self.assertEqual(second.until("EVENT").fields["kind"], "busy")
                self.assertEqual(list(second.lines()), [])
            first.send("#1 STATUS")
            first.until("OK")

    def test_a_dead_connection_does_not_lock_out_the_next(self) -> None:
        machine = FakeMachine()
        with Running(machine) as running, running.link() as first:
            first.send(HELLO)
            while first.until("EVENT").fields["kind"] != "watchdog":
                pass
            with running.link() as second:
                second.send(HELLO)
                second.until("CAPS")
            self.assertTrue(all(line.word == "HB" for line in first.lines()))

    def test_a_daemon_may_come_back_at_once(self) -> None:
        with Running(FakeMachine()) as running:
            for _ in range(50):
                with running.link() as link:
                    link.send(HELLO)
                    link.until("CAPS")
                    link.send("HB")

    def test_lines_in_pieces_and_many_at_once(self) -> None:
        with Running(FakeMachine()) as running, running.link() as link:
            for byte in f"{HELLO}\n".encode():
                link.socket.sendall(bytes([byte]))
            link.until("CAPS")
            link.send(*[f"#{n} STATUS" for n in range(1, 50)])
            self.assertEqual([link.until("OK").command for _ in range(49)], list(range(1, 50)))

    def test_who_does_not_read_is_hung_up_on_in_the_end(self) -> None:
        machine = Blocked()
        machine.go.set()
        with Running(machine) as running, running.link() as link:
            link.send(HELLO)
            machine.stopped.clear()
            deadline_s = time.monotonic() + 10
            while not machine.stopped.is_set() and time.monotonic() < deadline_s:
                try:
                    link.send(*["#0 X"] * 50, *["STOP"] * 2000)
                except OSError:
                    break
            self.assertTrue(machine.stopped.is_set())


class Serial(unittest.TestCase):
    def test_hello_by_itself_then_a_session_and_back_after_a_hang_up(self) -> None:
        ours, theirs = os.openpty()
        port = SerialPort(os.ttyname(theirs))
        server = Server(port, FakeMachine())
        thread = threading.Thread(target=server.run)
        thread.start()
        try:
            self.assertEqual(parse(self._line(ours)).word, "HELLO")
            os.write(ours, f"{HELLO}\r\n".encode())
            self.assertEqual([parse(self._line(ours)).word for _ in range(2)], ["HELLO", "CAPS"])
            os.write(ours, b"STOP\n")
            self.assertEqual(parse(self._line(ours)).word, "STOPPED")
        finally:
            server.end()
            thread.join(10)
            os.close(ours)
            os.close(theirs)

    def _line(self, descriptor: int) -> bytes:
        line = b""
        while not line.endswith(b"\n"):
            self.assertTrue(select.select([descriptor], [], [], 5)[0], "nothing came")
            line += os.read(descriptor, 1)
        return line.rstrip(b"\n")


class Program(unittest.TestCase):
    def test_a_session_against_the_simulated_machine_and_its_witness(self) -> None:
        with Gateway(start_travel_mm=19.9, answer_delay_s=0.05) as gateway:
            with Link(gateway.address()) as link:
                link.send(HELLO, "#1 RATE hz=100", "#2 LIMITS force_min_N=-1 force_max_N=2 "
                          "travel_min_mm=5 travel_max_mm=25 speed_max_mm_s=1",
                          "#3 MOVEF force_N=0.5 speed_mm_s=0.5 guard_mm=22")
                done = link.until("DONE")
                self.assertEqual((done.command, done.fields["reason"]), (3, "target"))
                link.send("#4 MOVE travel_mm=5 speed_mm_s=1")
                link.until("OK")
                link.send("STOP")
                self.assertEqual(link.until("DONE").fields["reason"], "stop")
                link.until("STOPPED")
            stop = gateway.await_event("force_stop")
            self.assertTrue(stop["threshold_N"] == 0.5 and stop["reaction_s"] <= 0.01)
            gateway.await_event("connection_closed")
            code, errors = gateway.end()
            self.assertEqual((code, errors), (0, ""))
            summary = gateway.truth()[-1]
            self._check_stop(gateway)
        self.assertEqual(summary["event"], "summary")
        self.assertEqual((summary["stops"], summary["hellos"], summary["commands"], summary["motions"]),
                         (1, 1, 4, 2))
        self.assertIs(summary["moved_after_last_stop"], False)
        self.assertEqual((summary["bytes_none"], summary["bytes_observer"]), (0, 0))
        self.assertGreater(summary["bytes_command"], 200)
        self.assertAlmostEqual(summary["peak_force_N"], 0.5, delta=0.1)

    def _check_stop(self, gateway: Gateway) -> None:
        """Uses the times of the witness, which do not depend on the load of the computer."""
        received_s = gateway.events("stop_received")[0]["t_s"]
        begun_s = next(e["t_s"] for e in gateway.events("stop_begun") if e["t_s"] >= received_s)
        self.assertLess(begun_s - received_s, 0.02)

    def test_a_closed_connection_stops_and_an_observer_does_not(self) -> None:
        with Gateway() as gateway:
            with socket.create_connection(gateway.address("panel"), timeout=5) as panel:
                panel.sendall(b"MOVE travel_mm=19 speed_mm_s=0.5\n")
                self.assertEqual(panel.makefile().readline(), "OK\n")
            gateway.await_event("motion_begin")
            with Link(gateway.address()) as link:
                link.send("OBSERVE proto=1 hz=100")
                self.assertEqual(link.until("S").fields["flags"], "M")
            gateway.await_event("connection_closed")
            with Link(gateway.address()) as link:
                link.send("OBSERVE proto=1 hz=100")
                self.assertEqual(link.until("S").fields["flags"], "M")
                self.assertEqual(gateway.events("stop_begun"), [])
                link.send(HELLO)
                link.until("CAPS")
            gateway.await_event("standing")
            with socket.create_connection(gateway.address("panel"), timeout=5) as panel:
                panel.sendall(b"DANCE\n")
                self.assertIn("the panel knows", panel.makefile().readline())

    def test_usage_errors_say_what_to_do(self) -> None:
        for options, text in ((["--set", "stifness_N_mm=5"], "did you mean"),
                              (["--rig", "/nonexistent"], "/nonexistent"),
                              (["--backend", "nothing:here"], "nothing"),
                              (["--backend", "builtins:repr"], "returned no")):
            done = subprocess.run(["/usr/bin/python3", str(PROGRAM), *options], capture_output=True,
                                  text=True, timeout=10)
            self.assertEqual((done.returncode, text in done.stderr), (2, True), done.stderr)

    def test_a_lie_is_warned_of(self) -> None:
        with Gateway(declared_reaction_s=0.0001) as gateway:
            self.assertTrue(gateway.ready)
            self.assertIn("declared_reaction_s", gateway.end()[1])

    def test_ready_file_and_module(self) -> None:
        with Gateway() as gateway:
            ready = Path(gateway.truth_file.parent, "ready.json")
            process = subprocess.Popen(
                ["/usr/bin/python3", "-m", "gateway", "--ready-file", str(ready), "--revision", "1"],
                cwd=PROGRAM.parents[1], stdout=subprocess.PIPE, text=True)
            assert process.stdout
            line = process.stdout.readline()
            self.assertEqual(json.loads(line), json.loads(ready.read_text()))
            process.terminate()
            process.communicate(timeout=10)
            self.assertEqual(process.returncode, 0)


if __name__ == "__main__":
    unittest.main()
