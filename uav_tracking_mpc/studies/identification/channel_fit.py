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

r"""Lag, dead time, gain and limits of one channel by maximum likelihood, with intervals.

The response to a demand that is held from step to step is exact:

.. math:: \tau \dot\omega(t) = u(t - D) - \omega(t), \qquad
          \int \omega = \int u(t - D) - \tau \omega(t) + \mathrm{const}

The second one follows from the first and needs no integration of its own. A dead time moves the
response as a whole, so that the rates at the steps belong to the lag alone.

Measured are the integral of the rate (heading, path angle, airspeed) and, perhaps, the rate:

.. math:: y = y_0 + b t + G \int \omega + e_y, \qquad \dot y = b_\omega + G \omega + e_\omega

with autoregressive noise e. Sensor noise is white; gusts, and whatever else the model does not
describe, are not. Least squares on residuals made white by :math:`A(q) e` is maximum likelihood for
both, and its intervals hold (L. Ljung, System Identification, 2nd ed., 1999, sections 7.4 and
10.3). Commands answer to measured noise; with the noise described, that does not bias the fit
(section 13.4). For each lag and dead time the rest is linear and solved for at once; lag and dead
time are found on a grid, for there may be several minima, and then refined (G. Golub, V. Pereyra,
SIAM J. Numer. Anal. 10, 1973: variable projection).

A turn is limited by the bank that it needs, the other channels by the rate itself. On each side the
limit is sought that explains the record best; it counts where it explains it much better than none.

A confidence interval holds every value with which the record is hardly less likely than with the
best one, all other unknowns being fitted anew (W. Meeker, L. Escobar, The American Statistician 49,
1995):

.. math:: J(\theta) - J_{min} \le \chi^2_1(0.95) \, \max(1, J_{min} / (n - k))

Lag and dead time are nearly interchangeable, neither is negative, and the misfit is not smooth in
the dead time, so intervals from second derivatives would be wrong; these need none.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_toeplitz
from scipy.optimize import minimize
from scipy.signal import lfilter

from uav_tracking_mpc.dynamics.vehicle import followed
from uav_tracking_mpc.studies.identification.flight_record import SPEED, ChannelRecord, Samples


class HeldDemand:
    """A demand that is held from each of its steps to the next.

    Args:
        demand: Its steps.
    """

    def __init__(self, demand: Samples) -> None:
        self._time, self._value = demand
        self._durations = np.diff(self._time)
        self._integral = np.concatenate([[0.0], np.cumsum(self._value[:-1] * self._durations)])

    def rates_at_steps(self, lag: float) -> NDArray[np.float64]:
        """Rate at each step without dead time, shape (m,); at the first it is what is demanded.

        Args:
            lag: tau in [s].
        """
        share = np.broadcast_to(followed(self._durations, lag), self._durations.shape)
        factors = np.concatenate([[0.0], 1.0 - share])
        rates = np.concatenate([self._value[:1], self._value[:-1] * share])
        # x_k = a_k x_(k-1) + b_k for all k at once: the maps are composed over 1, 2, 4, ... steps.
        reach = 1
        while reach < len(rates):
            rates[reach:] = rates[reach:] + factors[reach:] * rates[:-reach]
            factors[reach:] = factors[reach:] * factors[:-reach]
            reach *= 2
        return rates

    def response(
        self, time: NDArray[np.float64], lag: float, dead_time: float, rates: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Rate and its integral, but for a constant, each of the shape of the times.

        Args:
            time: Not before the first demand, in [s], shape (n,).
            lag: tau in [s].
            dead_time: D in [s].
            rates: As of :meth:`rates_at_steps` for this lag, shape (m,).
        """
        shifted = time - dead_time
        step = np.maximum(np.searchsorted(self._time, shifted, side="right") - 1, 0)
        since = np.maximum(shifted - self._time[step], 0.0)
        demanded = self._value[step]
        rate = rates[step] + (demanded - rates[step]) * followed(since, lag)
        return rate, self._integral[step] + demanded * since - lag * rate


ORDERS = (0, 1, 2, 4, 8, 16)  # samples, tried


