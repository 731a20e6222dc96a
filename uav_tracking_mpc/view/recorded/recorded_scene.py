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
import math
from importlib.util import find_spec
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.report.replay import Replay
from uav_tracking_mpc.simulation.flight_log import FlightLog

if TYPE_CHECKING:
    import viser

    from uav_tracking_mpc.view.recorded.logged_flight import LoggedFlight

RATE = 10.0  # Hz of the flight at most: 22 m/s are 2 m from frame to frame
FRAMES = 1800  # at most: each takes time to make and to load
FILM = 300.0  # s that a replay takes at most; viser's player goes up to 8 times as fast
PACES = (1, 2, 5)  # and these times powers of ten
FAR_TARGET = 4.0  # by the radius of the orbit: a target that goes farther is followed
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
    pace, power = 1.0, 1.0
    while duration / pace > FILM:
        later = [step * power for step in PACES if step * power > pace]
        if later:
            pace = later[0]
        else:
            power *= 10.0
    return pace


def _record(log: FlightLog, flown: NDArray[np.float64], count: int) -> Replay:
    """Play so many frames, at times of which the state is known."""
    from uav_tracking_mpc.view.cameras import ABOVE, scene_pose
    from uav_tracking_mpc.view.page import COLOURS, WORLD, elements_of
    from uav_tracking_mpc.view.recorded.logged_flight import LoggedSource
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
        follows = _look_at(server.initial_camera, flight, log)
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


def _look_at(camera: viser.InitialCameraConfig, flight: LoggedFlight, log: FlightLog) -> bool:
    """Put the camera where it sees the whole flight, from the south and above.

    Returns:
        Whether the target goes so far that the scene is to be moved with it: the first view is then
        that of the live page.
    """
    from uav_tracking_mpc.view.cameras import (
        ABOVE,
        ELEVATION,
        FAR,
        FIELD_OF_VIEW,
        FREE,
        NEAR,
        first_pose,
        scene_pose,
    )
    from uav_tracking_mpc.view.scene._extent import extent

    camera.fov, camera.near, camera.far = FIELD_OF_VIEW, NEAR, FAR
    sight = flight.sight
    size = extent(flight, sight)
    places, targets = (
        each[np.isfinite(each).all(axis=1)] for each in (log.vehicle[:, :3], log.target)
    )
    if len(targets) and np.linalg.norm(np.ptp(targets, axis=0)) > FAR_TARGET * size:
        moved = scene_pose(ABOVE, sight).translation()
        camera.position, camera.look_at = (
            place + moved for place in first_pose(FREE, (flight, sight), 1.0)
        )
        return True
    low, high = (limit([*places, *targets], axis=0) for limit in (np.min, np.max))
    middle, reach = 0.5 * (low + high), max(0.5 * float(np.linalg.norm(high - low)), size)
    camera.look_at = middle
    from_south = np.array([0.0, -math.cos(ELEVATION), math.sin(ELEVATION)])
    camera.position = middle + reach / math.tan(0.5 * FIELD_OF_VIEW) * from_south
    return False
