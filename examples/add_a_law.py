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

"""Add a guidance law: pure pursuit of a point that runs ahead on the orbit.

The law is this one class. Nothing in the package is edited; it is found by ``FILE.py:CLASS``::

    uav_tracking compare --law examples/add_a_law.py:PurePursuit
    uav_tracking simulate --config small_uav --law examples/add_a_law.py:PurePursuit
"""

import math
import sys

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc import GuidanceLaw, Situation
from uav_tracking_mpc.cli.main import main

LEAD = math.radians(20.0)  # how far ahead on the orbit the pursued point is
CLIMB_GAIN, PATH_ANGLE_GAIN, SPEED_GAIN = 0.45, 1.5, 0.8  # 1/s


class PurePursuit(GuidanceLaw):
    r"""Turns on the circle that leads through a point L away, at an angle eta off the course.

    .. math:: u_\psi = \frac{2 v \sin\eta}{L}
    """

    name = "pure_pursuit"

    def inputs(self, situation: Situation) -> NDArray[np.float64]:
        """See :meth:`GuidanceLaw.inputs`."""
        orbit = self.orbit
        x, y, height = situation.offset
        ahead = math.atan2(y, x) + math.copysign(LEAD, -orbit.bearing)
        to_x, to_y = orbit.radius * math.cos(ahead) - x, orbit.radius * math.sin(ahead) - y
        east, north, _ = situation.relative_velocity
        eta = math.atan2(east * to_y - north * to_x, east * to_x + north * to_y)
        *_, path_angle, airspeed = situation.vehicle
        turn_rate = 2.0 * math.hypot(east, north) * math.sin(eta) / math.hypot(to_x, to_y)
        climb = CLIMB_GAIN * (orbit.altitude - height) / airspeed
        lowest, highest = self.envelope.path_angle_limits(airspeed)
        wanted = math.asin(min(max(climb, math.sin(lowest)), math.sin(highest)))
        path_rate = PATH_ANGLE_GAIN * (wanted - path_angle)
        acceleration = SPEED_GAIN * (orbit.speed - airspeed)
        return self.envelope.clip([turn_rate, path_rate, acceleration], airspeed, path_angle)


if __name__ == "__main__":
    law = f"{__file__}:PurePursuit"
    sys.exit(main(["compare", "--law", law, "--laws", "l1", "--scenario", "wind", *sys.argv[1:]]))
