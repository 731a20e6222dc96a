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

"""What must hold for every message, and when the aircraft is back on its orbit: without ROS.

Nothing here comes from the controller: the limits are those of the configuration, the rest is
written a second time, so that one mistake cannot hide the other.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

ROUNDING = 1e-9  # -, rounding of what is compared
REMEMBERED = 1000  # states


@dataclass(frozen=True)
class Limits:
    """What the invariants are about.

    Attributes:
        lower: Least (u_psi, u_chi, u_v), shape (3,), in [rad/s, rad/s, m/s^2].
        upper: Greatest, shape (3,), in the same units.
        state_age: How much older than the newest state the state of a command may be [s].
        transport: Wall time [s] that a message may take, whatever the load: a state counts as
            known to the controller when it was delivered so long ago.
        floor: Least z in ``map`` [m].
        fence: Greatest distance from the target [m].
    """

    lower: NDArray[np.float64]
    upper: NDArray[np.float64]
    state_age: float
    transport: float
    floor: float
    fence: float


@dataclass(frozen=True)
class Violation:
    """Something that must not be.

    Attributes:
        invariant: Which of them is violated, in a word or two.
        detail: With numbers.
    """

    invariant: str
    detail: str


class Invariants:
    """Judges messages one by one.

    Args:
        limits: What to hold them to.
    """

    def __init__(self, limits: Limits) -> None:
        self._limits = limits
        self._true: deque[float] = deque(maxlen=REMEMBERED)  # stamps of true states [s]
        self._delivered: deque[tuple[float, float]] = deque()  # heard at, stamp; not yet known
        self._known: float | None = None  # newest state that the controller must know
        self._target: NDArray[np.float64] | None = None

    def target(self, position: ArrayLike) -> None:
        """The target moves.

        Args:
            position: Where it truly is, shape (3,), in ``map`` [m].
        """
        self._target = np.asarray(position, dtype=float)

    def state(self, stamp: float, position: ArrayLike) -> list[Violation]:
        """The true state of the vehicle.

        Args:
            stamp: Its time [s].
            position: Shape (3,), in ``map`` [m].
        """
        if self._true and stamp < self._true[-1]:  # a vehicle that was started anew
            self._true.clear()
            self._delivered.clear()
            self._known = None
        self._true.append(stamp)
        here = np.asarray(position, dtype=float)
        if not np.all(np.isfinite(here)):
            return [Violation("vehicle finite", f"position is {here.tolist()}")]
        found = []
        if here[2] < self._limits.floor:
            detail = f"z is {here[2]:.2f} m, floor {self._limits.floor:g} m"
            found.append(Violation("altitude floor", detail))
        if self._target is not None:
            distance = float(np.linalg.norm(here - self._target))
            if distance > self._limits.fence:
                detail = f"{distance:.1f} m from the target, fence {self._limits.fence:g} m"
                found.append(Violation("geofence", detail))
        return found

    def delivered(self, time: float, stamp: float) -> None:
        """A state as the controller got it; one whose stamp was tampered with is no state.

        Args:
            time: When, by a steady clock [s].
            stamp: Its time [s].
        """
        if stamp in self._true:
            self._delivered.append((time, stamp))

    def command(
        self, time: float, stamp: float, plan: ArrayLike, starts: ArrayLike
    ) -> list[Violation]:
        """A command as the controller sent it.

        Args:
            time: When, by the same clock [s].
            stamp: Time of the state that it was computed from [s].
            plan: (u_psi, u_chi, u_v), shape (n, 3).
            starts: When each begins, after the stamp, shape (n,) [s].
        """
        plan, starts = np.asarray(plan, dtype=float), np.asarray(starts, dtype=float)
        if len(plan) == 0:
            return [Violation("command complete", "a command without points")]
        found = []
        if not (np.all(np.isfinite(plan)) and np.all(np.isfinite(starts))):
            found.append(Violation("command finite", f"plan is {plan.tolist()}"))
        elif np.any(plan < self._limits.lower - ROUNDING) or np.any(
            plan > self._limits.upper + ROUNDING
        ):
            worst = plan[np.argmax(np.max(np.abs(plan), axis=1))]
            found.append(
                Violation(
                    "command limits",
                    f"{worst.tolist()} is not from {self._limits.lower.tolist()} to "
                    f"{self._limits.upper.tolist()}",
                )
            )
        if np.any(np.diff(starts) <= 0.0):
            found.append(Violation("command order", f"times from start are {starts.tolist()}"))
        while self._delivered and self._delivered[0][0] <= time - self._limits.transport:
            newest = self._delivered.popleft()[1]
            self._known = newest if self._known is None else max(self._known, newest)
        if self._known is not None and self._known - stamp > self._limits.state_age:
            found.append(
                Violation(
                    "state age",
                    f"a command from a state {self._known - stamp:.2f} s older than one delivered "
                    f"{self._limits.transport:g} s before, allowed {self._limits.state_age:g} s",
                )
            )
        return found


HOLD = 2.0  # s of simulated time that the orbit must be held
RECOVERY_LIMIT = 30.0  # s of simulated time
LONGEST_STEP = 1.0  # s; the vehicle's time moves on from state to state by less than this


class Recovery:
    """From the end of the last fault to the time after which the orbit is held.

    Args:
        tolerance: Greatest error of range and of altitude on the orbit [m].

    Attributes:
        flown: Simulated time flown so far [s]; it goes on when a vehicle that is started anew
            begins at 0.
        range_error: The latest r - r_d [m], nan before the first.
        worst: Greatest abs(r - r_d) since the last fault ended [m], and when it was flown [s].
    """

    def __init__(self, tolerance: float) -> None:
        self._tolerance = tolerance
        self.flown, self.range_error, self.worst = 0.0, math.nan, (0.0, 0.0)
        self._stamp, self._end = math.nan, math.inf
        self._entered: float | None = None

    def begin(self) -> None:
        """The last fault has ended."""
        self._end, self.worst = self.flown, (0.0, self.flown)

    def state(
        self, stamp: float, range_error: float, altitude_error: float, commanded: bool
    ) -> None:
        """Judge a state.

        Args:
            stamp: Its time [s].
            range_error: r - r_d [m]; nan while no target is known.
            altitude_error: z - z_d [m]; likewise.
            commanded: Whether commands of the controller come.
        """
        if 0.0 < stamp - self._stamp < LONGEST_STEP:
            self.flown += stamp - self._stamp
        self._stamp, self.range_error = stamp, range_error
        self.worst = max(self.worst, (abs(range_error), self.flown))
        on_orbit = abs(range_error) < self._tolerance and abs(altitude_error) < self._tolerance
        if not (commanded and on_orbit):
            self._entered = None
        elif self._entered is None:
            self._entered = self.flown

    def done(self) -> float | None:
        """Time that the recovery took [s]; None while the orbit has not been held long enough."""
        if self._entered is None or not self.flown - max(self._entered, self._end) >= HOLD:
            return None
        return max(0.0, self._entered - self._end)

    def late(self) -> bool:
        """Whether the time allowed is over without the aircraft on its orbit."""
        allowed = RECOVERY_LIMIT + (0.0 if self._entered is None else HOLD)
        return self.flown - self._end > allowed
