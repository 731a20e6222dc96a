"""How the target's position is measured: with noise, not always, and known only later."""

from __future__ import annotations

from collections import deque

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.simulation.target_motion import TargetParameters, target_position


class TargetSensor:
    """Measures the position of the target and delivers what it measured.

    Noise and dropouts are drawn from their own seeds: a dropout does not change the noise of the
    measurements that arrive.

    Args:
        parameters: Motion and measurement.
    """

    def __init__(self, parameters: TargetParameters) -> None:
        self._parameters = parameters
        self._noise = np.random.default_rng(parameters.seed)
        self._dropouts = np.random.default_rng([parameters.seed, 1])
        self._on_the_way: deque[tuple[float, NDArray[np.float64]]] = deque()

    def measure(self, time: float) -> None:
        """Measure at ``time`` [s] since the target's start; the result is delivered later."""
        while self._on_the_way and self._on_the_way[-1][0] >= time:
            self._on_the_way.pop()  # the clock went back: not measured yet
        noise = self._parameters.noise * self._noise.standard_normal(3)
        if self._dropouts.random() >= self._parameters.dropout:
            self._on_the_way.append((time, target_position(self._parameters, time) + noise))

    def delivered(self, time: float) -> list[tuple[float, NDArray[np.float64]]]:
        """What has arrived by ``time`` [s] and was not delivered before.

        Returns:
            (time of measuring in [s], position in ``map``, shape (3,), in [m]) of each.
        """
        arrived = []
        while self._on_the_way and (
            self._on_the_way[0][0] + self._parameters.delay <= time + 1e-9  # rounding
        ):
            arrived.append(self._on_the_way.popleft())
        return arrived
