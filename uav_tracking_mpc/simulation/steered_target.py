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

"""The target: a motion that changes while it moves, without a jump, and how it is measured."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import asdict, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uav_tracking_mpc.parameters.specification import refuse_fixed
from uav_tracking_mpc.settings.simulator import MEASURED, TargetParameters
from uav_tracking_mpc.simulation.motions import TargetMotion, motion_of
from uav_tracking_mpc.simulation.plants import SimulationError

GOING_SPEED = 5.0  # m/s, to where it is sent, of a target whose motion has no speed
STATIONARY = "stationary"


class _Approach(NamedTuple):
    """The straight way to where a motion begins: start [m] and velocity [m/s]."""

    start: NDArray[np.float64]
    velocity: NDArray[np.float64]


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
        ParameterError: As of :func:`motion_of`.
    """

    def __init__(self, parameters: TargetParameters) -> None:
        self.parameters = parameters
        self._motion, self._began, self._changed = motion_of(parameters), 0.0, -math.inf
        self._approach: _Approach | None = None
        self._to_position = False  # whether that leads to the ``position`` that was asked for

    def check(self, parameters: TargetParameters) -> None:
        """Whether other parameters can be taken.

        Args:
            parameters: All of them.

        Raises:
            ParameterError: As of :func:`motion_of`, or one differs that is fixed.
        """
        refuse_fixed(self.parameters, parameters, "while the target moves")
        motion_of(parameters)

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
            moved = parameters.position != self.parameters.position
            on_its_way = self._to_position and time < self._began
            self._begin(time, parameters, moved or on_its_way)
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

    def go_back(self, time: float, before: float) -> None:
        """Take note that time has gone back: a motion that was taken up later goes on from now.

        Args:
            time: Now, since the target's start in [s].
            before: What it was until now, likewise.
        """
        if time < self._changed:
            self._began += time - before
            self._changed += time - before

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

        Raises:
            SimulationError: The motion fails, or does not give three finite numbers.
        """
        time = max(time, self._changed)
        if self._approach and time < self._began:
            return self._approach.start + self._approach.velocity * (time - self._changed)
        return self._asked("position", time)

    def velocity(self, time: float) -> NDArray[np.float64]:
        """True velocity in ``map``, shape (3,), in [m/s].

        Args:
            time: Since the target's start in [s]; before the last change it is that of then.

        Raises:
            SimulationError: The motion fails, or does not give three finite numbers.
        """
        time = max(time, self._changed)
        if self._approach and time < self._began:
            return self._approach.velocity.copy()
        return self._asked("velocity", time)

    def _asked(self, what: str, time: float) -> NDArray[np.float64]:
        """Position or velocity of the motion, which may be anybody's."""
        name = self.parameters.motion
        try:
            value = getattr(self._motion, what)(time - self._began)
        except Exception as error:  # whatever it raises
            why = f"{type(error).__name__}: {error}"
            raise SimulationError(
                f"at {time:g} s the target motion {name!r} failed: {why}"
            ) from error
        if np.shape(value) != (3,) or not np.isfinite(value).all():
            raise SimulationError(
                f"at {time:g} s the {what} of the target motion {name!r} is {value}, "
                "must be three finite numbers"
            )
        return np.asarray(value)

    def _begin(self, time: float, parameters: TargetParameters, elsewhere: bool) -> None:
        """Take up a motion; ``elsewhere`` if it is to begin at its ``position``."""
        place, velocity = self.position(time), self.velocity(time)
        wanted = motion_of(parameters).starting(parameters, place, velocity)
        if elsewhere and wanted.position != parameters.position:
            wanted = parameters
        motion = motion_of(wanted)
        way, speed = motion.position(0.0) - place, parameters.speed or GOING_SPEED
        duration = float(np.linalg.norm(way)) / speed
        self._approach = _Approach(place, way / max(duration, 1e-12))
        self._to_position = elsewhere
        self._motion, self._began, self._changed = motion, time + duration, time


def _motion_alone(parameters: TargetParameters) -> dict[str, object]:
    """What of the parameters is about the motion, by name."""
    return {name: value for name, value in asdict(parameters).items() if name not in MEASURED}


class TargetSensor:
    """Measures the position of the target and delivers what it measured.

    Noise and dropouts are drawn from their own seeds: a dropout does not change the noise of the
    measurements that arrive.

    Args:
        parameters: Noise, dropouts and delay.
        motion: Of the target.
    """

    def __init__(self, parameters: TargetParameters, motion: TargetMotion | SteeredTarget) -> None:
        self._parameters = parameters
        self._motion = motion
        self._noise = np.random.default_rng(parameters.seed)
        self._dropouts = np.random.default_rng([parameters.seed, 1])
        self._on_the_way: deque[tuple[float, NDArray[np.float64]]] = deque()

    def change(self, parameters: TargetParameters) -> None:
        """Measure with other noise and dropouts from now on.

        Args:
            parameters: All of them; seed and delay stay those of the start.
        """
        self._parameters = parameters

    def measure(self, time: float) -> None:
        """Measure; the result is delivered later.

        Args:
            time: Since the target's start in [s].
        """
        while self._on_the_way and self._on_the_way[-1][0] >= time:
            self._on_the_way.pop()  # the clock went back
        noise = self._parameters.noise * self._noise.standard_normal(3)
        if self._dropouts.random() >= self._parameters.dropout:
            self._on_the_way.append((time, self._motion.position(time) + noise))

    def delivered(self, time: float) -> list[tuple[float, NDArray[np.float64]]]:
        """What has arrived and was not delivered before.

        Args:
            time: Now, since the target's start in [s].

        Returns:
            (time of measuring in [s], position in ``map``, shape (3,), in [m]) of each.
        """
        arrived = []
        while self._on_the_way and (
            self._on_the_way[0][0] + self._parameters.delay <= time + 1e-9  # rounding
        ):
            arrived.append(self._on_the_way.popleft())
        return arrived
