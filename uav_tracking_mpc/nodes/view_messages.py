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

"""What people look at: the plan as a path, markers of target, orbit, plan and aircraft."""

from __future__ import annotations

import numpy as np
from geometry_msgs.msg import Point, PoseStamped
from nav_msgs.msg import Path
from numpy.typing import NDArray
from visualization_msgs.msg import Marker, MarkerArray

from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.nodes.conversions import set_orientation, set_stamp, set_vector
from uav_tracking_mpc.nodes.frame_names import FRAMES, FrameNames


def path_message(stamp: int, states: NDArray[np.float64], frames: FrameNames = FRAMES) -> Path:
    """Path through vehicle states.

    Args:
        stamp: Of the first one in [ns].
        states: (x, y, z, psi, chi, v) in ``map``, shape (n, 6).
        frames: Of the message.
    """
    message = Path()
    set_stamp(message.header.stamp, stamp)
    message.header.frame_id = frames.map
    for state in states:
        pose = PoseStamped()
        pose.header = message.header
        set_vector(pose.pose.position, state[:3])
        _, _, _, heading, path_angle, _ = state.tolist()
        set_orientation(pose.pose.orientation, heading, path_angle)
        message.poses.append(pose)
    return message


def markers_message(
    stamp: int,
    states: NDArray[np.float64],
    target: NDArray[np.float64],
    orbit: Orbit,
    frames: FrameNames = FRAMES,
) -> MarkerArray:
    """Markers of target, desired orbit, plan and aircraft.

    Args:
        stamp: Of the first state in [ns].
        states: Along the plan, (x, y, z, psi, chi, v) in ``map``, shape (n, 6).
        target: Position in ``map``, shape (3,), in [m].
        orbit: What is flown.
        frames: Of the message.
    """
    angles = np.linspace(0.0, 2.0 * np.pi, 73)
    circle = target + np.column_stack(
        [
            orbit.radius * np.cos(angles),
            orbit.radius * np.sin(angles),
            np.full(len(angles), orbit.altitude),
        ]
    )
    at_target = _marker(stamp, 0, Marker.SPHERE, (0.84, 0.37, 0.0), 6.0)
    wanted = _marker(stamp, 1, Marker.LINE_STRIP, (0.5, 0.5, 0.5), 0.8, circle)
    plan = _marker(stamp, 2, Marker.LINE_STRIP, (0.0, 0.45, 0.7), 1.2, states[:, :3])
    aircraft = _marker(stamp, 3, Marker.ARROW, (0.0, 0.6, 0.5), 3.0)
    set_vector(at_target.pose.position, target)
    set_vector(aircraft.pose.position, states[0, :3])
    _, _, _, heading, path_angle, _ = states[0].tolist()
    set_orientation(aircraft.pose.orientation, heading, path_angle)
    aircraft.scale.x = 12.0
    markers = [at_target, wanted, plan, aircraft]
    for marker in markers:
        marker.header.frame_id = frames.map
    return MarkerArray(markers=markers)


def _marker(
    stamp: int,
    identity: int,
    kind: int,
    colour: tuple[float, float, float],
    size: float,
    points: NDArray[np.float64] | None = None,
) -> Marker:
    marker = Marker()
    set_stamp(marker.header.stamp, stamp)
    marker.ns, marker.id, marker.type = "uav_tracking", identity, kind
    marker.scale.x = marker.scale.y = marker.scale.z = size
    marker.color.r, marker.color.g, marker.color.b, marker.color.a = *colour, 1.0
    for position in () if points is None else points:
        point = Point()
        set_vector(point, position)
        marker.points.append(point)
    return marker
