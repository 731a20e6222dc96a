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

"""When the aircraft is back on its orbit, and how long that took."""

from __future__ import annotations

LONGEST_STEP = 1.0  # s; the vehicle's time moves on from state to state by less than this


class FlownTime:
    """Simulated time that was flown; it goes on when a vehicle that is started anew begins at 0.

    Attributes:
        seconds: Time flown so far [s].
    """

    def __init__(self) -> None:
        self.seconds = 0.0
        self._stamp: float | None = None

    def state(self, stamp: float) -> float:
        """Count the time since the last state.

        Args:
            stamp: Of a state [s].

        Returns:
            Time flown so far [s].
        """
        if self._stamp is not None and 0.0 < stamp - self._stamp < LONGEST_STEP:
            self.seconds += stamp - self._stamp
        self._stamp = stamp
        return self.seconds


class Recovery:
    """From the end of the last fault to the time after which the orbit is held.

    Args:
        tolerance: Greatest error of range and of altitude on the orbit [m].
        hold: How long it must be held to count [s].
        limit: Time allowed [s].
    """

    def __init__(self, tolerance: float, hold: float, limit: float) -> None:
        self._tolerance, self._hold, self._limit = tolerance, hold, limit
        self._end: float | None = None
        self._entered: float | None = None

    def begin(self, flown: float) -> None:
        """The last fault has ended.

        Args:
            flown: Time flown [s].
        """
        self._end = flown

    def state(
        self, flown: float, range_error: float, altitude_error: float, commanded: bool
    ) -> None:
        """Judge a state.

        Args:
            flown: Time flown [s].
            range_error: r - r_d [m].
            altitude_error: z - z_d [m].
            commanded: Whether commands of the controller come.
        """
        errors = max(abs(range_error), abs(altitude_error))
        if not (commanded and errors < self._tolerance):
            self._entered = None
        elif self._entered is None:
            self._entered = flown

    def done(self, flown: float) -> float | None:
        """Time that the recovery took [s]; None while the orbit has not been held long enough.

        Args:
            flown: Time flown [s].
        """
        if self._end is None or self._entered is None:
            return None
        if flown - max(self._entered, self._end) < self._hold:
            return None
        return max(0.0, self._entered - self._end)

    def late(self, flown: float) -> bool:
        """Whether the time allowed is over without the aircraft on its orbit.

        Args:
            flown: Time flown [s].
        """
        return self._end is not None and (
            flown - self._end > self._limit + (0.0 if self._entered is None else self._hold)
        )
