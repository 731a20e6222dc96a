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

"""Processes that cannot outlive their launcher: a node, the page, a simulated autopilot."""

from __future__ import annotations

import contextlib
import ctypes
import os
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from rich.console import Console

from uav_tracking_mpc.settings.configuration import Configuration

FOLDER = Path("/dev/shm")


class SharedMemoryFiles:
    """Remembers which files a group of processes maps, and removes them when nobody does.

    On systems without /proc and /dev/shm it does nothing.
    """

    def __init__(self) -> None:
        self._seen: set[Path] = set()

    def note(self, processes: Iterable[int]) -> None:
        """Remember the files that processes map now.

        Args:
            processes: Their process ids.
        """
        for process in processes:
            self._seen |= _mapped(Path(f"/proc/{process}"))

    def remove_orphans(self) -> None:
        """Remove every remembered file that no other living process maps.

        This process itself is done with them, though Fast DDS keeps some open until it ends.
        """
        for process in Path("/proc").glob("[0-9]*"):
            if process.name != str(os.getpid()):
                self._seen -= _mapped(process)
        for file in self._seen:
            # Its lock and its semaphore are never mapped: they go with the file that they guard.
            for name in (file.name, f"{file.name}_el", f"sem.{file.name}_mutex"):
                with contextlib.suppress(OSError):
                    (FOLDER / name).unlink()
        self._seen.clear()


def _mapped(process: Path) -> set[Path]:
    try:
        lines = (process / "maps").read_text(errors="replace").splitlines()
    except OSError:  # it has ended, or belongs to somebody else
        return set()
    names = {line.rpartition(" ")[2] for line in lines if f" {FOLDER}/" in line}
    return {Path(name) for name in names if "fastrtps" in name}


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


MODULE = "uav_tracking_mpc.cli.main"
LOOK_PERIOD = 0.2  # s between looks at whether the process lives


class PageProcess:
    """A page that is served by a process.

    Nobody waits for it, and its death ends no flight.

    Args:
        domain: ROS domain that is shown.
        arguments: More of ``uav_tracking view``.
        console: Where its output goes, its address among it.
    """

    def __init__(self, domain: int, arguments: Sequence[str], console: Console) -> None:
        words = ["view", "--domain-id", str(domain), *arguments]
        self._process, self._console = NodeProcess("page", MODULE, words, console), console

    def stay(self) -> None:
        """Wait until Ctrl-C, or until it has ended."""
        if self._process.exit_code is not None:
            return
        self._console.print("the page shows the end of the flight until Ctrl-C", highlight=False)
        with suppress(KeyboardInterrupt):
            while self._process.exit_code is None:
                time.sleep(LOOK_PERIOD)

    def end(self) -> None:
        """End it, and remove what it leaves behind."""
        files = SharedMemoryFiles()
        files.note([self._process.identity])
        self._process.stop(signal.SIGTERM)
        files.remove_orphans()


@contextmanager
def page_process(domain: int, arguments: Sequence[str], console: Console) -> Iterator[PageProcess]:
    """Serve a page while the context lasts.

    Args:
        domain: ROS domain that is shown.
        arguments: More of ``uav_tracking view``.
        console: Where its output goes.

    Yields:
        The process.
    """
    page = PageProcess(domain, arguments, console)
    try:
        yield page
    finally:
        page.end()


@contextmanager
def autopilot_process(configuration: Configuration, console: Console) -> Iterator[str]:
    """Fly a simulated autopilot of the link's kind while the context lasts.

    Args:
        configuration: Its section ``uav_simulator`` is what flies, ``autopilot_link`` says how the
            autopilot behaves.
        console: Where its output goes.

    Yields:
        The connection at which the link finds it.
    """
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        place = f"127.0.0.1:{free.getsockname()[1]}"
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / f"{configuration.name}.yaml"
        file.write_text(configuration.yaml(), encoding="utf-8")
        arguments = ["autopilot", "--dialect", configuration.link.link]
        arguments += ["--config", str(file), "--connection", f"udpout:{place}"]
        if configuration.link.origin:
            # One word: South of the equator two would look like an option.
            arguments.append("--origin=" + ",".join(map(str, configuration.link.origin)))
        process = NodeProcess("autopilot", MODULE, arguments, console)
        try:
            yield f"udpin:{place}"
        finally:
            process.stop(signal.SIGTERM)
