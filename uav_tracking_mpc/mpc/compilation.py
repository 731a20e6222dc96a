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

"""A compilation under way in a process of its own, which can be waited for and given up."""

from __future__ import annotations

import logging
import os
import subprocess
import sys
import tempfile
import threading
import time
from concurrent.futures import Future
from pathlib import Path

from uav_tracking_mpc.mpc import machine_code

logger = logging.getLogger(__name__)

POLL_PERIOD = 0.02  # s between looks while waiting
PATIENCE = 2.0  # s of waiting without a word
COURTESY = 10  # by which others go first where a flight goes on meanwhile, in steps of `nice`


class CompilationError(RuntimeError):
    """The solver cannot be compiled; the message says why."""


class Compilation:
    """The machine code of a folder, made by a child process.

    The child ends with this process, whatever ends it, and leaves nothing half-made: the next
    process that needs the machine code makes it.

    Args:
        folder: With the method's sources.
        aside: Let everything else on the machine go first.

    Attributes:
        folder: With the method's sources.
    """

    def __init__(self, folder: Path, aside: bool = False) -> None:
        self.folder = folder
        self._begin = time.monotonic()
        self._seconds: float | None = None
        command = [sys.executable, "-m", machine_code.__name__, str(folder), str(os.getpid())]
        if aside and sys.platform == "linux":
            command = ["nice", "-n", str(COURTESY), *command]
        self._given_up = False
        self._child: subprocess.Popen[bytes] | None = None
        if machine_code.finished(folder):
            self._seconds = 0.0
            return
        # A file, not a pipe: a child that writes more than a pipe holds would wait for a reader.
        self._words = tempfile.TemporaryFile("w+", errors="replace")  # noqa: SIM115
        started: Future[subprocess.Popen[bytes]] = Future()
        threading.Thread(target=self._run, args=(command, started), daemon=True).start()
        self._child = started.result()

    def _run(self, command: list[str], started: Future[subprocess.Popen[bytes]]) -> None:
        """Start the child and outlive it: Linux ends a child with the thread that started it."""
        try:
            child = subprocess.Popen(
                command,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=self._words,
                env={**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
                start_new_session=True,  # Ctrl-C reaches this process alone, which ends the child
            )
        except BaseException as error:  # raised where the child was asked for
            started.set_exception(error)
            return
        started.set_result(child)
        child.wait()

    @property
    def seconds(self) -> float:
        """How long it has taken in [s]: until now, or until it was seen to be done."""
        return time.monotonic() - self._begin if self._seconds is None else self._seconds

    def done(self) -> bool:
        """Whether the machine code is there; returns at once.

        Raises:
            CompilationError: The child failed, or it was given up.
        """
        if self._given_up:
            raise CompilationError("the compilation was given up")
        if self._child is None or self._seconds is not None:
            return True
        if self._child.poll() is None:
            return False
        self._seconds = self.seconds
        if not machine_code.finished(self.folder):
            self._words.seek(0)
            last = (
                self._words.read().strip().splitlines() or [f"exit code {self._child.returncode}"]
            )[-1]
            raise CompilationError(f"the solver could not be compiled in {self.folder}: {last}")
        return True

    def wait(self) -> None:
        """Return when the machine code is there; a signal interrupts at once.

        Raises:
            CompilationError: The child failed, or this process is about to end.
        """
        # Nobody is held up by a thread that waits beside the main one.
        told = threading.current_thread() is not threading.main_thread()
        silent = told
        try:
            while not self.done():
                time.sleep(POLL_PERIOD)
                if not told and self.seconds > PATIENCE:
                    told = True
                    logger.info(
                        "compiling the solver for this problem, once; kept in %s", self.folder
                    )
                if not threading.main_thread().is_alive():
                    raise CompilationError("the program ends before the solver is compiled")
        finally:
            self.close()
        if told and not silent:
            logger.info("solver compiled in %.1f s", self.seconds)

    def close(self) -> None:
        """Give it up, unless it is done."""
        if self._child is not None and self._child.poll() is None:
            self._given_up = True
            self._child.kill()
            self._child.wait()
