r"""How noisy a signal is: white noise apart from what wanders.

A signal that is a random walk of intensity q under white noise of variance R changes over a time t
by a difference of variance

.. math:: E[(x(s + t) - x(s))^2] = 2 R + q t,

so that the differences over one sample and over several tell both apart.
"""

from __future__ import annotations

import math
from collections import deque

import numpy as np
from numpy.typing import NDArray

SAMPLES = 16  # of the longer difference
MEMORY = 40.0  # s, of the noise of an aircraft's sensors and of gusts
PRIOR_TIME = 1.0  # s of samples that what is taken at first counts for
LONGEST_GAP = 1.0  # s between samples beyond which the signal begins anew


class NoiseMeter:
    """White noise and random walk of a signal, averaged over its components and over time.

    Args:
        deviation: Standard deviation of the noise that is taken before anything is known, in the
            signal's unit [SI].
        memory: Time constant of the averages in [s].
        walk: q that is taken before anything is known, in the square of the unit [SI] per s.

    Attributes:
        variance: R, in the square of the unit [SI].
        walk: q, in the square of the unit [SI] per s.
    """

    def __init__(self, deviation: float, memory: float, walk: float = 0.0) -> None:
        self._deviation, self._memory, self._walk = deviation, memory, walk
        self.reset()

    def reset(self) -> None:
        """Forget the signal and its noise."""
        self._samples: deque[tuple[float, NDArray[np.float64]]] = deque(maxlen=SAMPLES + 1)
        self._weight = PRIOR_TIME
        self._short_time: float = 0.0
        self._long_time: float = 1.0
        self._short = 2.0 * self._deviation**2
        self._long = self._short + self._walk * self._long_time
        self.variance, self.walk = self._deviation**2, self._walk

    def see(self, time: float, signal: NDArray[np.float64]) -> None:
        """Take in a sample.

        Args:
            time: Of the sample in [s].
            signal: All components, shape (n,), in their unit [SI].
        """
        if self._samples and not 0.0 < time - self._samples[-1][0] < LONGEST_GAP:
            self._samples.clear()
        self._samples.append((time, signal))
        if len(self._samples) <= SAMPLES:
            return
        (first, oldest), (last, before) = self._samples[0], self._samples[-2]
        short_time, long_time = time - last, time - first
        self._weight = min(self._weight + short_time, self._memory)
        share = short_time / self._weight
        near, far = signal - before, signal - oldest
        self._short += share * (float(near @ near) / len(signal) - self._short)
        self._long += share * (float(far @ far) / len(signal) - self._long)
        self._short_time += share * (short_time - self._short_time)
        self._long_time += share * (long_time - self._long_time)
        self.walk = max(self._long - self._short, 0.0) / (self._long_time - self._short_time)
        self.variance = 0.5 * max(self._short - self.walk * self._short_time, 0.0)

    @property
    def deviation(self) -> float:
        """Standard deviation of the white noise, in the signal's unit [SI]."""
        return math.sqrt(self.variance)
