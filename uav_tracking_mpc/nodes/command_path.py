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

"""Where a command leads, point by point, in the fields of a trajectory that are for it.

========================  =====================================================================
transforms[0]             of ``base_link`` in ``header.frame_id``: position, and attitude with
                          wings level, as in ``uav/odometry``
velocities[0].linear      over ground, in ``header.frame_id`` as well: MAVROS turns it from there
                          to North-East-Down (plugin ``setpoint_trajectory``)
========================  =====================================================================

Whoever flies by the inputs needs neither. A command without them is as good.
"""

from __future__ import annotations

import numpy as np
from geometry_msgs.msg import Transform
from numpy.typing import NDArray
from trajectory_msgs.msg import MultiDOFJointTrajectory

from uav_tracking_mpc.control.planned_path import PlannedPath
from uav_tracking_mpc.dynamics.frames import quaternion_from_course
from uav_tracking_mpc.nodes.conversions import set_vector

PLACE, ATTITUDE, VELOCITY = slice(0, 3), slice(3, 7), slice(7, 10)
POINT_SIZE = 10  # numbers of one point


def fill_points(points: NDArray[np.float64], path: PlannedPath) -> None:
    """Numbers of the points of a path, whose end is left out: no input belongs to it.

    Args:
        points: Position [m], quaternion (x, y, z, w) [-] and velocity [m/s] of each point, shape
            (n, 10); changed in place.
        path: Of n stages.
    """
    states = path.states[:-1]
    points[:, PLACE] = states[:, :3]
    quaternions = quaternion_from_course(states[:, 3], states[:, 4], np)
    for column, values in zip(points[:, ATTITUDE].T, quaternions, strict=True):
        column[:] = values
    points[:, VELOCITY] = path.ground_velocities[:-1]


def set_points(message: MultiDOFJointTrajectory, points: NDArray[np.float64]) -> None:
    """Fill the path into a command that has its inputs.

    Args:
        message: Changed in place.
        points: As of :func:`fill_points`, shape (n, 10).
    """
    for point, values in zip(message.points, points, strict=True):
        transform = Transform()
        set_vector(transform.translation, values[PLACE])
        rotation = transform.rotation
        rotation.x, rotation.y, rotation.z, rotation.w = values[ATTITUDE].tolist()
        point.transforms = [transform]
        set_vector(point.velocities[0].linear, values[VELOCITY])
