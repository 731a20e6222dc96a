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

"""Node ``target_publisher``: publishes the target's measured position."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rclpy.node import Node
from rclpy.parameter import Parameter

from uav_tracking_mpc.nodes.messages.conversions import position_from_point, set_point, set_truth
from uav_tracking_mpc.nodes.messages.diagnostic_values import target_words
from uav_tracking_mpc.nodes.ros import diagnostics
from uav_tracking_mpc.nodes.ros.declared_parameters import declare_parameters, follow_parameters
from uav_tracking_mpc.nodes.ros.endpoints import SimulatedOutage, listen, publish
from uav_tracking_mpc.nodes.ros.process import run
from uav_tracking_mpc.nodes.topics import (
    TARGET,
    TARGET_GOAL,
    TARGET_TRUTH,
    FrameNames,
    MessageError,
    map_frame,
)
from uav_tracking_mpc.settings.simulator import TargetParameters
from uav_tracking_mpc.simulation.steered_target import STATIONARY, SteeredTarget, TargetSensor

TRUTH_PERIOD = 0.05  # s
DELIVERY_PERIOD = 0.01  # s; how closely a delay is kept


class TargetPublisher(Node):
    """Moves the target as its parameters say; with simulated time, by that time.

    Args:
        options: As those of rclpy's Node.

    Raises:
        ParameterError: A parameter is not allowed, or there is no such motion.
    """

    def __init__(self, **options: Any) -> None:
        super().__init__("target_publisher", **options)
        self.parameters = declare_parameters(self, TargetParameters, changeable=True)
        self._frames = FrameNames(map_frame(self.parameters.map_frame))
        self._target = SteeredTarget(self.parameters)
        self._sensor = TargetSensor(self.parameters, self._target)
        follow_parameters(self, self.parameters, self._target.check, self._take)
        simulated = bool(self.get_parameter("use_sim_time").value)
        self._start = 0 if simulated else self.get_clock().now().nanoseconds
        self._message, self._truth = TARGET.type(), TARGET_TRUTH.type()
        self._position, self._refused = self._target.position(0.0), 0
        self._measured_at = math.nan
        self._failure = self._unchanged = ""  # why there is no position, and no other motion
        self._publisher = publish(self, TARGET)
        self._truths = publish(self, TARGET_TRUTH)
        listen(self, TARGET_GOAL, self._on_goal)
        self._diagnostics = diagnostics.Diagnostics(self, self._values)
        self._warnings = diagnostics.ThrottledWarnings(self)
        told = (TARGET, TARGET_TRUTH)
        self._senders = diagnostics.DuplicateSenders(self, told, self._diagnostics.alarm)
        self._outage = SimulatedOutage(self, "lose_target", "the target's position", self._time)
        self._timer = self.create_timer(1.0 / self.parameters.rate, self._measure)
        self._truth_timer = self.create_timer(TRUTH_PERIOD, self._tell_truth)
        if self.parameters.delay > 0.0:
            self._delivery = self.create_timer(DELIVERY_PERIOD, self._deliver)

    def _time(self) -> float:
        """Since the target's start in [s]."""
        return (self.get_clock().now().nanoseconds - self._start) * 1e-9

    def _take(self, parameters: TargetParameters) -> None:
        self._sensor.change(parameters)
        self.parameters = parameters
        self._steer(lambda now: self._target.change(now, parameters))

    def _steer(self, change: Callable[[float], None]) -> None:
        now, self._unchanged = self._time(), ""
        try:
            change(now)
        except Exception as error:  # whatever a user's motion raises, the node goes on
            self._unchanged = f"the motion failed, the one before goes on: {error}"
        self._tell_truth()
        self._report(now)

    def _on_goal(self, message: Any) -> None:
        """Go and stand there: the parameters say so as well."""
        try:
            goal = position_from_point(message, self._frames, TARGET_GOAL)
        except MessageError as error:
            self._refuse(str(error))
            return
        values = {"motion": STATIONARY, "position": goal.tolist()}
        changes = [Parameter(name, value=value) for name, value in values.items()]
        answer = self.set_parameters_atomically(changes)
        if not answer.successful:
            self._refuse(answer.reason)
            return
        # It may stand elsewhere although its position was this one already.
        self._steer(lambda now: self._target.go_to(now, goal))

    def _refuse(self, words: str) -> None:
        self._refused += 1
        self._warnings.warn("goal", f"goal refused: {words}")

    def _tell_truth(self) -> None:
        stamp = self.get_clock().now().nanoseconds
        now = (stamp - self._start) * 1e-9
        if (motion := self._motion_at(now)) is not None:
            position, velocity = motion
            set_truth(self._truth, stamp, position, velocity, self._frames)
            self._truths.publish(self._truth)

    def _motion_at(self, now: float) -> NDArray[np.float64] | None:
        """True position [m] and velocity [m/s], shape (2, 3); None, and a failure, without them."""
        try:
            motion = np.array([self._target.position(now), self._target.velocity(now)], dtype=float)
        except Exception as error:  # whatever a user's motion raises, the node goes on
            self._failure = f"the motion failed, no position is published: {error}"
            return None
        self._failure = ""
        return motion

    def _measure(self) -> None:
        now = self._time()
        if now == self._measured_at:  # a late timer fires twice before simulated time goes on
            return
        if now < self._measured_at:
            self._target.go_back(now, self._measured_at)
        self._measured_at = now
        if (motion := self._motion_at(now)) is not None:
            self._position = motion[0]
            self._sensor.measure(now)
        self._deliver()
        self._report(now)

    def _report(self, now: float) -> None:
        if failure := self._failure or self._unchanged:
            self._diagnostics.report(diagnostics.ERROR, failure)
            return
        if self._outage.lasts:
            self._diagnostics.report(diagnostics.WARN, self._outage.words)
            return
        self._diagnostics.report(diagnostics.OK, target_words(self._target, now))

    def _deliver(self) -> None:
        arrived = self._sensor.delivered(self._time())
        for measured, position in () if self._outage.lasts else arrived:
            set_point(self._message, self._start + round(measured * 1e9), position, self._frames)
            self._publisher.publish(self._message)

    def _values(self) -> dict[str, object]:
        x, y, z = self._position.tolist()
        return {
            "x [m]": x,
            "y [m]": y,
            "z [m]": z,
            "rate [Hz]": self.parameters.rate,
            "began [ns]": str(self._start),
            "goals refused": self._refused,
        }

    def finish(self) -> None:
        """Publish the last diagnostics."""
        self._diagnostics.end()


if __name__ == "__main__":
    sys.exit(run("target_publisher", TargetPublisher))
