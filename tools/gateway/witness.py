# SPDX-License-Identifier: Apache-2.0
"""What a test may want to know about the link. A real gateway uses this class, which does
nothing."""

from __future__ import annotations


class Witness:
    """The link thread calls it, so no call may block."""

    def connection(self, opened: bool) -> None:
        """A connection was opened or closed."""

    def session(self, kind: str) -> None:
        """A session of this kind (none, command, observer) begins."""

    def received_bytes(self, count: int) -> None:
        """Bytes arrived in the present session."""

    def received_line(self, word: str, command: int | None, text: str) -> None:
        """A valid line arrived; word is empty for a malformed one."""
