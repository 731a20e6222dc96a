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

The flight is played through the elements of the live page. What they send is recorded with the
times at which it is to be shown, and viser puts it into one page with its player.
"""

from __future__ import annotations

import html
import itertools
import math
from importlib.util import find_spec

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.report.mission_report import Replay
from uav_tracking_mpc.simulation.flight_log import FlightLog

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
    from uav_tracking_mpc.view.logged_flight import LoggedSource
    from uav_tracking_mpc.view.page import COLOURS, WORLD, elements_of
    from uav_tracking_mpc.view.serving.guarded_server import GuardedServer

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
            sight = flight.sight
            for element in elements:
                element.show(sight)
            if follows:
                world.position = scene_pose(ABOVE, sight).translation()
            serializer.insert_sleep(float(next_time - time) / pace)
        page = serializer.as_html()
    finally:
        server.stop()
        source.close()
    return Replay(page.replace(LIGHT, AS_THE_READER_LIKES), pace, len(times))
