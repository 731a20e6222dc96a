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

"""A client of a page that reads what is sent and renders nothing, in a process of its own."""

from __future__ import annotations

import sys
import time
from pathlib import Path

import viser
from websockets.sync.client import connect
from websockets.typing import Subprotocol

from uav_tracking_mpc.report.atomic_write import write_atomically

TOLD_PERIOD = 0.2  # s between writes of the count


def main() -> int:
    """Read until SIGTERM; how many messages came goes into the second file that is named."""
    address, told = (Path(argument) for argument in sys.argv[1:])
    page = address.read_text(encoding="utf-8").replace("http", "ws", 1)
    count, due = 0, 0.0
    # viser takes clients of its own version alone.
    spoken = [Subprotocol(f"viser-v{viser.__version__}")]
    with connect(page, subprotocols=spoken, max_size=None, compression=None) as connection:
        for _ in connection:
            count += 1
            if (now := time.monotonic()) >= due:
                due = now + TOLD_PERIOD
                write_atomically(told, str(count).encode())
    return 0


if __name__ == "__main__":
    sys.exit(main())
