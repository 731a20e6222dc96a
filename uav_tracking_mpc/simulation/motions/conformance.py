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

"""Whether a target motion keeps what :class:`TargetMotion` asks for."""

from __future__ import annotations

import numpy as np

from uav_tracking_mpc.parameters.conformance import judged, require, require_name, require_vector
from uav_tracking_mpc.settings.simulator import TargetParameters
from uav_tracking_mpc.simulation.motions import TargetMotion

FARTHEST, FASTEST = 1e7, 1e3  # m and m/s: what lies beyond is no ground target
STEP = 1e-4  # s, over which positions are compared with velocities
CHANGE = 1e-2  # m/s; a velocity that changes more in a step has a corner there


def check_motion(motion: type[TargetMotion]) -> None:
    """Ask a motion where it is through 100 s, forwards and backwards.

    Args:
        motion: Class of the motion.

    Raises:
        ConformanceError: It raises, a position or velocity is not a finite vector in [m] or [m/s],
            it depends on more than the time, or the velocity is not that of the position.
    """
    name = require_name(motion)
    with judged(name):
        _check(motion, name)


def _check(motion: type[TargetMotion], name: str) -> None:
    parameters = TargetParameters(position=(10.0, -20.0, 3.0), speed=5.0, jump_time=1e6)
    target, again = motion(parameters), motion(parameters)
    times = np.linspace(0.0, 100.0, 401).tolist()
    for time in times:
        position, velocity = target.position(time), target.velocity(time)
        require_vector(position, FARTHEST, f"{name}: position({time:g}) [m]")
        require_vector(velocity, FASTEST, f"{name}: velocity({time:g}) [m/s]")
        ahead, later = target.position(time + STEP), target.velocity(time + STEP)
        flown, mean = (ahead - position) / STEP, 0.5 * (velocity + later)
        require(
            np.linalg.norm(later - velocity) > CHANGE
            or np.linalg.norm(flown - mean) <= 10.0 * CHANGE,
            f"{name}: velocity({time:g}) is {velocity.tolist()} m/s, the position moves with "
            f"{flown.tolist()} m/s",
        )
        position += 1.0  # whoever is given a position may change it
    for time in reversed(times):
        require(
            np.array_equal(target.position(time), again.position(time)),
            f"{name}: position({time:g}) depends on more than the time",
        )
