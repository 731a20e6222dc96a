r"""Lag, dead time and gain of one channel by maximum likelihood over a whole record.

Measured are the integral of the rate (heading, path angle, airspeed) and, perhaps, the rate:

.. math:: y = y_0 + b t + G \int \omega + e_y, \qquad \dot y = b_\omega + G \omega + e_\omega

with the response :math:`\omega` of :mod:`~uav_tracking_mpc.studies.identification.channel_response`
and autoregressive noise e. For each lag and dead time the rest is linear and solved for at once;
lag and dead time are found on a grid, for there may be several minima, and then refined
(G. Golub, V. Pereyra, SIAM J. Numer. Anal. 10, 1973: variable projection).
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from uav_tracking_mpc.studies.identification.channel_record import SPEED, ChannelRecord
from uav_tracking_mpc.studies.identification.channel_response import HeldDemand
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
        coefficients: (G, b, y_0) and b_omega where the rate is measured, shape (3,) or (4,).
    """

    misfit: float
    gain: float
    gain_variance: float
    coefficients: NDArray[np.float64]


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
        noise: Of each output.
    """

    def __init__(self, record: ChannelRecord, demand: NDArray[np.float64]) -> None:
        self.record = record
        self._demand = HeldDemand(record.demand._replace(value=demand))
        least = LEAST_SPEED_NOISE if record.name == SPEED else LEAST_ANGLE_NOISE
        self._least = (least, LEAST_RATE_NOISE)
        self._outputs = [record.state] + ([] if record.rate is None else [record.rate])
        self._middle = float(np.mean(record.state.time))
        spread = max(float(np.std(record.state.value)), least)
        self.noise = [NoiseModel(np.ones(1), spread) for _ in self._outputs]
        self._rates = lru_cache(maxsize=len(LAGS) + 8)(self._demand.rates_at_steps)

    def columns(self, lag: float, dead_time: float) -> list[NDArray[np.float64]]:
        """What the coefficients multiply: a matrix for each output, shape (n, 3) or (n, 4).

        Args:
            lag: tau in [s].
            dead_time: D in [s].
        """
        rates = self._rates(lag)
        found = []
        for index, output in enumerate(self._outputs):
            rate, integral = self._demand.response(output.time, lag, dead_time, rates)
            nothing, one = np.zeros_like(rate), np.ones_like(rate)
            if index == 0:
                columns = [integral, output.time - self._middle, one, nothing]
            else:
                columns = [rate, nothing, nothing, one]
            found.append(np.column_stack(columns[: 2 + len(self._outputs)]))
        return found

    def solve(self, lag: float, dead_time: float) -> Solved:
        """The best gain and offsets for a lag and a dead time.

        Args:
            lag: tau in [s].
            dead_time: D in [s].
        """
        matrix, right = self._whitened(lag, dead_time)
        scale = np.linalg.norm(matrix, axis=0) + 1e-300
        scaled = matrix / scale
        inverse = np.linalg.pinv(scaled.T @ scaled, hermitian=True)
        coefficients = inverse @ (scaled.T @ right)
        residuals = right - scaled @ coefficients
        coefficients = coefficients / scale
        variance = float(inverse[0, 0] / scale[0] ** 2)
        return Solved(float(residuals @ residuals), float(coefficients[0]), variance, coefficients)

    def _whitened(
        self, lag: float, dead_time: float
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        columns = self.columns(lag, dead_time)
        matrix = [n.whitened(c) for n, c in zip(self.noise, columns, strict=True)]
        right = [n.whitened(o.value) for n, o in zip(self.noise, self._outputs, strict=True)]
        return np.concatenate(matrix), np.concatenate(right)

    def run(self) -> ChannelFit:
        """Find lag, dead time and noise."""
        starts: list[tuple[float, float]] = []
        for anywhere in ROUNDS:
            if anywhere:
                starts = self._grid()
            self._refine(starts)
            starts = [(self.lag, self.dead_time)]
            columns = self.columns(self.lag, self.dead_time)
            residuals = [
                output.value - matrix @ self.solved.coefficients
                for output, matrix in zip(self._outputs, columns, strict=True)
            ]
            self.noise = [
                noise_of(left - np.mean(left), least)
                for left, least in zip(residuals, self._least, strict=False)
            ]
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

    def fitted(self) -> NDArray[np.float64]:
        """The fitted integral at the times of ``record.state``, shape (n,)."""
        return self.columns(self.lag, self.dead_time)[0] @ self.solved.coefficients

    def flown_rate(self) -> NDArray[np.float64]:
        """The fitted rate at these times, shape (n,), in [rad/s] or [m/s^2]."""
        rates = self._rates(self.lag)
        time = self.record.state.time
        rate, _ = self._demand.response(time, self.lag, self.dead_time, rates)
        return self.solved.gain * rate

    @property
    def count(self) -> int:
        """How many values were fitted."""
        return sum(len(output.time) for output in self._outputs)


def _simplex(lag: float, dead_time: float) -> list[tuple[float, float]]:
    """Where the search begins: along the valley, in which the sum of both is the same."""
    other = 0.02 if lag < LAG_MAX - 0.02 else -0.02
    return [(lag, dead_time), (lag + other, max(dead_time - other, 0.0)), (lag, dead_time + 0.02)]
