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

"""Tells people when the orbit that is flown is not the one they asked for, and which it is."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.control.event import EventLog, Level
from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.formulation.formulation import Plan

# Differences in range [m], altitude [m] and airspeed [m/s] that are worth a word, and by how much
# an orbit that stays may still change.
NOTABLE = 1.0, 2.0, 0.5
LASTING = 10.0  # s for which it must have been different, and the same


class OrbitShortfall:
    """Compares the artificial orbit of each plan with what is wanted.

    A flight on its way to the orbit passes through others: only one that stays is told.

    Args:
        events: Where to tell.

    Attributes:
        flown: Range, altitude and airspeed of the orbit flown instead, shape (3,); None where that
            asked for is flown, or on the way to it.
    """

    def __init__(self, events: EventLog) -> None:
        self._events = events
        self.reset()

    def reset(self) -> None:
        """Forget what was flown."""
        self.flown: NDArray[np.float64] | None = None
        self._candidate, self._begin = [math.inf] * 3, 0.0

    def see(self, time: float, plan: Plan | None, wanted: Orbit) -> None:
        """Take in a plan.

        Args:
            time: Now in [s].
            plan: That is flown; None where none is.
            wanted: What was asked for.
        """
        if plan is None or plan.orbit is None:
            return
        asked, flown = [wanted.range, wanted.altitude, wanted.speed], plan.orbit.tolist()
        if _alike(flown, asked):
            if self.flown is not None:
                self._events.add(Level.INFO, "the orbit that was asked for is flown again")
            self.reset()
        elif not _alike(flown, self._candidate):
            self._candidate, self._begin = flown, time
        elif self.flown is None and time - self._begin >= LASTING:
            self.flown = plan.orbit
            self._events.add(
                Level.WARNING,
                f"limits and drift leave no orbit of {_words(asked)}: flying {_words(flown)}",
            )


def _alike(one: list[float], other: list[float]) -> bool:
    """Whether the difference of two orbits is worth no word."""
    return all(abs(a - b) < least for a, b, least in zip(one, other, NOTABLE, strict=True))


def _words(orbit: list[float]) -> str:
    distance, altitude, speed = orbit
    return f"{distance:.1f} m at {altitude:.1f} m and {speed:.1f} m/s"
