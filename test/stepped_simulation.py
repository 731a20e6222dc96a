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

"""A watched simulation without its thread, as fast as it goes, by a wall clock of the test."""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor

from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.view.simulated_source import SimulatedFlight
from uav_tracking_mpc.view.watched_flight import PlayClock

LONG_ENOUGH = "nmpc_controller.solve_time_max=5.0"  # s: a loaded machine flies the same


class SteppedSimulation:
    """``small_uav``, unless other overrides say so, at the speed of its wall clock."""

    def __init__(self, *overrides, scenario=None):
        settings = [LONG_ENOUGH, "mission.speed=1.0", *overrides]
        configuration = load_configuration("small_uav", settings, scenario)
        self.wall = 0.0
        self.flight = SimulatedFlight(configuration, PlayClock(0.0, math.inf, lambda: self.wall))
        self.loop, self.steering = self.flight.loop, self.flight.steering

    def wait(self, seconds):
        """Let wall time pass."""
        end = self.wall + seconds
        while self.wall < end:
            wait = self.flight.advance()
            self.wall = min(self.wall + wait + 1e-9, end)
        self.flight.advance()

    def fly(self, seconds):
        """Sights of each tick of the next seconds of simulated time."""
        end, sights = self.loop.time + seconds, []
        while self.loop.time < end - 1e-6:
            before = self.loop.time
            self.wall += max(self.flight.advance(), 0.0) + 1e-9
            if self.loop.time > before:
                sights.append(self.flight.sight)
        return sights

    def ask(self, request, *arguments, **values):
        """The answer to a request of another thread, while this one serves."""
        with ThreadPoolExecutor(1) as pool:
            answer = pool.submit(request, *arguments, **values)
            while not answer.done():
                self.flight.requests.serve(0.01)
            return answer.result()
