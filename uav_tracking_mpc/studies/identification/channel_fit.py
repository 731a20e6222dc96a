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

r"""Lag, dead time and gain of one channel by maximum likelihood over a whole record.

Measured are the integral of the rate (heading, path angle, airspeed) and, perhaps, the rate:

.. math:: y = y_0 + b t + G \int \omega + e_y, \qquad \dot y = b_\omega + G \omega + e_\omega

with the response :math:`\omega` of :mod:`~uav_tracking_mpc.studies.identification.held_demand`
and autoregressive noise e. For each lag and dead time the rest is linear and solved for at once;
lag and dead time are found on a grid, for there may be several minima, and then refined
(G. Golub, V. Pereyra, SIAM J. Numer. Anal. 10, 1973: variable projection).
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from uav_tracking_mpc.studies.identification.channel_record import SPEED, ChannelRecord, Samples
from uav_tracking_mpc.studies.identification.held_demand import HeldDemand
from uav_tracking_mpc.studies.identification.noise_model import NoiseModel, noise_of

LAG_MAX, DEAD_TIME_MAX = 3.0, 2.0  # s
LAGS = np.concatenate([[0.0], np.geomspace(0.02, LAG_MAX, 16)])  # of the grid in [s]
DEAD_TIMES = np.concatenate([np.arange(0.0, 0.6, 0.05), np.arange(0.6, 2.01, 0.1)])  # in [s]
STARTS = 3  # points of the grid from which the search begins
ROUNDS = (True, True, False, False)  # of fit and noise: whether on the whole grid
REFINED = {"xatol": 1e-5, "fatol": 1e-6, "maxfev": 200}
# No sensor is better: 0.01 deg of attitude, 0.1 deg/s of rate, 0.01 m/s of airspeed.
LEAST_ANGLE_NOISE, LEAST_RATE_NOISE, LEAST_SPEED_NOISE = 2e-4, 2e-3, 1e-2


class Solved(NamedTuple):
    """The best fit for one lag and dead time.

    Attributes:
        misfit: Sum of squares of the residuals made white [-].
        gain: G [-].
        gain_variance: Of the gain with lag and dead time given [-].
    """

    misfit: float
    gain: float
    gain_variance: float


class _Output:
    """What was measured of one quantity; offset and drift are fitted to it beside the response."""

    def __init__(self, samples: Samples, offsets: NDArray[np.float64], noise: NoiseModel) -> None:
        self.samples, self._offsets = samples, offsets
        self.describe(noise)

    def describe(self, noise: NoiseModel) -> None:
        """Weigh the measurements by this noise."""
        self.noise = noise
        self._basis, self._triangle = np.linalg.qr(noise.whitened(self._offsets))
        self._measured = noise.whitened(self.samples.value)
        self.measured = self._less_offsets(self._measured)

    def _less_offsets(self, white: NDArray[np.float64]) -> NDArray[np.float64]:
        return white - self._basis @ (self._basis.T @ white)

    def response(self, response: NDArray[np.float64]) -> NDArray[np.float64]:
        """A response made white, less what the offsets explain of it."""
        return self._less_offsets(self.noise.whitened(response))

    def fitted(self, response: NDArray[np.float64]) -> NDArray[np.float64]:
        """A response with the offsets that fit best."""
        left = self._basis.T @ (self._measured - self.noise.whitened(response))
        return response + self._offsets @ np.linalg.solve(self._triangle, left)


class ChannelFit:
    """A channel's record and what is known of its noise.

    Args:
        record: What was demanded and measured.
        demand: What the aircraft made of the demand, shape (m,), in [rad/s] or [m/s^2]: it has
            its limits.

    Attributes:
        record: As above.
        lag: tau in [s], the best.
        dead_time: D in [s], the best.
        solved: The rest, with them.
    """

    def __init__(self, record: ChannelRecord, demand: NDArray[np.float64]) -> None:
        self.record = record
        self._demand = HeldDemand(record.demand._replace(value=demand))
        least = LEAST_SPEED_NOISE if record.name == SPEED else LEAST_ANGLE_NOISE
        self._least = (least, LEAST_RATE_NOISE)
        time, value = record.state
        slope_and_level = np.column_stack([time - np.mean(time), np.ones(len(time))])
        white = NoiseModel(np.ones(1), max(float(np.std(value)), least))
        self._outputs = [_Output(record.state, slope_and_level, white)]
        if record.rate is not None:
            self._outputs.append(_Output(record.rate, np.ones((len(record.rate.time), 1)), white))
        self._rates = lru_cache(maxsize=len(LAGS) + 8)(self._demand.rates_at_steps)

    @property
    def noise(self) -> list[NoiseModel]:
        """Of each output."""
        return [output.noise for output in self._outputs]

    def describe(self, noise: Sequence[NoiseModel]) -> None:
        """Take this noise of the outputs for known.

        Args:
            noise: Of each.
        """
        for output, described in zip(self._outputs, noise, strict=True):
            output.describe(described)

    def _responses(self, lag: float, dead_time: float) -> list[NDArray[np.float64]]:
        """Of each output to the demand, with gain 1."""
        rates = self._rates(lag)
        found = []
        for index, output in enumerate(self._outputs):
            rate, integral = self._demand.response(output.samples.time, lag, dead_time, rates)
            found.append(rate if index else integral)
        return found

    def solve(self, lag: float, dead_time: float) -> Solved:
        """The best gain and offsets for a lag and a dead time.

        Args:
            lag: tau in [s].
            dead_time: D in [s].
        """
        squares = products = total = 0.0
        for output, response in zip(self._outputs, self._responses(lag, dead_time), strict=True):
            column = output.response(response)
            squares += float(column @ column)
            products += float(column @ output.measured)
            total += float(output.measured @ output.measured)
        gain = products / squares if squares > 0.0 else 0.0
        variance = 1.0 / squares if squares > 0.0 else np.inf
        return Solved(max(total - gain * products, 0.0), gain, variance)

    def run(self) -> ChannelFit:
        """Find lag, dead time and noise."""
        starts: list[tuple[float, float]] = []
        for anywhere in ROUNDS:
            if anywhere:
                starts = self._grid()
            self._refine(starts)
            starts = [(self.lag, self.dead_time)]
            noise = []
            for output, fitted, least in zip(
                self._outputs, self._fitted(), self._least, strict=False
            ):
                left = output.samples.value - fitted
                noise.append(noise_of(left - np.mean(left), least))
            self.describe(noise)
        self._refine(starts)
        return self

    def _grid(self) -> list[tuple[float, float]]:
        """The best lags and dead times of the grid with the present noise."""
        points = [(lag, dead_time) for lag in LAGS.tolist() for dead_time in DEAD_TIMES.tolist()]
        return sorted(points, key=lambda point: self.solve(*point).misfit)[:STARTS]

    def _refine(self, starts: list[tuple[float, float]]) -> None:
        """The best lag and dead time near some with the present noise."""
        best = np.inf
        for lag, dead_time in starts:
            found = minimize(
                lambda point: self.solve(float(point[0]), float(point[1])).misfit,
                (lag, dead_time),
                method="Nelder-Mead",
                bounds=((0.0, LAG_MAX), (0.0, DEAD_TIME_MAX)),
                options={**REFINED, "initial_simplex": _simplex(lag, dead_time)},
            )
            if found.fun < best:
                best = float(found.fun)
                self.lag, self.dead_time = (float(value) for value in found.x)
        self.solved = self.solve(self.lag, self.dead_time)

    def _fitted(self) -> list[NDArray[np.float64]]:
        responses = self._responses(self.lag, self.dead_time)
        return [
            output.fitted(self.solved.gain * response)
            for output, response in zip(self._outputs, responses, strict=True)
        ]

    def fitted(self) -> NDArray[np.float64]:
        """The fitted integral at the times of ``record.state``, shape (n,)."""
        return self._fitted()[0]

    def flown_rate(self) -> NDArray[np.float64]:
        """The fitted rate at these times, shape (n,), in [rad/s] or [m/s^2]."""
        rates = self._rates(self.lag)
        time = self.record.state.time
        rate, _ = self._demand.response(time, self.lag, self.dead_time, rates)
        return self.solved.gain * rate

    @property
    def count(self) -> int:
        """How many values were fitted."""
        return sum(len(output.samples.time) for output in self._outputs)


def _simplex(lag: float, dead_time: float) -> list[tuple[float, float]]:
    """Where the search begins: along the valley, in which the sum of both is the same."""
    other = 0.02 if lag < LAG_MAX - 0.02 else -0.02
    return [(lag, dead_time), (lag + other, max(dead_time - other, 0.0)), (lag, dead_time + 0.02)]
