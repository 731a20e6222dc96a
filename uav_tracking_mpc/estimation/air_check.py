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

r"""Whether airspeed and heading fit the wind: which of them is wrong where they do not.

With the ground velocity :math:`v_g` and the mean wind w, the velocity through the air is
:math:`u = v_g - w`. It is to be as fast as the airspeed, and to point along the heading:

.. math:: r = v - |u|, \qquad c = |u| \angle(\psi, u) .

Each sensor is judged by a wind that was found without it. By that wind a sensor that fails shows on
its own residual alone, while gusts and a wind that changes show on both as the aircraft turns. A
sensor is left out when its residual has jumped within a few seconds, or has stayed away from zero
for longer, by more than the other residual and the change of that wind explain: a wind that has
changed where it is seen may have changed where it is not. An airspeed that stays the same to the
last bit though the aircraft has been accelerated is left out too. Ground velocity and wind stand in
for a sensor until it agrees again.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.estimation.sensor_health import JUMPED, OFF, SILENT, STUCK

SMOOTHING, CHANGE_TIME, LASTING = 0.7, 4.0, 7.0  # s: of noise, of a jump, of what lasts
LEAST_JUMP, LEAST_OFFSET = 1.0, 0.8  # m/s
DEVIATIONS = 4.0  # standard deviations of gusts that explain a residual
DOMINANCE = 3.0  # -, by which the residual of a sensor that fails exceeds the other
TURNED = 0.3  # rad, that the wind's error turns against the heading in a jump
# s, and share of what the wind without airspeed has changed in it: it may have changed as much
# along the heading, where it was not seen
CHANGES, MOVES = 40.0, 3.0
WIND_KNOWN = 1.5  # m/s, standard deviation of the wind from which on there is something to compare
MEMORY = 60.0  # s, of the gusts
PRIOR, PRIOR_TIME = 0.5, 3.0  # m/s, s: gusts taken at first, and how much that weighs
AGREEING, AGREED_FOR = 0.5, 5.0  # -, s: share of the limits to be kept to, to be used again
STUCK_FOR, STUCK_CHANGE = 1.0, 0.4  # s and m/s: of a reading, and of the speed meanwhile
AIRSPEED, HEADING = 0, 1
BLIND = 100.0  # m/s, standard deviation of what is not measured


class AirCheck:
    """Compares airspeed and heading with the wind triangle.

    Attributes:
        reasons: Why airspeed and heading are left out, in a word; empty where they are used.
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Believe both sensors."""
        self.reasons = ["", ""]
        self._time = -math.inf
        # (r, c) in m/s by either wind: without noise, as of some seconds ago, and what lasts;
        # squares of gusts.
        self._now, self._before, self._lasting = (np.zeros((2, 2)) for _ in range(3))
        self._jumps, self._offsets = np.full((2, 2), PRIOR**2), np.full((2, 2), PRIOR**2)
        self._weight = 0.0  # s, for which they have been compared
        self._explained, self._moved = np.zeros(3), 0.0  # m/s, as of some time ago, and its change
        self._agreed = [0.0, 0.0]  # s
        self._reading, self._since, self._gained, self._speed = math.nan, 0.0, 0.0, 0.0

    def judge(
        self,
        time: float,
        heading: float,
        reading: float | None,
        level: float,
        air: Sequence[NDArray[np.float64]],
        wind_deviations: Sequence[float],
        explained: NDArray[np.float64],
        acceleration: float,
    ) -> tuple[float, float]:
        """Heading [rad] and level airspeed [m/s] that ground velocity and wind tell.

        Args:
            time: Of the measurement in [s].
            heading: As measured in [rad].
            reading: Airspeed as measured in [m/s]; None where there is none.
            level: Share of it that is level, less what it is known to read too much, [-].
            air: u by a wind that owes nothing to the airspeed, and by one that owes nothing to the
                heading, shape (2,) each, in [m/s].
            wind_deviations: Standard deviations of these winds in [m/s].
            explained: Of the estimate that owes nothing to the airspeed what it holds for wind and
                gust, and for the heading's bias times airspeed, shape (3,), in [m/s].
            acceleration: That is commanded and flown in [m/s^2].
        """
        step, self._time = time - self._time, time
        (u_x, u_y), (east, north) = np.array(air).tolist()
        along = u_x * math.cos(heading) + u_y * math.sin(heading)
        airspeed = 0.0 if reading is None else level * reading
        if reading is None:
            self.reasons[AIRSPEED] = SILENT
        elif self.reasons[AIRSPEED] == SILENT:
            self.reasons[AIRSPEED] = ""
            self._weight = 0.0
        elif 0.0 < step <= CHANGE_TIME:
            self._see_reading(time, step, reading, along, acceleration)
        residuals = np.array([_residuals(airspeed, heading, each) for each in air])
        if reading is None:
            residuals[:, AIRSPEED] = 0.0
        deviation = max(wind_deviations)
        if not (0.0 <= step <= CHANGE_TIME and deviation <= WIND_KNOWN):
            self._weight = self._moved = 0.0
            self._explained = explained
        elif step > 0.0:
            moved = float(np.linalg.norm(explained - self._explained))
            self._explained += min(step / CHANGES, 1.0) * (explained - self._explained)
            self._moved = max(moved, self._moved * math.exp(-step / CHANGES))
            self._compare(step, residuals, TURNED * deviation, MOVES * self._moved)
        if self.reasons[AIRSPEED]:
            east, north = u_x, u_y
        if self.reasons[HEADING]:
            along = math.hypot(u_x, u_y)
        return math.atan2(north, east), max(along, 0.0)

    def _compare(
        self, step: float, residuals: NDArray[np.float64], turned: float, changes: float
    ) -> None:
        """Follow r and c, and leave a sensor out or take it back."""
        if self._weight == 0.0:
            self._now[:] = self._before[:] = residuals
            self._lasting[:] = 0.0
            self._weight = PRIOR_TIME
        self._weight = min(self._weight + step, MEMORY)
        self._now += min(step / SMOOTHING, 1.0) * (residuals - self._now)
        self._before += step / CHANGE_TIME * (self._now - self._before)
        self._lasting += step / LASTING * (self._now - self._lasting)
        jumps, offsets = self._now - self._before, self._lasting
        for which, reason in enumerate(self.reasons):
            other = 1 - which  # axis on which the sensor shows nothing
            most = LEAST_JUMP + DEVIATIONS * (math.sqrt(self._jumps[which, other]) + turned)
            most = max(most, DOMINANCE * abs(jumps[which, other]))
            lasting = LEAST_OFFSET + DEVIATIONS * math.sqrt(self._offsets[which, other])
            lasting = changes + max(lasting, DOMINANCE * abs(offsets[which, other]))
            if not reason and not self.reasons[other]:
                jumped = abs(jumps[which, which]) > most
                # A bias from the start has been found by then, and is none of this.
                known = which == AIRSPEED and self._weight >= MEMORY
                off = known and abs(offsets[which, which]) > lasting
                self.reasons[which] = JUMPED if jumped else OFF if off else ""
                self._agreed[which] = 0.0
            elif reason in (JUMPED, OFF):
                agrees = abs(self._now[which, which]) < AGREEING * min(most, lasting)
                agrees &= which == HEADING or self._time - self._since < STUCK_FOR
                self._agreed[which] = self._agreed[which] + step if agrees else 0.0
                if self._agreed[which] > AGREED_FOR:
                    self.reasons[which] = ""
                    self._before[:, which] = self._lasting[:, which] = self._now[:, which]
        used = [not reason for reason in self.reasons]
        share = np.where(used, step / self._weight, 0.0)
        self._jumps += share * (np.square(self._now - self._before) - self._jumps)
        self._offsets += share * (np.square(self._lasting) - self._offsets)

    def _see_reading(
        self, time: float, step: float, reading: float, along: float, acceleration: float
    ) -> None:
        """Compare a reading that does not change with how the aircraft has been accelerated."""
        if reading != self._reading:
            self._reading, self._since, self._gained, self._speed = reading, time, 0.0, along
            if self.reasons[AIRSPEED] == STUCK:
                self.reasons[AIRSPEED] = JUMPED  # it must agree first
            return
        self._gained += step * acceleration
        moved = min(abs(self._gained), abs(along - self._speed)) > STUCK_CHANGE
        if moved and time - self._since > STUCK_FOR and not self.reasons[AIRSPEED]:
            self.reasons[AIRSPEED] = STUCK


def _residuals(airspeed: float, heading: float, air: NDArray[np.float64]) -> tuple[float, float]:
    """(r, c) of an air velocity u in [m/s]."""
    east, north = air.tolist()
    speed = math.hypot(east, north)
    return airspeed - speed, speed * math.remainder(math.atan2(north, east) - heading, math.tau)


def loose_air(heading: float, airspeed: bool, across: bool) -> NDArray[np.float64]:
    """Direction in which the air velocity is not measured, times its deviation, shape (3,).

    Args:
        heading: That is gone by in [rad].
        airspeed: Whether the airspeed is not.
        across: Whether the heading is not.
    """
    ahead = np.array([math.cos(heading), math.sin(heading), 0.0])
    return BLIND * (airspeed * ahead + across * np.array([-ahead[1], ahead[0], 0.0]))
