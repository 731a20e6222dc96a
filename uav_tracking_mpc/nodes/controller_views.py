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

from rclpy.node import Node

from uav_tracking_mpc.control.command import Command
from uav_tracking_mpc.control.planned_path import PlannedPath
from uav_tracking_mpc.estimation.navigator import Navigator
from uav_tracking_mpc.estimation.situation import Situation
from uav_tracking_mpc.nodes.endpoints import publish
from uav_tracking_mpc.nodes.frame_names import FRAMES
from uav_tracking_mpc.nodes.topics import MARKERS, PREDICTED_PATH, TRACKING, TRACKING_ERRORS
from uav_tracking_mpc.nodes.tracking_message import ERRORS, set_tracking, tracking_message
from uav_tracking_mpc.nodes.view_messages import markers_message, path_message

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