class NoiseModel(NamedTuple):
    """Autoregressive noise.

    Attributes:
        polynomial: A(q), from 1 on, shape (p + 1,).
        deviation: Of the white noise behind it, in [rad], [rad/s] or [m/s] as the residuals.
    """

    polynomial: NDArray[np.float64]
    deviation: float

    def whitened(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Values filtered and scaled to noise of unit variance, without the first p ones.

        Args:
            values: Along the first axis, shape (n,) or (n, k).

        Returns:
            Shape (n - p,) or (n - p, k).
        """
        order = len(self.polynomial) - 1
        return lfilter(self.polynomial, [1.0], values, axis=0)[order:] / self.deviation


def noise_of(residuals: NDArray[np.float64], least: float) -> NoiseModel:
    """The noise that explains residuals best, by the Bayesian information criterion.

    Args:
        residuals: Of any mean, shape (n,).
        least: Deviation that is assumed at least, in [rad], [rad/s] or [m/s]: no sensor is exact.
    """
    count, residuals = len(residuals), residuals - np.mean(residuals)
    covariance = np.array(
        [residuals[lag:] @ residuals[: count - lag] / count for lag in range(ORDERS[-1] + 1)]
    )
    if covariance[0] <= least**2:
        return NoiseModel(np.ones(1), least)
    best, chosen = np.inf, NoiseModel(np.ones(1), 1.0)
    for order in ORDERS:
        later = covariance[1 : order + 1]
        weights = solve_toeplitz(covariance[:order], later) if order else later
        variance = max(covariance[0] - weights @ later, least**2)
        criterion = count * np.log(variance) + order * np.log(count)
        if criterion < best:
            polynomial = np.concatenate([[1.0], -weights])
            best, chosen = criterion, NoiseModel(polynomial, float(np.sqrt(variance)))
    return chosen


LAG_MAX, DEAD_TIME_MAX = 3.0, 2.0  # s
LAGS = np.concatenate([[0.0], np.geomspace(0.02, LAG_MAX, 16)])  # s, of the grid
DEAD_TIMES = np.concatenate([np.arange(0.0, 0.6, 0.05), np.arange(0.6, 2.01, 0.1)])  # s
STARTS = 3  # points of the grid from which the search begins
ROUNDS = (True, True, False, False)  # of fit and noise: whether on the whole grid
REFINED = {"xatol": 1e-5, "fatol": 1e-6, "maxfev": 200}  # s, -, -: tolerance of Nelder-Mead
# rad, rad/s, m/s: least noise. No sensor is better.
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
        # The state answers with the integral of the rate, the second of the two.
        return [
            self._demand.response(output.samples.time, lag, dead_time, rates)[part]
            for output, part in zip(self._outputs, (1, 0), strict=False)
        ]

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
            fitted = zip(self._outputs, self._fitted(), self._least, strict=False)
            self.describe(
                [noise_of(each.samples.value - fit, least) for each, fit, least in fitted]
            )
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


SHARES = np.linspace(0.3, 0.98, 35)  # -, of the greatest demand, tried as its limit
NEARBY = np.linspace(0.92, 1.08, 17)  # -, of a limit that was found, tried in its place
ROUNDS_SATURATION = 3  # in which limits and the rest are made to agree
CONVINCING = 30.0  # -, ratio by which the misfit must fall; by chance it falls by a few


class Limits(NamedTuple):
    """Limits of what is demanded, times its leverage; infinite where none shows.

    Attributes:
        lower: In [rad/s], [m/s^2] or, in a turn, tan(bank) [-].
        upper: In the same unit, [rad/s], [m/s^2] or [-].
    """

    lower: float = -np.inf
    upper: float = np.inf

    def kept(self, record: ChannelRecord) -> NDArray[np.float64]:
        """The demand inside the limits, shape (m,), in [rad/s] or [m/s^2].

        Args:
            record: With the demand.
        """
        lever = record.leverage
        return np.clip(record.demand.value * lever, self.lower, self.upper) / lever


def limited_fit(record: ChannelRecord) -> tuple[ChannelFit, Limits]:
    """The fit of a channel, and the limits that it shows.

    Args:
        record: Of the channel.
    """
    limits = Limits()
    fit = ChannelFit(record, record.demand.value).run()
    for _ in range(ROUNDS_SATURATION):
        found = _better(fit, limits)
        if found == limits:
            break
        limits = found
        fit = ChannelFit(record, limits.kept(record)).run()
    return fit, limits


def _better(fit: ChannelFit, limits: Limits) -> Limits:
    """Limits that explain the record much better than those before, else these.

    Both sides are tried together first: a test signal that is symmetric passes both.
    """
    levered = fit.record.demand.value * fit.record.leverage
    least, most = min(float(np.min(levered)), 0.0), max(float(np.max(levered)), 0.0)
    if limits == Limits():
        limits = _best(fit, limits, [Limits(share * least, share * most) for share in SHARES])
    for side, extreme in (("upper", most), ("lower", least)):
        known = getattr(limits, side)
        places = NEARBY * known if np.isfinite(known) else SHARES * extreme
        limits = _best(fit, limits, [limits._replace(**{side: float(each)}) for each in places])
        without = limits._replace(**{side: getattr(Limits(), side)})
        if _misfit(fit, without) < _misfit(fit, limits) + CONVINCING:
            limits = without
    return limits


def _best(fit: ChannelFit, limits: Limits, tried: list[Limits]) -> Limits:
    """The best of some limits, if it is much better or moves one that is known."""
    misfits = [_misfit(fit, candidate) for candidate in tried]
    best = tried[int(np.argmin(misfits))]
    more = np.isfinite(best).sum() > np.isfinite(limits).sum()
    needed = CONVINCING if more else 0.0
    return best if min(misfits) < _misfit(fit, limits) - needed else limits


def _misfit(fit: ChannelFit, limits: Limits) -> float:
    """Of the same lag, dead time and noise with other limits."""
    other = ChannelFit(fit.record, limits.kept(fit.record))
    other.describe(fit.noise)
    return other.solve(fit.lag, fit.dead_time).misfit
