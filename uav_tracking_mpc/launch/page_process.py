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

"""The page of a flight as a process of its own, so that it costs the flight nothing."""

from __future__ import annotations

import signal
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress

from rich.console import Console

from uav_tracking_mpc.launch.node_process import NodeProcess
from uav_tracking_mpc.launch.shared_memory import SharedMemoryFiles

MODULE = "uav_tracking_mpc.cli.main"
LOOK_PERIOD = 0.2  # s


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
