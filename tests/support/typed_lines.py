#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""typed_lines.py RC: for each line of stdin types it into a bash, where \t is Tab, and prints the words that came of it."""
import os, pty, select, sys, time


def read_until(fd, mark, patience=20):
    seen, end = b"", time.monotonic() + patience
    while mark not in seen and time.monotonic() < end:
        if select.select([fd], [], [], 0.1)[0]:
            seen += os.read(fd, 65536)
    return seen


def typed(rc, line):
    pid, fd = pty.fork()
    if pid == 0:
        os.environ.update(TERM="dumb", INPUTRC="/dev/null")
        os.execvp("bash", ["bash", "--noprofile", "--rcfile", rc, "-i"])
    read_until(fd, b"ready> ")
    parts = line.split("\\t")
    for part in parts[:-1]:
        os.write(fd, part.encode() + b"\t")
    os.write(fd, parts[-1].encode() + b"\x01words \n")  # from the beginning of the line: words of `words`
    out = read_until(fd, b"<end>").decode(errors="replace").replace("\r", "")
    os.close(fd)
    os.waitpid(pid, 0)
    return out[out.index("<begin>"):out.index("<end>")].split("\n")[1:-1]


for line in sys.stdin:
    print(" | ".join(typed(sys.argv[1], line.rstrip("\n"))))
