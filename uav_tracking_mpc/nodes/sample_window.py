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

"""Median, 99th percentile, maximum and histogram of durations, in bounded memory."""

from __future__ import annotations

import numpy as np

# Upper ends of the bins of the histogram in [us]; the last bin is open.
BINS = (500.0, 1000.0, 2000.0, 4000.0, 10_000.0, 20_000.0, 50_000.0)


class SampleWindow:
    """The latest samples of a duration in [us].

    Args:
        size: How many count for median and percentile; maximum and histogram are over all.

    Attributes:
        count: Samples so far.
        max: Longest so far in [us].
    """

    def __init__(self, size: int = 20_000) -> None:
        self._samples = np.full(size, 0.0)  # touched now: memory must not grow in flight
        self._histogram = [0] * (len(BINS) + 1)
        self.count = 0
        self.max = 0.0

    def add(self, sample: float) -> None:
        """Take in a sample.

        Args:
            sample: Duration in [us].
        """
        self._samples[self.count % len(self._samples)] = sample
        self.count += 1
        self.max = max(self.max, sample)
        self._histogram[sum(sample >= end for end in BINS)] += 1

    def percentile(self, share: float) -> float:
        """Percentile of the latest samples in [us]; 0 before the first.

        Args:
            share: From 0 to 100, in [%].
        """
        if self.count == 0:
            return 0.0
        return float(np.percentile(self._samples[: self.count], share))

    @property
    def histogram(self) -> str:
        """Counts by duration, in words."""
        names = [f"<{end / 1e3:g} ms" for end in BINS] + [f">={BINS[-1] / 1e3:g} ms"]
        return ", ".join(
            f"{name}: {count}" for name, count in zip(names, self._histogram, strict=True) if count
        )
