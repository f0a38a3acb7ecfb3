#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""doc_commands.py BIN FOLDER: runs the commands that stand in the fenced blocks of README.md and
docs/, page by page and in their order. A command that nobody thought of here fails the test, so that
a page cannot name one that was never tried."""

import json
import os
import re
import select
import shlex
import socket
import subprocess
import sys
from pathlib import Path

# Commands of other programs are not tried here, because they need root, systemd or a compiler.
OURS = re.compile(r"^(build/bin/|tools/gateway/)?(lcrig|lcrigd|lcrig-sim|lcrig-gateway|"
                  r"check_gateway\.py|sqlite3)( |$)")
TALKS_TO_DAEMON = re.compile(r"lcrig (run|status|watch|pause|resume|stop|abort|freeze|confirm|answer|"
                             r"queue|runs|lcr)( |$)")
# A run in real time takes a quarter of an hour. Its plan asks the same instruments instead.
REAL_TIME = re.compile(r"^lcrig run ")
# A correction takes long, too, and needs a person. correction_test.cpp makes one instead.
WITH_A_PERSON = re.compile(r"^lcrig lcr correct ")
YOURS = ("my_machine:",)  # a program that the reader writes
SERVERS = ("lcrig-sim", "lcrig-gateway")
PATIENCE_S = 30  # for a program that starts


def free_ports(count):
    """Nobody listens there now, and the system gives them to nobody else for a while."""
    sockets = [socket.create_server(("127.0.0.1", 0)) for _ in range(count)]
    ports = [str(s.getsockname()[1]) for s in sockets]
    for s in sockets:
        s.close()
    return ports


class Pages:
    def __init__(self, programs, folder):
        self.programs, self.folder = programs, folder
        self.port, self.panel_port = free_ports(2)  # instead of the pages' 4710 and 4711
        self.ran, self.failed, self.running = 0, [], []

    def commands(self, page):
        """The lines of blocks that are commands, and the exit status that the page gives. What a page
        shows by `cat` becomes a file."""
        fence, block = None, []
        for line in page.read_text(encoding="utf-8").splitlines():
            if not line.startswith("```"):
                block.append(line)
                continue
            if fence is None:
                fence, block = line[3:], []
                continue
            if fence == "":
                yield from self.in_block(block)
            fence = None

    def in_block(self, block):
        prompts = any(line.startswith("$ ") for line in block)
        for i, line in enumerate(block):
            if prompts and not line.startswith("$ "):
                continue
            line = line.removeprefix("$ ")
            if prompts and line.startswith("cat ") and line.endswith((".json", ".csv")):
                shown = []
                for more in block[i + 1:]:
                    if more.startswith("$ "):
                        break
                    shown.append(more)
                self.write(line.split()[1], "\n".join(shown))
            command = re.split(r"\s+#\s|\s+&$|\s+\.\.\.", line)[0].strip()
            if OURS.match(command):
                status = re.search(r"exit status (\d+)", line)
                yield command, int(status[1]) if status else 0

    def write(self, name, text):
        if not (self.folder / name).exists():
            (self.folder / name).write_text(text, encoding="utf-8")

    def keep_file(self, page):
        """The page's first JSON block is the file that its commands name."""
        names = {"faults": "night.json", "specimen-file": "my-stack.json", "bench-file": "my-bench.json"}
        if page.stem in names:
            block = re.search(r"```json\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL)
            self.write(names[page.stem], block[1])

    def words(self, command):
        words = shlex.split(command)
        name = words[0].rsplit("/", 1)[-1]
        if name.startswith("lcrig") and name != "lcrig-gateway":
            words[0] = str(self.programs / name)
        elif "gateway" in name:
            words[0] = str(Path("tools/gateway").resolve() / name)
        for i, word in enumerate(words[1:], 1):
            word = {"4710": self.port, "4711": self.panel_port}.get(word, word)
            words[i] = word.replace("/tmp/", f"{self.folder}/")
        if REAL_TIME.match(command):
            words.append("--dry-run")
        if WITH_A_PERSON.match(command):
            words.append("--help")
        if words[1:] == ["config", "check"]:  # checks the example that the page installed before
            words.append(str(Path("systemd/lcrigd.example.json").resolve()))
        if name == "lcrigd":
            words += ["--config", str(self.folder / "lcrigd.json")]
        return words

    def start(self, words, environment=None):
        """What it says after its first line goes nowhere: its log is on standard error."""
        log = open(self.folder / f"{Path(words[0]).name}.log", "w", encoding="utf-8")
        child = subprocess.Popen(words, cwd=self.folder, stdout=subprocess.PIPE, stderr=log,
                                 env=environment)
        self.running.append(child)
        return child

    def serve(self, words):
        """Reads the line in which a server says where it is; the text of what went wrong instead."""
        child = self.start(words)
        line = first_line(child.stdout)
        if line:
            return line, None
        log = self.folder / f"{Path(words[0]).name}.log"
        return None, f"no ready line in {PATIENCE_S} s: {log.read_text(encoding='utf-8')[-500:]}"

    def stop_servers(self):
        for child in reversed(self.running):
            child.terminate()
            child.wait(30)
        self.running = []

    def daemon(self):
        """lcrigd on the meter of lcrig-sim, and on the gateway's frame if that runs, else the sim's."""
        gateway = any("gateway" in str(child.args[0]) for child in self.running)
        line, wrong = self.serve([str(self.programs / "lcrig-sim")])
        if wrong:
            sys.exit(wrong)
        ports = json.loads(line)
        frame = f"tcp:127.0.0.1:{self.port}" if gateway else ports["frame"]
        config = {"format": "lcrigd-config/1", "database": str(self.folder / "daemon.db"),
                  "socket": str(self.folder / "c.sock"),
                  "meter": {"driver": "lcr6100", "port": ports["lcr"]},
                  "frame": {"driver": "zwick", "port": frame, "stiffness_N_mm": 25},
                  "fixture": {"probe_diameter_mm": 4.0}}
        (self.folder / "lcrigd.json").write_text(json.dumps(config), encoding="utf-8")
        # Makes a run that the commands can show.
        self.run([str(self.programs / "lcrig"), "rehearse", "preconditioning", "--specimen", "paper-1",
                  "--db", str(self.folder / "daemon.db")], "the first run")
        self.start_daemon([str(self.programs / "lcrigd"), "--config",
                           str(self.folder / "lcrigd.json")])

    def start_daemon(self, words):
        """It tells its service manager when it is ready."""
        with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as manager:
            path = str(self.folder / "n.sock")
            manager.bind(path)
            manager.settimeout(PATIENCE_S)
            self.start(words, dict(os.environ, NOTIFY_SOCKET=path))
            try:
                while b"READY=1" not in manager.recv(512):
                    pass
            except TimeoutError:
                sys.exit(f"lcrigd is not ready in {PATIENCE_S} s")
        os.unlink(path)

    def page(self, page):
        self.keep_file(page)
        for command, expected in self.commands(page):
            if any(yours in command for yours in YOURS):
                continue
            words = self.words(command)
            self.ran += 1
            if words[0].endswith("check_gateway.py"):  # the check of an honest gateway
                self.stop_servers()
                self.serve(self.words("lcrig-gateway --port 4710"))
            if Path(words[0]).name in SERVERS:
                self.stop_servers()
                _, wrong = self.serve(words)
                if wrong:
                    self.failed.append(f"{page}: {command}\n{wrong}")
                continue
            if words[0].endswith("lcrigd") or TALKS_TO_DAEMON.match(command):
                if not (self.folder / "c.sock").exists():
                    self.daemon()
            self.run(words, f"{page}: {command}", expected)
        self.stop_servers()

    def run(self, words, what, expected=0):
        environment = dict(os.environ, HOME=str(self.folder), XDG_DATA_HOME=str(self.folder),
                           LCRIG_SOCKET=str(self.folder / "c.sock"))
        database = self.folder / "daemon.db"
        if not database.exists():  # without a daemon, commands write only into a file that is named
            database = self.folder / "lcrig" / "lcrig.db"
            database.parent.mkdir(exist_ok=True)
        environment["LCRIG_DB"] = str(database)
        done = subprocess.run(words, cwd=self.folder, env=environment, capture_output=True, text=True,
                              timeout=240, check=False)
        if done.returncode != expected:
            self.failed.append(f"{what}\nexit {done.returncode}: {done.stdout[-300:]}{done.stderr[-600:]}")


def first_line(pipe):
    """None: nothing came in time."""
    ready, _, _ = select.select([pipe], [], [], PATIENCE_S)
    return pipe.readline() if ready else None


def main(programs, folder):
    pages = [Path("README.md"), *sorted(Path("docs").glob("*.md"))]
    ran, failed = 0, []
    for page in pages:
        scratch = Path(folder) / page.stem
        scratch.mkdir(parents=True)
        one = Pages(Path(programs).resolve(), scratch)
        try:
            one.page(page)
        finally:
            one.stop_servers()
        ran, failed = ran + one.ran, failed + one.failed
    print(f"{ran} commands, {len(failed)} failed")
    if failed:
        sys.exit("\n".join(failed))


if __name__ == "__main__":
    main(*sys.argv[1:])
