# Copyright 2026 uav_tracking_mpc maintainers
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""A node as a process that cannot outlive its launcher."""

from __future__ import annotations

import ctypes
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Sequence

from rich.console import Console

STOP_LIMIT = 5.0  # s of wall time for a node to end after a signal


class NodeProcess:
    """One node as a process; its output is printed line by line behind its name.

    Args:
        name: By which its output is marked.
        module: Full name of its Python module.
        arguments: Its command line.
        console: Where its output goes.

    Attributes:
        name: By which its output is marked.
        started: When it was started, by the steady clock [s].
    """

    def __init__(self, name: str, module: str, arguments: Sequence[str], console: Console) -> None:
        self.name = name
        self.started = time.monotonic()
        self._process = subprocess.Popen(
            [sys.executable, "-u", "-m", module, *arguments],
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
            # The loggers of ROS tell the name again.
            words = line.rstrip().replace(f" [{self.name}]:", ":", 1)
            console.print(f"[{self.name}] {words}", markup=False, highlight=False, soft_wrap=True)

    @property
    def identity(self) -> int:
        """Process id."""
        return self._process.pid

    @property
    def exit_code(self) -> int | None:
        """None while it runs."""
        return self._process.poll()

    def send_signal(self, number: int) -> None:
        """Send a signal, if the process still runs.

        Args:
            number: Of the signal.
        """
        if self.exit_code is None:
            self._process.send_signal(number)

    def stop(self, number: int) -> None:
        """End the process: by a signal, and by force if that takes longer than STOP_LIMIT.

        Args:
            number: Of the signal.
        """
        self.send_signal(number)
        try:
            self._process.wait(STOP_LIMIT)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._reader.join(STOP_LIMIT)


def _end_with_parent() -> None:
    """In the child: ask Linux for SIGTERM when the launcher dies, whatever ended it."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(1, signal.SIGTERM)  # PR_SET_PDEATHSIG
