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

"""A target whose motion changes while it moves, without a jump."""

from __future__ import annotations

import math
from dataclasses import asdict, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uav_tracking_mpc.parameters.specification import ParameterError, refuse_fixed
from uav_tracking_mpc.settings.target import MEASURED, TargetParameters
from uav_tracking_mpc.simulation.motions import motion_of

GOING_SPEED = 5.0  # m/s, to where it is sent, of a target whose motion has no speed
STATIONARY = "stationary"


class _Approach(NamedTuple):
    """The straight way to where a motion begins: start [m], velocity [m/s] and duration [s]."""

    start: NDArray[np.float64]
    velocity: NDArray[np.float64]
    duration: float


class SteeredTarget:
    """Moves as its parameters say, also when they change, and goes where it is sent.

    A new motion begins where the target is. If its path lies elsewhere (a circle, waypoints, or a
    ``position`` that was changed), the target first drives there straight, with the speed of the
    motion, or 5 m/s if that is 0. So it never jumps, unless its motion does.

    Args:
        parameters: Motion, start and figures.

    Attributes:
        parameters: As they are now.

    Raises:
        ParameterError: There is no such motion.
    """

    def __init__(self, parameters: TargetParameters) -> None:
        self.parameters = parameters
        self._motion, self._began, self._changed = motion_of(parameters), 0.0, -math.inf
        self._approach = _Approach(np.zeros(3), np.zeros(3), 0.0)

    def check(self, parameters: TargetParameters) -> None:
        """Whether other parameters can be taken.

        Args:
            parameters: All of them.

        Raises:
            ParameterError: There is no such motion, it fails, or one differs that is fixed.
        """
        refuse_fixed(self.parameters, parameters, "while the target moves")
        try:
            motion_of(parameters).position(0.0)
        except ParameterError:
            raise
        except Exception as error:  # whatever a user's motion raises, the target moves on
            name = parameters.motion
            raise ParameterError(
                f"parameter 'motion' is {name!r}, which failed: {error}"
            ) from error

    def change(self, time: float, parameters: TargetParameters) -> None:
        """Move otherwise from now on.

        Args:
            time: Now, since the target's start in [s].
            parameters: All of them.

        Raises:
            ParameterError: As of :meth:`check`; nothing has changed.
        """
        self.check(parameters)
        if _motion_alone(parameters) != _motion_alone(self.parameters):
            self._begin(time, parameters, parameters.position != self.parameters.position)
        self.parameters = parameters

    def go_to(self, time: float, goal: ArrayLike) -> None:
        """Go somewhere and stand there.

        Args:
            time: Now, since the target's start in [s].
            goal: In ``map``, shape (3,), in [m].
        """
        place = tuple(np.array(goal, dtype=float).tolist())
        parameters = replace(self.parameters, motion=STATIONARY, position=place)
        self._begin(time, parameters, True)
        self.parameters = parameters

    def heading_for(self, time: float) -> NDArray[np.float64] | None:
        """Where its motion begins in ``map``, shape (3,), in [m], while it drives there; else None.

        Args:
            time: Now, since the target's start in [s].
        """
        return self._motion.position(0.0) if time < self._began else None

    def position(self, time: float) -> NDArray[np.float64]:
        """True position in ``map``, shape (3,), in [m].

        Args:
            time: Since the target's start in [s]; before the last change it is where that was.
        """
        time = max(time, self._changed)
        start, velocity, duration = self._approach
        if time < self._began and duration > 0.0:
            return start + velocity * (time - self._changed)
        return self._motion.position(time - self._began)

    def velocity(self, time: float) -> NDArray[np.float64]:
        """True velocity in ``map``, shape (3,), in [m/s].

        Args:
            time: Since the target's start in [s]; before the last change it is that of then.
        """
        time = max(time, self._changed)
        _, velocity, duration = self._approach
        if time < self._began and duration > 0.0:
            return velocity.copy()
        return self._motion.velocity(time - self._began)

    def _begin(self, time: float, parameters: TargetParameters, elsewhere: bool) -> None:
        """Take up a motion; ``elsewhere`` if it is to begin at its ``position``."""
        place, velocity = self.position(time), self.velocity(time)
        wanted = motion_of(parameters).starting(parameters, place, velocity)
        if elsewhere and wanted.position != parameters.position:
            wanted = parameters
        motion = motion_of(wanted)
        way, speed = motion.position(0.0) - place, parameters.speed or GOING_SPEED
        duration = float(np.linalg.norm(way)) / speed
        self._approach = _Approach(place, way / max(duration, 1e-12), duration)
        self._motion, self._began, self._changed = motion, time + duration, time


def _motion_alone(parameters: TargetParameters) -> dict[str, object]:
    """What of the parameters is about the motion, by name."""
    return {name: value for name, value in asdict(parameters).items() if name not in MEASURED}
