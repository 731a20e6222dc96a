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

"""Memory, file handles and threads of the processes, from /proc, and whether they grow."""

from __future__ import annotations

import os
import re
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

WARM_UP = 15.0  # s after its start that a process has for loading, compiling, filling its buffers
SHORTEST = 120.0  # s of samples below which a slope says nothing: histories are being filled
GROWTH_ALLOWED = 0.05  # -, of the memory, over what was watched
HANDLES_ALLOWED = 4  # file handles or threads more at the end than after the warm-up


@dataclass(frozen=True)
class Usage:
    """What a process uses.

    Attributes:
        rss: Resident memory in [byte].
        handles: Open file descriptors.
        threads: Threads.
        cpu: Processor time so far in [s].
    """

    rss: int
    handles: int
    threads: int
    cpu: float = 0.0


def usage(process: int) -> Usage | None:
    """What a process uses now; None if it has ended, or there is no /proc.

    Args:
        process: Its id.
    """
    folder = Path(f"/proc/{process}")
    try:
        status, times = ((folder / name).read_text() for name in ("status", "stat"))
        handles = sum(1 for _ in (folder / "fd").iterdir())
    except OSError:
        return None
    found = dict(re.findall(r"^(VmRSS|Threads):\s+(\d+)", status, re.MULTILINE))
    if "VmRSS" not in found:  # a zombie
        return None
    user, system = times.rpartition(")")[2].split()[11:13]
    cpu = (int(user) + int(system)) / os.sysconf("SC_CLK_TCK")
    return Usage(1024 * int(found["VmRSS"]), handles, int(found["Threads"]), cpu)


@dataclass
class Growth:
    """Samples of one process.

    Attributes:
        start: When it was started, by any clock [s].
        samples: (time [s], what it used) after the warm-up.
    """

    start: float
    samples: list[tuple[float, Usage]] = field(default_factory=list)

    def add(self, time: float, sample: Usage) -> None:
        """Add a sample; those of the warm-up are left out.

        Args:
            time: By the same clock [s].
            sample: What the process uses.
        """
        if time - self.start >= WARM_UP:
            self.samples.append((time, sample))

    @property
    def span(self) -> float:
        """Time from the first sample to the last [s]."""
        return self.samples[-1][0] - self.samples[0][0] if self.samples else 0.0

    def second_half(self) -> Growth:
        """The later half of the samples."""
        return Growth(self.start, self.samples[len(self.samples) // 2 :])

    def rss_percent_per_hour(self) -> float | None:
        """Slope of the memory, by least squares [%/h]; None where too little was watched."""
        if self.span < SHORTEST:
            return None
        times = np.array([time for time, _ in self.samples])
        rss = np.array([sample.rss for _, sample in self.samples], dtype=float)
        slope = float(np.polyfit(times - times[0], rss, 1)[0])
        return 100.0 * slope * 3600.0 / float(rss[0])

    def rss_percent(self) -> float:
        """Growth of the memory over what was watched, by least squares [%]."""
        return (self.rss_percent_per_hour() or 0.0) * self.span / 3600.0

    def complaint(self) -> str:
        """What grew more than allowed, in words; empty if nothing did."""
        words = []
        if self.span < SHORTEST:
            return ""
        percent = self.rss_percent()
        if percent > 100.0 * GROWTH_ALLOWED:
            words.append(f"memory grew by {percent:.1f} % in {self.span:.0f} s")
        third = max(1, len(self.samples) // 3)
        for name in ("handles", "threads"):
            # Least of each end: what comes and goes is no leak.
            first = min(getattr(sample, name) for _, sample in self.samples[:third])
            last = min(getattr(sample, name) for _, sample in self.samples[-third:])
            if last - first > HANDLES_ALLOWED:
                words.append(f"{name} grew from {first} to {last}")
        return ", ".join(words)
