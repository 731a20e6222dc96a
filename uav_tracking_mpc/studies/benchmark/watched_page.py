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

"""Processes beside timed nodes: a page, and a client that reads it and renders nothing."""

from __future__ import annotations

import signal
import sys
import threading
import time
from pathlib import Path

from uav_tracking_mpc.report.atomic_write import write_atomically

COUNT_PERIOD = 0.2  # s between writes of the count


def serve(address: Path) -> None:
    """Serve until SIGTERM.

    Args:
        address: File that the page's address is written to.
    """
    from uav_tracking_mpc.view.live_source import LiveSource
    from uav_tracking_mpc.view.page import Page

    ended = threading.Event()
    signal.signal(signal.SIGTERM, lambda number, frame: ended.set())
    page = Page(LiveSource())
    write_atomically(address, page.address.encode())
    try:
        page.serve(ended.is_set)
    finally:
        page.close()


def read(address: Path, counted: Path) -> None:
    """Read until SIGTERM.

    Args:
        address: File that holds the page's address.
        counted: File that the number of messages is written to.
    """
    import viser
    from websockets.sync.client import connect
    from websockets.typing import Subprotocol

    page = address.read_text(encoding="utf-8").replace("http", "ws", 1)
    count, due = 0, 0.0
    # viser takes clients of its own version alone.
    spoken = [Subprotocol(f"viser-v{viser.__version__}")]
    with connect(page, subprotocols=spoken, max_size=None, compression=None) as connection:
        for _ in connection:
            count += 1
            if (now := time.monotonic()) >= due:
                due = now + COUNT_PERIOD
                write_atomically(counted, str(count).encode())


if __name__ == "__main__":
    if sys.argv[1] == "page":
        serve(Path(sys.argv[2]))
    else:
        read(Path(sys.argv[2]), Path(sys.argv[3]))
