"""Median, 99th percentile and maximum of the latest samples, in bounded memory."""

from __future__ import annotations

import numpy as np


class SampleWindow:
    """The latest samples of a quantity.

    Args:
        size: How many count for median and percentile; the maximum is over all.
    """

    def __init__(self, size: int = 20_000) -> None:
        self._samples = np.zeros(size)
        self.count = 0
        self.max = 0.0

    def add(self, sample: float) -> None:
        """Take in a sample."""
        self._samples[self.count % len(self._samples)] = sample
        self.count += 1
        self.max = max(self.max, sample)

    def percentile(self, share: float) -> float:
        """Percentile (0 to 100) of the latest samples; 0 before the first."""
        if self.count == 0:
            return 0.0
        return float(np.percentile(self._samples[: self.count], share))
