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

r"""How noisy a signal is: white noise apart from what wanders.

A signal that is a random walk of intensity q under white noise of variance R changes over a time t
by a difference of variance

.. math:: E[(x(s + t) - x(s))^2] = 2 R + q t,

so that the differences over one sample and over several tell both apart.

What the source tells of the noise counts until it is measured, and then for how it changes: a
source that tells a hundred times the variance from one sample to the next is believed at once, as
much as it was right before.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.typing import NDArray

SAMPLES = 16  # of the longer difference
MEMORY = 40.0  # s, of the noise of an aircraft's sensors and of gusts
PRIOR_TIME = 1.0  # s of samples that what is taken at first counts for
MEASURED_TIME = 2.0  # s of samples after which the noise that is measured counts, not that told
LONGEST_GAP = 1.0  # s between samples beyond which the signal begins anew
HEAD = 3  # of the times that come first, both in the state and in what a sample is compared with


@dataclass(frozen=True)
class Signal:
    """A signal with equal noise on each of its components.

    Attributes:
        size: How many components.
        deviation: Standard deviation of the noise that is taken before anything is known, in the
            signal's unit [SI].
        walk: q that is taken before anything is known, in the square of the unit [SI] per s.
    """

    size: int
    deviation: float
    walk: float = 0.0


class NoiseMeters:
    """White noise and random walk of signals that are sampled together, averaged over time.

    :meth:`begin`, then the expression :meth:`metered` evaluated, then :meth:`keep`.

    Args:
        signals: What is sampled.
        memory: Time constant of the averages in [s].

    Attributes:
        state: What is known, shape (k,): weight [s] and times [s] of the averages, then for all
            signals the mean squares of the short and of the long differences, the averages and the
            newest of the variances that are told, and the variances that hold.
        compared: What a sample is compared with, shape (m,): whether there is anything (1 or 0),
            times [s] since the sample before and since the oldest, and both samples.
    """

    def __init__(self, signals: Sequence[Signal], memory: float) -> None:
        self._signals, self._memory = tuple(signals), memory
        self.components = sum(signal.size for signal in signals)
        self.state = np.zeros(HEAD + 5 * len(signals))
        self.compared = np.zeros(HEAD + 2 * self.components)
        self._times = np.zeros(SAMPLES)
        self._samples = np.zeros((SAMPLES, self.components))
        self.reset()

    def reset(self) -> None:
        """Forget the signals and their noise."""
        self._count, self._time = 0, 0.0
        variances = np.square([signal.deviation for signal in self._signals])
        walks = np.array([signal.walk for signal in self._signals])
        untold, head = 0.0 * variances, (PRIOR_TIME, 0.0, 1.0)
        short = 2.0 * variances
        self.state[:] = [*head, *short, *(short + walks), *untold, *untold, *variances]

    def begin(self, time: float) -> None:
        """Prepare what the next sample is compared with.

        Args:
            time: Of the sample in [s].
        """
        if self._count and not 0.0 < time - self._time < LONGEST_GAP:
            self._count = 0
        compared = self.compared
        compared[0] = complete = self._count >= SAMPLES
        if complete:
            row, width = self._count % SAMPLES, HEAD + self.components
            compared[1], compared[2] = time - self._time, time - self._times[row]
            compared[HEAD:width], compared[width:] = self._samples[row - 1], self._samples[row]
        self._time = time

    def keep(self, sample: NDArray[np.float64]) -> None:
        """Keep the sample that has been compared.

        Args:
            sample: All components of all signals, shape (n,), in their units [SI].
        """
        row = self._count % SAMPLES
        self._times[row], self._samples[row] = self._time, sample
        self._count += 1

    def metered(
        self, state: ca.SX, compared: ca.SX, sample: ca.SX, told: ca.SX
    ) -> tuple[ca.SX, ca.SX]:
        """State after a sample, and variances R of its noise, as expressions.

        Args:
            state: As ``NoiseMeters.state``.
            compared: As ``NoiseMeters.compared``.
            sample: All components of all signals, shape (n,).
            told: Variance of each signal's noise by its source, averaged over the components, in
                the square of the unit [SI]; 0 where it tells none: what it told last then holds.
        """
        count, width = len(self._signals), self.components
        counted, short_step, long_step = compared[0], compared[1], compared[2]
        short, long, average, before, held = ca.vertsplit(state[HEAD:], count)
        told = ca.if_else(told > 0.0, told, before)
        average = ca.if_else(average > 0.0, average, told)
        early = state[0] < PRIOR_TIME + MEASURED_TIME
        held = ca.if_else(ca.logic_and(told > 0.0, early), told, held)
        weight = ca.fmin(state[0] + counted * short_step, self._memory)
        share = counted * short_step / weight
        short_time = state[1] + share * (short_step - state[1])
        long_time = state[2] + share * (long_step - state[2])
        latest, oldest = ca.vertsplit(compared[HEAD:], width)
        short += share * (self._mean_squares(sample - latest) - short)
        long += share * (self._mean_squares(sample - oldest) - long)
        average += share * (told - average)
        walk = _walks(short, long, long_time - short_time)
        measured = 0.5 * ca.fmax(short - walk * short_time, 0.0)
        late = ca.if_else(weight >= PRIOR_TIME + MEASURED_TIME, measured * told / average, held)
        measured = ca.if_else(told > 0.0, late, measured)
        variance = ca.if_else(counted > 0.0, measured, held)
        after = ca.vertcat(weight, short_time, long_time, short, long, average, told, variance)
        return after, variance

    def walks(self, state: ca.SX) -> ca.SX:
        """Intensities q of the random walks, as an expression.

        Args:
            state: As ``NoiseMeters.state``.
        """
        short, long, *_ = ca.vertsplit(state[HEAD:], len(self._signals))
        return _walks(short, long, state[2] - state[1])

    def _mean_squares(self, difference: ca.SX) -> ca.SX:
        """Of the components of each signal."""
        means, begin = [], 0
        for signal in self._signals:
            part = difference[begin : begin + signal.size]
            means.append(ca.sumsqr(part) / signal.size)
            begin += signal.size
        return ca.vertcat(*means)


def _walks(short: ca.SX, long: ca.SX, apart: ca.SX) -> ca.SX:
    return ca.fmax(long - short, 0.0) / apart
