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

"""Which states are answered, and whether the rate of the commands is kept."""

from __future__ import annotations

import math
from collections import deque

FORGIVEN = 0.01  # -, of the period by which a state may be early: rounding must not cost a state
WINDOW = 2.0  # s of the stamps
KEPT = 0.9  # -, share of the rate, below which it is missed
KEPT_AGAIN = 0.95  # -, share of the rate, from which on it is kept again
LASTING = 3.0  # s beyond the threshold until the verdict changes: one gap stays in WINDOW for less
LATE = 1.5  # -, periods from command to command, beyond which one came late


class Pace:
    """Picks the states from which a command is computed, and counts whether the rate is kept.

    Args:
        rate: Commands per second wanted in [Hz]; no more can come than there are states.

    Attributes:
        rate: Commands per second wanted in [Hz].
        missed: Periods in which a command was due and none was sent.
        late: Commands that came late.
    """

    def __init__(self, rate: float) -> None:
        self.rate = rate
        self.missed = self.late = 0
        self._due: float | None = None  # when the latest command was
        self.reset()

    def reset(self) -> None:
        """Forget the latest seconds."""
        self._states: deque[float] = deque()
        self._commands: deque[float] = deque()
        self._kept, self._agreed = True, -math.inf

    def state(self, stamp: float) -> None:
        """Count a state."""
        _count(self._states, stamp)

    def due(self, stamp: float) -> bool:
        """Whether the state of this stamp in [s] is the one to answer.

        Lost time is not made up for: after a gap, and where time went back, the pace starts anew.
        """
        period = 1.0 / self.rate
        if self._due is None or stamp < self._due - period:
            self._due = stamp
            return True
        due = self._due + period
        if stamp < due - FORGIVEN * period:
            return False
        self._due = stamp if due + period <= stamp else due
        return True

    def sent(self, stamp: float) -> None:
        """Count the command that answers a state; the opinion changes where the other one lasts."""
        if self._commands and stamp < self._commands[-1]:
            self.reset()
        if self._commands:
            periods = (stamp - self._commands[-1]) * self.rate
            self.missed += max(0, round(periods) - 1)
            self.late += periods > LATE
        _count(self._commands, stamp)
        rate = _rate(self._commands)
        least = (KEPT if self._kept else KEPT_AGAIN) * self.rate
        if rate is None or (rate >= least) == self._kept:
            self._agreed = stamp
        elif stamp - self._agreed >= LASTING:
            self._kept, self._agreed = not self._kept, stamp

    def complaint(self) -> str:
        """How the rate is missed, in words; empty while it is kept or not yet known."""
        commands, states = _rate(self._commands), _rate(self._states)
        if self._kept or commands is None:
            return ""
        words = f"keeps {commands:.1f} Hz of the {self.rate:g} Hz asked for"
        if states is not None and states < KEPT * self.rate:
            words += f": states come at {states:.1f} Hz only"
        return words


def _count(times: deque[float], time: float) -> None:
    if times and time < times[-1]:
        times.clear()
    times.append(time)
    while times[0] < time - WINDOW:
        times.popleft()


def _rate(times: deque[float]) -> float | None:
    if len(times) < 2 or times[-1] - times[0] < 0.5 * WINDOW:
        return None
    return (len(times) - 1) / (times[-1] - times[0])
