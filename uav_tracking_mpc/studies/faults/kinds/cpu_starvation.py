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

"""Busy processes on every core."""

from __future__ import annotations

import os
import subprocess
import sys

from uav_tracking_mpc.studies.faults.injected_flight import Flight
from uav_tracking_mpc.studies.faults.kinds import Fault

PER_CORE = 2
# Ends by itself, for nobody ends it when the campaign itself is killed.
BUSY = "import time\nend = time.monotonic() + 10.0\nwhile time.monotonic() < end: pass"


class CpuStarvation(Fault):
    """Starts two busy processes for every core and ends them."""

    name = "cpu_starvation"
    family = "process"
    duration = (0.5, 2.0)
    wall_time = True

    def begin(self, flight: Flight, seconds: float, seed: int) -> None:
        """See :meth:`Fault.begin`."""
        program = [sys.executable, "-S", "-c", BUSY]
        self._busy = [
            subprocess.Popen(program, stdin=subprocess.DEVNULL)
            for _ in range(PER_CORE * (os.cpu_count() or 1))
        ]

    def end(self, flight: Flight) -> None:
        """See :meth:`Fault.end`."""
        for process in self._busy:
            process.kill()
            process.wait()
