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

"""A page of what is flown now, in a process of its own, as ``uav_tracking view`` serves it."""

from __future__ import annotations

import signal
import sys
import threading
from pathlib import Path

from uav_tracking_mpc.report.atomic_write import write_atomically
from uav_tracking_mpc.view.live.live_source import LiveSource
from uav_tracking_mpc.view.page import Page


def main() -> int:
    """Serve until SIGTERM; the page's address goes into the file that is named."""
    ended = threading.Event()
    signal.signal(signal.SIGTERM, lambda number, frame: ended.set())
    page = Page(LiveSource())
    write_atomically(Path(sys.argv[1]), page.address.encode())
    try:
        page.serve(ended.is_set)
    finally:
        page.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
