"""A node as a process that cannot outlive its launcher."""

from __future__ import annotations

import ctypes
import signal
import subprocess
import sys
import threading
from collections.abc import Sequence

from rich.console import Console

STOP_LIMIT = 5.0  # s of wall time for a node to end after a signal


class NodeProcess:
    """One node as a process; its output is printed line by line behind its name.

    Args:
        name: Its module.
        arguments: Its command line.
        console: Where its output goes.
        room: Package of the module.
    """

    def __init__(
        self, name: str, arguments: Sequence[str], console: Console, room: str = "nodes"
    ) -> None:
        self.name = name
        self._process = subprocess.Popen(
            [sys.executable, "-u", "-m", f"uav_tracking_mpc.{room}.{name}", *arguments],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
            # A session of its own: Ctrl-C reaches the launcher alone, which passes it on.
            start_new_session=True,
            preexec_fn=_end_with_parent,
        )
        self._reader = threading.Thread(target=self._print, args=(console,), daemon=True)
        self._reader.start()

    def _print(self, console: Console) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            console.print(
                f"[{self.name}] {line.rstrip()}", markup=False, highlight=False, soft_wrap=True
            )

    @property
    def identity(self) -> int:
        """Process id."""
        return self._process.pid

    @property
    def exit_code(self) -> int | None:
        """None while it runs."""
        return self._process.poll()

    def send_signal(self, number: int) -> None:
        """Pass a signal on, if it still runs."""
        if self.exit_code is None:
            self._process.send_signal(number)

    def stop(self, number: int) -> None:
        """End it: by the signal, and by force if that takes too long."""
        self.send_signal(number)
        try:
            self._process.wait(STOP_LIMIT)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._reader.join(STOP_LIMIT)


def _end_with_parent() -> None:
    """In the child: ask Linux for SIGTERM when the launcher dies, however it dies."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(1, signal.SIGTERM)  # PR_SET_PDEATHSIG
