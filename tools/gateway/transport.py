# SPDX-License-Identifier: Apache-2.0
"""Bytes over TCP or a serial line (docs/frame-link.md, section 1), never blocking."""

from __future__ import annotations

import errno
import os
import socket
import termios
from typing import Protocol

READ_BYTES = 16384
_GONE = (errno.EIO, errno.ENXIO, errno.ENODEV, errno.ENOENT, errno.EBADF)


class Channel(Protocol):
    """One connection. read() and write() raise OSError when it is broken."""

    def fileno(self) -> int: ...

    def read(self) -> bytes | None:
        """What has arrived; b"" at the end of the connection, None if there is nothing yet."""

    def write(self, data: bytes) -> int:
        """The number of bytes taken, 0 if there is no room."""

    def close(self) -> None: ...


class Port(Protocol):
    """Where connections come from."""

    address: str
    restarted: bool  # a line that existed before this program: we send HELLO unasked

    def fileno(self) -> int | None:
        """Readable when accept() has a connection. None: call accept() once a second instead."""

    def accept(self) -> Channel | None: ...

    def close(self) -> None: ...


class TcpChannel:
    def __init__(self, connection: socket.socket) -> None:
        connection.setblocking(False)
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._socket = connection

    def fileno(self) -> int:
        return self._socket.fileno()

    def read(self) -> bytes | None:
        try:
            return self._socket.recv(READ_BYTES)
        except BlockingIOError:
            return None

    def write(self, data: bytes) -> int:
        try:
            return self._socket.send(data)
        except BlockingIOError:
            return 0

    def close(self) -> None:
        self._socket.close()


class TcpPort:
    restarted = False  # a new connection is no sign of a restart

    def __init__(self, host: str, port: int) -> None:
        family = socket.AF_INET6 if ":" in host else socket.AF_INET
        self._socket = socket.create_server((host, port), family=family, backlog=4)
        self._socket.setblocking(False)
        shown = f"[{host}]" if ":" in host else host
        self.address = f"tcp://{shown}:{self._socket.getsockname()[1]}"

    def fileno(self) -> int | None:
        return self._socket.fileno()

    def accept(self) -> TcpChannel | None:
        try:
            return TcpChannel(self._socket.accept()[0])
        except OSError:  # the peer has already gone
            return None

    def close(self) -> None:
        self._socket.close()


class SerialChannel:
    def __init__(self, descriptor: int) -> None:
        self._descriptor = descriptor

    def fileno(self) -> int:
        return self._descriptor

    def read(self) -> bytes | None:
        try:
            return os.read(self._descriptor, READ_BYTES)
        except BlockingIOError:
            return None

    def write(self, data: bytes) -> int:
        try:
            return os.write(self._descriptor, data)
        except BlockingIOError:
            return 0

    def close(self) -> None:
        os.close(self._descriptor)


class SerialPort:
    """115200 8N1, no flow control. A port that vanished (USB) is opened again when it comes
    back."""

    restarted = True

    def __init__(self, path: str, baud: int = 115200) -> None:
        self._path = path
        self._speed = getattr(termios, f"B{baud}")
        self.address = f"serial:{path}"

    def fileno(self) -> int | None:
        return None

    def accept(self) -> SerialChannel | None:
        try:
            descriptor = os.open(self._path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        except OSError as error:
            if error.errno in _GONE:
                return None
            raise
        try:
            _set_raw(descriptor, self._speed)
        except termios.error:
            os.close(descriptor)
            return None
        return SerialChannel(descriptor)

    def close(self) -> None:
        pass


def _set_raw(descriptor: int, speed: int) -> None:
    mode = termios.tcgetattr(descriptor)
    mode[0] = termios.IGNBRK  # iflag
    mode[1] = 0  # oflag
    mode[2] = termios.CS8 | termios.CREAD | termios.CLOCAL  # cflag
    mode[3] = 0  # lflag
    mode[4] = mode[5] = speed
    mode[6][termios.VMIN], mode[6][termios.VTIME] = 1, 0
    termios.tcsetattr(descriptor, termios.TCSANOW, mode)
    termios.tcflush(descriptor, termios.TCIOFLUSH)
