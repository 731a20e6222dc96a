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
from types import SimpleNamespace

import casadi as ca
import numpy as np

from uav_tracking_mpc.symbolic.layout import Layout

SAMPLES = 16  # -, of the longer difference
MEMORY = 40.0  # s, of the noise of an aircraft's sensors and of gusts
PRIOR_TIME = 1.0  # s of samples that what is taken at first counts for
EARLY = 3.0  # s, weight of the averages from which on what is measured counts, not what is told
CLIPPED = 25.0  # -, mean squares that the square of a difference counts at most
LONGEST_GAP = 2.0  # s between samples, beyond which what is followed by them begins anew


class NoiseMeters:
    """White noise and random walk of signals that are sampled together, averaged over time.

    What is known is a part of the memory of the filter that asks. It holds how many samples have
    come one after the other, their averages' weight and times [s], the mean squares of the short
    and of the long differences, the average and the newest of the variances that were told, the
    variances that hold, and ages [s] and values of the latest samples.

    Args:
        sizes: How many components each signal has, with equal noise.
        deviations: Standard deviations of the noise that are taken before anything is known, in
            the signals' units [SI].
        walks: q likewise, in the square of the unit [SI] per s.
        memory: Time constant of the averages in [s].
        jumping: Whether they may jump: a difference far beyond the usual ones, and beyond the noise
            that is taken at first, counts for little, so that jumps are no noise.

    Attributes:
        layout: Names of what is known, and what that is before any sample.
    """

    def __init__(
        self,
        sizes: Sequence[int],
        deviations: Sequence[float],
        walks: Sequence[float],
        memory: float = MEMORY,
        jumping: bool = False,
    ) -> None:
        self._sizes, self._memory, self._jumping = sizes, memory, jumping
        self._width, count, variances = sum(sizes), len(sizes), np.square(deviations)
        self._short = 2.0 * variances
        self.layout = Layout(
            count=1, weight=[PRIOR_TIME], short_time=1, long_time=[1.0], short=self._short,
            long=self._short + walks, average=count, before=count, held=variances,
            ages=SAMPLES, samples=SAMPLES * self._width,
        )  # fmt: skip

    def metered(
        self, known: SimpleNamespace, elapsed: ca.SX, sample: ca.SX, told: ca.SX
    ) -> SimpleNamespace:
        """What is known after a sample; variances R of its noise are held.

        Args:
            known: By :attr:`layout`.
            elapsed: Since the sample before in [s].
            sample: All components of all signals, shape (n,).
            told: Variance of each signal's noise by its source, averaged over the components, in
                the square of the unit [SI]; 0 where it tells none: what it told last then holds.
        """
        goes_on = ca.logic_and(elapsed > 0.0, elapsed < LONGEST_GAP)
        count = ca.if_else(goes_on, known.count, 0.0)
        counted, ages = count >= SAMPLES, known.ages + elapsed
        short_step, long_step = ages[0], ages[SAMPLES - 1]
        latest, oldest = known.samples[: self._width], known.samples[-self._width :]
        told = ca.if_else(told > 0.0, told, known.before)
        average = ca.if_else(known.average > 0.0, known.average, told)
        early = known.weight < EARLY
        held = ca.if_else(ca.logic_and(told > 0.0, early), told, known.held)
        weight = ca.fmin(known.weight + counted * short_step, self._memory)
        share = counted * short_step / weight
        short = self._mean_squares(sample - latest, known.short)
        long = self._mean_squares(sample - oldest, known.long)
        after = SimpleNamespace(
            count=ca.fmin(count + 1.0, SAMPLES),
            weight=weight,
            short_time=known.short_time + share * (short_step - known.short_time),
            long_time=known.long_time + share * (long_step - known.long_time),
            short=known.short + share * (short - known.short),
            long=known.long + share * (long - known.long),
            average=average + share * (told - average),
            before=told,
            ages=ca.vertcat(0.0, ages[: SAMPLES - 1]),
            samples=ca.vertcat(sample, known.samples[: -self._width]),
        )
        measured = 0.5 * ca.fmax(after.short - self.walks(after) * after.short_time, 0.0)
        late = ca.if_else(weight >= EARLY, measured * told / after.average, held)
        after.held = ca.if_else(counted, ca.if_else(told > 0.0, late, measured), held)
        return after

    def scatter(self, known: SimpleNamespace, sample: ca.SX) -> ca.SX:
        """Variance in the square of the unit [SI] that a single signal shows at first; 0 later.

        Args:
            known: By :attr:`layout`.
            sample: Its components in its unit [SI].
        """
        early = (known.count > 0.0) * (known.weight < EARLY)
        return early * ca.sumsqr(sample - known.samples[: self._width]) / (2.0 * self._width)

    def walks(self, known: SimpleNamespace) -> ca.SX:
        """Intensities q of the random walks, as an expression.

        Args:
            known: By :attr:`layout`.
        """
        return ca.fmax(known.long - known.short, 0.0) / (known.long_time - known.short_time)

    def _mean_squares(self, difference: ca.SX, usual: ca.SX) -> ca.SX:
        """Of the components of each signal, clipped where they may jump."""
        pieces = ca.vertsplit(difference, np.cumsum([0, *self._sizes]).tolist())
        squares = ca.vertcat(*[ca.sumsqr(piece) / piece.numel() for piece in pieces])
        most = CLIPPED * ca.fmax(usual, self._short)
        return ca.fmin(squares, most) if self._jumping else squares
