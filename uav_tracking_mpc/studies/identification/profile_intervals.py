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

"""Confidence intervals by the profile of the likelihood."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

from scipy.optimize import brentq, minimize_scalar
from scipy.stats import chi2

from uav_tracking_mpc.studies.identification.channel_fit import (
    DEAD_TIME_MAX,
    LAG_MAX,
    ChannelFit,
    Solved,
)

CONFIDENCE = 0.95  # -, confidence of the intervals
UNKNOWNS = 6  # that are fitted
FIRST_STEP = 0.01  # s, outwards from the best value
PRECISION = 2e-4  # s, tolerance of an interval's ends


class Estimate(NamedTuple):
    """A value and its confidence interval, all in the same unit.

    Attributes:
        value: The best, in [s] or [-].
        lower: End of the interval, in [s] or [-].
        upper: Its other end, in [s] or [-].
    """

    value: float
    lower: float
    upper: float

    def holds(self, truth: float) -> bool:
        """Whether a value is in the interval.

        Args:
            truth: The value, in [s] or [-].
        """
        return self.lower <= truth <= self.upper


class Estimates(NamedTuple):
    """What is known of a channel.

    Attributes:
        lag: tau in [s].
        dead_time: D in [s].
        total: Their sum in [s]: by how much a slow demand is late.
        gain: G [-].
    """

    lag: Estimate
    dead_time: Estimate
    total: Estimate
    gain: Estimate


def estimates(fit: ChannelFit) -> Estimates:
    """Best values and intervals of a fit.

    Args:
        fit: That has been run.
    """
    return _Profile(fit).estimates()


class _Profile:
    """The misfit about the best fit; remembers every point that was tried."""

    def __init__(self, fit: ChannelFit) -> None:
        self._fit = fit
        self._tried: list[Solved] = [fit.solved]
        self._total = fit.lag + fit.dead_time

    def estimates(self) -> Estimates:
        fit = self._fit
        # Less than 1 where the noise is less than what is assumed at least.
        self._variance = max(fit.solved.misfit / (fit.count - UNKNOWNS), 1.0)
        self._allowed = fit.solved.misfit + self._variance * float(chi2.ppf(CONFIDENCE, 1))
        lag = self._interval(fit.lag, LAG_MAX, self._at_lag)
        dead_time = self._interval(fit.dead_time, DEAD_TIME_MAX, self._at_dead_time)
        total = self._interval(self._total, LAG_MAX + DEAD_TIME_MAX, self._at_total)
        return Estimates(lag, dead_time, total, self._gain())

    def _at_lag(self, lag: float) -> float:
        """Least misfit with this lag."""
        about = self._total - lag
        reach = 0.05 + abs(lag - self._fit.lag)
        return self._least(lambda dead_time: (lag, dead_time), about, reach, DEAD_TIME_MAX)

    def _at_dead_time(self, dead_time: float) -> float:
        about = self._total - dead_time
        reach = 0.05 + 2.0 * abs(dead_time - self._fit.dead_time)
        return self._least(lambda lag: (lag, dead_time), about, reach, LAG_MAX)

    def _at_total(self, total: float) -> float:
        about = self._fit.lag + (total - self._total)
        most = min(total, LAG_MAX)
        return self._least(lambda lag: (lag, max(total - lag, 0.0)), about, 0.5 * total, most)

    def _least(
        self, point: Callable[[float], tuple[float, float]], about: float, reach: float, most: float
    ) -> float:
        """Least misfit along a line of points, within the reach about a place on it."""
        low, high = max(about - reach, 0.0), min(max(about, 0.0) + reach, most)

        def misfit(place: float) -> float:
            solved = self._fit.solve(*point(float(place)))
            self._tried.append(solved)
            return solved.misfit

        if high - low < PRECISION:
            return misfit(low)
        found = minimize_scalar(
            misfit, bounds=(low, high), method="bounded", options={"xatol": PRECISION}
        )
        # The search never tries the ends themselves, where a lag or a dead time is 0.
        return float(min(found.fun, misfit(low))) if low == 0.0 else float(found.fun)

    def _interval(self, best: float, most: float, profile: Callable[[float], float]) -> Estimate:
        ends = []
        for bound in (0.0, most):
            inside, step = best, FIRST_STEP
            while True:
                outside = max(best - step, 0.0) if bound == 0.0 else min(best + step, most)
                if profile(outside) > self._allowed:
                    end = (
                        brentq(
                            lambda value: profile(value) - self._allowed,
                            *sorted((inside, outside)),
                            xtol=PRECISION,
                        )
                        if profile(inside) < self._allowed
                        else inside
                    )
                    break
                if outside == bound:
                    end = bound
                    break
                inside, step = outside, 2.0 * step
            ends.append(float(end))
        return Estimate(best, *ends)

    def _gain(self) -> Estimate:
        """Of all the points tried: those that line the region allowed are among them."""
        lower = upper = self._fit.solved.gain
        for solved in self._tried:
            room = self._allowed - solved.misfit
            if room > 0.0:
                reach = math.sqrt(room * solved.gain_variance)
                lower, upper = min(lower, solved.gain - reach), max(upper, solved.gain + reach)
        return Estimate(self._fit.solved.gain, lower, upper)
