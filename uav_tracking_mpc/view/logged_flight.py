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

"""A flight from its log, as it is after a simulation or a flight."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.dynamics.orbit import Orbit, orbit_about
from uav_tracking_mpc.dynamics.vehicle import velocity
from uav_tracking_mpc.nodes.messages.named_figures import ERRORS
from uav_tracking_mpc.settings.tracking import TrackingParameters
from uav_tracking_mpc.simulation.flight_log import FlightLog
from uav_tracking_mpc.view.watched_flight import (
    PAST_PERIOD,
    FlightSource,
    PlayClock,
    Sight,
    TargetSight,
    WatchedFlight,
)

KEPT = 1024  # sights that are not made again: a track asks for the same ones at each frame
SAME = 1e-6  # s by which a time may miss its sample


class LoggedFlight(WatchedFlight):
    """Shows what a log holds at the time of a clock.

    Args:
        log: Record of the flight.
        tracking: What its controller flew by.
        clock: What time it is in the record.
    """

    def __init__(self, log: FlightLog, tracking: TrackingParameters, clock: PlayClock) -> None:
        self.name, self._log, self.tracking, self._clock = log.config, log, tracking, clock
        self._errors, self._bank, self._wind = log.error, log.bank, log.wind
        self._sample = lru_cache(KEPT)(self._at)

    @property
    def sight(self) -> Sight:
        """What there is to see at the time of the clock."""
        return self.at(self._clock.time)

    def past(self, span: float) -> Sequence[Sight]:
        """See :meth:`WatchedFlight.past`.

        Args:
            span: How far back from now in [s].
        """
        now = self._clock.time
        begin = max(now - span, self._clock.begin)
        # Whole periods: as time goes on, the same samples are asked for again.
        steps = np.arange(math.ceil(begin / PAST_PERIOD), math.ceil(now / PAST_PERIOD))
        return [self.at(time) for time in (steps * PAST_PERIOD).tolist()]

    def at(self, time: float) -> Sight:
        """What there was to see at a time.

        Args:
            time: In [s] of the log.
        """
        index = int(np.searchsorted(self._log.time, time + SAME, side="right")) - 1
        return self._sample(min(max(index, 0), len(self._log.time) - 1))

    def _at(self, k: int) -> Sight:
        log = self._log
        c = int(np.searchsorted(log.command_time, log.time[k], side="right")) - 1
        still = np.zeros(3)
        target_velocity = still if log.target_velocity is None else log.target_velocity[k]
        heading, path_angle, airspeed = log.vehicle[k, 3:]
        mode, reason = None, ""
        if (flown := log.mode_at(float(log.time[k]))) is not None:
            mode, reason = flown.mode, flown.reason
        elif c >= 0:
            nominal = log.nominal is None or log.nominal[c]
            mode = FallbackMode.OPTIMAL if nominal else FallbackMode.LOITER
        return Sight(
            time=float(log.time[k]),
            position=log.vehicle[k, :3],
            heading=heading,
            path_angle=path_angle,
            bank=float(self._bank[k]),
            airspeed=airspeed,
            ground_velocity=velocity(log.vehicle[k]) + self._wind[k],
            wind=self._wind[k],
            target=TargetSight(log.target[k], target_velocity, truth=log.target[k]),
            wanted=orbit_about(log.target[k], target_velocity, self._orbit(log.time[k])),
            mode=mode,
            reason=reason,
            errors=dict(zip(ERRORS, self._errors[k].tolist(), strict=True)),
            cost=math.nan if c < 0 else float(log.cost[c]),
            solve_time=math.nan if c < 0 else float(log.solve_time[c]),
        )

    def _orbit(self, time: float) -> Orbit:
        """What was asked for at a time; the first orbit also holds before its own."""
        orbits = self._log.orbits or ((0.0, self._log.orbit),)
        begun = [orbit for begin, orbit in orbits if begin <= time]
        return begun[-1] if begun else orbits[0][1]


class LoggedSource(FlightSource):
    """One flight from its log.

    Args:
        log: Record of the flight.
        tracking: What its controller flew by.
    """

    clock: PlayClock

    def __init__(self, log: FlightLog, tracking: TrackingParameters) -> None:
        self.clock = PlayClock(float(log.time[0]), float(log.time[-1]))
        self._flights = [LoggedFlight(log, tracking, self.clock)]

    def flights(self) -> Sequence[LoggedFlight]:
        """The one."""
        return self._flights

    def close(self) -> None:
        """A log holds nothing."""
