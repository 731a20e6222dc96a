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

"""How accurate an autopilot says that it knows position and velocity.

======================  ==========================================================================
ESTIMATOR_STATUS        PX4's filter: standard deviations of the position, horizontal and vertical
GPS_RAW_INT             the receiver's of position and velocity, where that of the filter is missing
======================  ==========================================================================

ArduPilot's EKF_STATUS_REPORT tells no variances, for all the names of its fields: they are
innovations as a share of their gates. Neither autopilot tells how accurate heading and airspeed
are.
"""

from __future__ import annotations

import math
from typing import Any

from uav_tracking_mpc.estimation.measurement import SILENT, SensorNoise
from uav_tracking_mpc.estimation.told_noise import UNKNOWN, axes_noise

AGE = 5.0  # s that what is told counts
MILLI = 1e-3  # m or m/s


class Accuracies:
    """The newest that were told."""

    def __init__(self) -> None:
        self._filtered = self._received = self._velocity = UNKNOWN
        self._filtered_at = self._received_at = -math.inf

    def see(self, message: Any, arrival: float) -> None:
        """Take in a message.

        Args:
            message: Of the autopilot.
            arrival: Our time in [s].
        """
        kind = message.get_type()
        if kind == "ESTIMATOR_STATUS":
            accuracies = message.pos_horiz_accuracy, message.pos_vert_accuracy
            self._filtered, self._filtered_at = _axes("position", *accuracies), arrival
        elif kind == "GPS_RAW_INT":
            accuracies = MILLI * message.h_acc, MILLI * message.v_acc
            self._received, self._received_at = _axes("position", *accuracies), arrival
            speed = MILLI * message.vel_acc
            self._velocity = _axes("velocity", speed, speed)

    def noise(self, now: float) -> SensorNoise:
        """What is told of the noise, in words that are not too old.

        Args:
            now: Our time in [s].
        """
        position = velocity = UNKNOWN
        if now - self._received_at <= AGE:
            position, velocity = self._received, self._velocity
        if now - self._filtered_at <= AGE and self._filtered != UNKNOWN:
            position = self._filtered
        if position == velocity == UNKNOWN:
            return SILENT
        return SensorNoise(position, velocity)


def _axes(name: str, level: float, vertical: float) -> tuple[float, float, float]:
    """Of standard deviations, of which one may be negative or not finite; zeros for unknown."""
    variances = [math.copysign(1.0, value) * value * value for value in (level, level, vertical)]
    return axes_noise(name, variances)
