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

"""The simulated target, how it moves and how it is measured, as parameters."""

from __future__ import annotations

import math
from dataclasses import dataclass

from uav_tracking_mpc.parameters.registry import TARGET_MOTION
from uav_tracking_mpc.parameters.specification import ParameterError, parameter
from uav_tracking_mpc.settings.frame_parameters import MapFrameParameters

MEASURED = ("rate", "noise", "dropout", "delay", "seed")  # what is not about the motion


@dataclass(frozen=True)
class TargetParameters(MapFrameParameters):
    """Motion and measurement of the target.

    Raises:
        ParameterError: The waypoints hold fewer than two different points.
    """

    motion: str = parameter("stationary", "How the target moves.", extension=TARGET_MOTION)
    position: tuple[float, ...] = parameter(
        (0.0, 0.0, 0.0),
        "Where it stands or starts in map; for a circle, its centre.",
        "m",
        -1e6,
        1e6,
        size=3,
    )
    speed: float = parameter(
        0.0, "Speed along its path; ignored when stationary.", "m/s", 0.0, 100.0
    )
    heading: float = parameter(
        0.0,
        "Direction of a straight run, or azimuth of a circle's start, from East.",
        "rad",
        -2.0 * math.pi,
        2.0 * math.pi,
    )
    radius: float = parameter(100.0, "Radius of a circle.", "m", 0.1, 1e5)
    waypoints: tuple[float, ...] = parameter(
        (0.0, 0.0, 0.0, 100.0, 0.0, 0.0),
        "x, y, z of one point after the other, visited in turn and from the start again.",
        "m",
        -1e6,
        1e6,
        multiple=3,
    )
    drive_time: float = parameter(
        20.0, "How long stop_and_go and zigzag drive at a time, straight on.", "s", 0.1, 1e5
    )
    stand_time: float = parameter(20.0, "How long stop_and_go stands in between.", "s", 0.1, 1e5)
    jump_time: float = parameter(
        60.0, "When jump, otherwise a straight run, is somewhere else at once.", "s", 0.0, 1e6
    )
    jump_offset: tuple[float, ...] = parameter(
        (100.0, 0.0, 0.0), "By how much it is moved.", "m", -1e6, 1e6, size=3
    )
    rate: float = parameter(
        10.0, "How often the position is measured.", "Hz", 0.1, 1000.0, fixed=True
    )
    noise: float = parameter(
        0.0, "Standard deviation of the measured position, each axis.", "m", 0.0, 1e3
    )
    dropout: float = parameter(
        0.0, "Probability with which a measurement is lost.", lower=0.0, upper=1.0
    )
    delay: float = parameter(
        0.0,
        "How late a measurement is published; its stamp is the time of measuring.",
        "s",
        0.0,
        60.0,
        fixed=True,
    )
    seed: int = parameter(0, "Seed of noise and dropouts.", lower=0, upper=2**31 - 1, fixed=True)

    def __post_init__(self) -> None:
        """Check that the waypoints make a path."""
        super().__post_init__()
        points = {self.waypoints[first : first + 3] for first in range(0, len(self.waypoints), 3)}
        if len(points) < 2:
            raise ParameterError(
                f"parameter 'waypoints' is {list(self.waypoints)}, must hold at least two "
                "different points"
            )
