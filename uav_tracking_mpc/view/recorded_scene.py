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

"""A whole flight as a scene that needs no server: the replay of a report.

The flight is shown from its log and played through the elements of the live page. What they send is
recorded with the times at which it is to be shown, and viser puts it into one page with its player.
"""

from __future__ import annotations

import html
import itertools
import json
import math
from collections.abc import Sequence
from functools import lru_cache
from importlib.util import find_spec

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.dynamics.orbit import Orbit, orbit_about
from uav_tracking_mpc.dynamics.vehicle import velocity
from uav_tracking_mpc.nodes.messages.named_figures import ERRORS
from uav_tracking_mpc.report.mission_report import Replay
from uav_tracking_mpc.settings.tracking import TrackingParameters
from uav_tracking_mpc.simulation.flight_log import FlightLog
from uav_tracking_mpc.view.watched_flight import (
    FlightSource,
    KeptFlight,
    PlayClock,
    Sight,
    TargetSight,
)

KEPT = 1024  # sights that are not made again: a track asks for the same ones at each frame
SAME = 1e-6  # s by which a time may miss its sample


class LoggedFlight(KeptFlight):
    """Shows what a log holds at the time of a clock.

    Args:
        log: Record of the flight.
        tracking: What its controller flew by.
        clock: What time it is in the record.
    """

    def __init__(self, log: FlightLog, tracking: TrackingParameters, clock: PlayClock) -> None:
        super().__init__(log.config, clock, tracking)
        self._log = log
        self._errors, self._bank, self._wind = log.error, log.bank, log.wind
        self._sample = lru_cache(KEPT)(self._at)

    def at(self, time: float, whole: bool = True) -> Sight:
        """What there was to see at a time.

        Args:
            time: In [s] of the log.
            whole: Makes no difference: a log holds neither plans nor statuses.
        """
        index = int(np.searchsorted(self._log.time, time + SAME, side="right")) - 1
        return self._sample(min(max(index, 0), len(self._log.time) - 1))

    def _at(self, k: int) -> Sight:
        log = self._log
        c = int(np.searchsorted(log.command_time, log.time[k], side="right")) - 1
        target_velocity = np.zeros(3) if log.target_velocity is None else log.target_velocity[k]
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


RATE = 10.0  # Hz of the flight at most: 22 m/s are 2 m from frame to frame
FRAMES = 1800  # at most: each takes time to make and to load
FILM = 300.0  # s that a replay takes at most; viser's player goes up to 8 times as fast
PACES = (1, 2, 5)  # and these times powers of ten
BUDGET = 2_900_000  # bytes of the scene as a report holds it
LIGHT = "{darkMode:false}"
AS_THE_READER_LIKES = '{darkMode:matchMedia("(prefers-color-scheme: dark)").matches}'


def recorded_scene(log: FlightLog) -> Replay | None:
    """Record a flight.

    Args:
        log: Record of the flight.

    Returns:
        None where viser is not installed, or the log does not tell enough: fewer than two states,
        or not what its controller flew by.
    """
    flown = log.time[np.isfinite(log.vehicle).all(axis=1)]
    if log.tracking is None or len(flown) < 2 or find_spec("viser") is None:
        return None
    duration = float(flown[-1] - flown[0])
    count = min(FRAMES, len(flown), math.ceil(duration * RATE) + 1)
    while True:
        replay = _record(log, flown, count)
        size = len(html.escape(replay.html))
        if size <= BUDGET or count <= 2:
            return replay
        # The player takes its share of the size, whatever the frames need: a little too few.
        count = max(2, int(0.95 * count * BUDGET / size))


def pace_of(duration: float) -> float:
    """By how much faster than the flight it is played: 1, 2, 5, 10, 20, ...

    Args:
        duration: Of the flight in [s].
    """
    paces = (step * 10.0**power for power in itertools.count() for step in PACES)
    return next(pace for pace in paces if duration / pace <= FILM)


def _record(log: FlightLog, flown: NDArray[np.float64], count: int) -> Replay:
    """Play so many frames, at times of which the state is known."""
    from uav_tracking_mpc.view.cameras import ABOVE, look_at_whole, scene_pose
    from uav_tracking_mpc.view.flight_history import FlightHistory
    from uav_tracking_mpc.view.page import COLOURS, WORLD, elements_of
    from uav_tracking_mpc.view.serving.guarded_server import GuardedServer
    from uav_tracking_mpc.view.serving.page_script import with_script

    assert log.tracking is not None
    source = LoggedSource(log, log.tracking)
    (flight,) = source.flights()
    source.clock.pause()
    pace = pace_of(float(flown[-1] - flown[0]))
    times = flown[np.linspace(0, len(flown) - 1, count).round().astype(int)]
    # viser knows no scene without a server: one that only this machine reaches, for the moment.
    server = GuardedServer(port=0)
    try:
        source.clock.seek(times[0])
        world = server.scene.add_frame(WORLD, show_axes=False)
        follows = look_at_whole(server.initial_camera, flight, log)
        elements = elements_of(server.scene, flight, COLOURS[0])
        serializer = server.get_scene_serializer()
        for time, next_time in zip(times, [*times[1:], times[-1]], strict=True):
            source.clock.seek(time)
            sight = flight.at(time)
            for element in elements:
                element.show(sight)
            if follows:
                world.position = scene_pose(ABOVE, sight).translation()
            serializer.insert_sleep(float(next_time - time) / pace)
        page = serializer.as_html()
        history = FlightHistory(flight, source.clock, FRAMES)
        history.read()
        strip = json.loads(history.as_json())
    finally:
        server.stop()
        source.close()
    page = page.replace(LIGHT, AS_THE_READER_LIKES)
    record = {"begin": times[0], "end": times[-1], "pace": pace, **strip}
    return Replay(with_script(page, f"{log.config}: the flight", record), pace, len(times))
