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

"""Pages to look at: in a thread of the test, whose source it then holds, or in a process.

``served(source)`` serves any source in this process, so that the test can turn its clock or ask its
flights; ``PageProcess`` serves a log in a process of its own, which can die and come back::

    with served(LoggedSource(log, tracking)) as (page, source): ...   # page.address
    process = PageProcess(pickled, port=0)
    process.kill(); process = PageProcess(pickled, process.port)
"""

from __future__ import annotations

import contextlib
import pickle
import subprocess
import sys
import threading
from pathlib import Path
from urllib.parse import urlsplit

PATIENCE = 120.0  # s: a limit for what is broken, not a measure of what works


@contextlib.contextmanager
def served(source, host=None):
    """A page of a source, drawn by a thread; both are closed at the end."""
    from uav_tracking_mpc.view.page import Page

    page, ended = Page(source, host, 0), threading.Event()
    thread = threading.Thread(target=page.serve, args=(ended.is_set,), daemon=True)
    thread.start()
    try:
        yield page
    finally:
        ended.set()
        thread.join(PATIENCE)
        page.close()


def save_flight(log, tracking, path):
    """Write a flight for :class:`PageProcess`."""
    path.write_bytes(pickle.dumps((log, tracking)))
    return path


class PageProcess:
    """A logged flight, played again and again, in a process of its own."""

    def __init__(self, flight: Path, port: int = 0) -> None:
        self._process = subprocess.Popen(
            [sys.executable, __file__, str(flight), str(port)], stdout=subprocess.PIPE, text=True
        )
        assert self._process.stdout is not None
        self.address = self._process.stdout.readline().strip()
        assert self.address.startswith("http://"), "the page's process did not start"
        self.port = urlsplit(self.address).port

    def kill(self) -> None:
        """As a crash or the loss of power would."""
        self._process.kill()
        self._process.wait()

    def __enter__(self) -> PageProcess:
        return self

    def __exit__(self, *_: object) -> None:
        self.kill()


def _main(flight: str, port: str) -> None:
    from uav_tracking_mpc.view.page import Page
    from uav_tracking_mpc.view.recorded.logged_flight import LoggedSource

    source = LoggedSource(*pickle.loads(Path(flight).read_bytes()))
    page = Page(source, None, int(port))

    def play_on() -> bool:
        if not source.clock.playing:
            source.clock.play()
        return False

    print(page.address, flush=True)
    page.serve(play_on)


if __name__ == "__main__":
    _main(*sys.argv[1:])
