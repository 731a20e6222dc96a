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

"""What the controller shows to people: tracking errors, the plan as a path, markers."""

from __future__ import annotations

import math
import time

import numpy as np
from geometry_msgs.msg import Point, PoseStamped
from nav_msgs.msg import Path
from numpy.typing import NDArray
from rclpy.node import Node
from visualization_msgs.msg import Marker, MarkerArray

from uav_tracking_mpc.control.command import Command
from uav_tracking_mpc.control.commanded_path import PlannedPath
from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.estimation.navigator import Navigator
from uav_tracking_mpc.estimation.situation import Situation
from uav_tracking_mpc.nodes.messages.conversions import set_orientation, set_stamp, set_vector
from uav_tracking_mpc.nodes.messages.message_checks import FRAMES, FrameNames
from uav_tracking_mpc.nodes.messages.named_figures import ERRORS, set_tracking, tracking_message
from uav_tracking_mpc.nodes.ros.endpoints import publish
from uav_tracking_mpc.nodes.topics import MARKERS, PREDICTED_PATH, TRACKING, TRACKING_ERRORS


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


PERIOD = 0.2  # s of wall time between paths and markers: people look at them


class ControllerViews:
    """Publishes what somebody listens to.

    Args:
        node: Through which it publishes.

    Attributes:
        frames: Of the messages.
    """

    def __init__(self, node: Node) -> None:
        self._path, self._markers = (publish(node, topic) for topic in (PREDICTED_PATH, MARKERS))
        self._errors = publish(node, TRACKING_ERRORS)
        self._error_values = tracking_message()
        self._tracking = {
            name: (publish(node, topic), topic.type()) for name, topic in TRACKING.items()
        }
        self._last, self.frames = -float("inf"), FRAMES

    def publish(
        self, stamp: int, path: PlannedPath, command: Command, navigator: Navigator
    ) -> None:
        """Show one command.

        Args:
            stamp: Of the state that it answers in [ns].
            path: On which it leads.
            command: What was sent.
            navigator: What it was computed from.
        """
        present, solution = command.present, command.solution
        if present is not None:
            self._publish_errors(stamp, present, command, navigator)
        if solution is not None:
            self._publish_figure("cost", solution.cost)
            self._publish_figure("solve_time", solution.solve_time)
        now = time.monotonic()
        viewers = self._path.get_subscription_count() + self._markers.get_subscription_count()
        if present is not None and viewers and now - self._last >= PERIOD:
            self._last = now
            self._path.publish(path_message(stamp, path.states, self.frames))
            self._markers.publish(
                markers_message(stamp, path.states, present.target, command.orbit, self.frames)
            )

    def _publish_errors(
        self, stamp: int, present: Situation, command: Command, navigator: Navigator
    ) -> None:
        """Stamped all in one message, and each one by itself."""
        publishers = self._errors, *(self._tracking[name][0] for name in ERRORS)
        if not any(publisher.get_subscription_count() for publisher in publishers):
            return
        message = self._error_values
        known = navigator.target.position_std(command.stamp), navigator.wind, command.mode
        set_tracking(message, stamp, present, command.orbit, *known, self.frames)
        if not all(map(math.isfinite, message.position)):
            return
        if self._errors.get_subscription_count():
            self._errors.publish(message)
        for name, error in zip(ERRORS, message.position, strict=False):
            self._publish_figure(name, error)

    def _publish_figure(self, name: str, value: float) -> None:
        publisher, message = self._tracking[name]
        if publisher.get_subscription_count():
            message.data = float(value)
            publisher.publish(message)
