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

r"""A small test signal on the commands, from which a flight tells how the aircraft answers them.

Each channel flies doublets: plus the amplitude for a time d, minus the amplitude for the same time,
so that heading, path angle and airspeed come back to where they were. Short ones (0.2 and 0.3 s)
tell lag from dead time where both are small; long ones (1.7 s), their sum and the gain. A doublet
has most of its power about :math:`\omega = 2.3 / d`. Their order and signs are drawn anew for every
channel and cycle, so that the channels can be told apart (R. Jategaonkar, Flight Vehicle System
Identification, 2nd ed., 2015, chapter 2: multistep inputs).

The signal is added to what is commanded anyway, inside the envelope. It begins once the aircraft
has been on its orbit for a while, fades in and out, and is suspended off the orbit, near a limit,
and in a fallback mode.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.control.event import EventLog, Level
from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.estimation.situation import Situation
from uav_tracking_mpc.limits import Motion
from uav_tracking_mpc.limits.path_angle import PathAngle
from uav_tracking_mpc.settings.tracking import TrackingParameters

# Amplitudes in [rad/s, rad/s, m/s^2]: 8 deg of bank, 5 deg of path angle, 10 % of airspeed.
USUAL = (0.06, 0.11, 1.5)
HALVES = (0.2, 0.2, 0.2, 0.3, 0.3, 0.3, 1.7)  # s, of the doublets of a cycle
CALM_TIME, RESUME_TIME = 5.0, 1.0  # s on the orbit before the signal begins, and goes on
FADE_TIME = 1.0  # s from nothing to all of it, and back
# From the orbit, for the signal to begin, in range and height: m, and a share of the range.
NEAR, NEAR_SHARE = 10.0, 0.03
LEFT = 2.0  # so many times as far, and the orbit counts as left
AIRSPEED_SHARE, AIRSPEED_LEFT = 0.15, 0.25  # of the airspeed asked for, likewise
TURN_SHARE = 0.85  # of the greatest turn rate that may be commanded beside the signal
# From limits, in units of `Bound.scale`: 2 m/s of airspeed, 10 m of height or distance, 20 m of the
# fence. Of the path angle 0.03 rad: the signal itself moves it.
MARGIN, ANGLE_MARGIN = 2.0, 0.03


class Doublets:
    """The signal of one channel: 1, -1, and so on.

    Args:
        seed: Of order and signs.
    """

    def __init__(self, seed: int) -> None:
        self._random = np.random.default_rng(seed)
        self._steps: list[tuple[float, float]] = []  # until when, and what, in reverse
        self._end = 0.0

    def value(self, time: float) -> float:
        """Signal at a time [-].

        Args:
            time: Since the beginning in [s], not before the one asked for last.
        """
        while True:
            if not self._steps:
                self._cycle()
            until, value = self._steps[-1]
            if time < until:
                return value
            self._steps.pop()

    def _cycle(self) -> None:
        for half in self._random.permutation(HALVES).tolist():
            sign = 1.0 if self._random.random() < 0.5 else -1.0
            self._steps += [(self._end + half, sign), (self._end + 2.0 * half, -sign)]
            self._end += 2.0 * half
        self._steps.reverse()


class Excitation:
    """Adds the signal to commands while it is safe.

    Args:
        parameters: Its amplitudes, orbit and limits.
        events: Where beginning and suspension are reported.
    """

    def __init__(self, parameters: TrackingParameters, events: EventLog) -> None:
        self._events = events
        self._amplitudes = np.zeros(3)
        self.change(parameters)
        self.reset()

    def change(self, parameters: TrackingParameters) -> None:
        """Use other amplitudes and limits from now on.

        Args:
            parameters: The new ones.
        """
        wanted = np.array(parameters.excitation)
        wanted[parameters.vehicle.commanded :] = 0.0
        self._wanted = bool(wanted.any())
        if self._wanted:  # else the signal that is flown fades
            self._amplitudes = wanted
        self._envelope = parameters.envelope

    def reset(self) -> None:
        """Begin anew."""
        self._signals = [Doublets(seed) for seed in range(3)]
        self._share = 0.0  # of the amplitude that is flown
        self._calm_since: float | None = None
        self._begin: float | None = None
        self._time = 0.0
        self._going = False

    def added(
        self,
        time: float,
        inputs: NDArray[np.float64],
        mode: FallbackMode,
        orbit: Orbit,
        present: Situation | None,
    ) -> NDArray[np.float64]:
        """A plan with the signal on its first segment, inside the envelope.

        Should no command follow, the aircraft flies the other segments without a signal.

        Args:
            time: From which on the plan counts, in [s].
            inputs: (u_psi, u_chi, u_v) of each segment, shape (n, 3); not changed.
            mode: Where they come from.
            orbit: What is flown.
            present: Where the aircraft is; None where that is not known.

        Returns:
            Shape (n, 3); the inputs themselves while there is no signal.
        """
        if not (self._wanted or self._share):
            return inputs
        elapsed, self._time = max(0.0, time - self._time), time
        reason = self._obstacle(inputs[0], mode, orbit, present)
        if reason:
            self._calm_since = None
        elif self._calm_since is None:
            self._calm_since = time
        wait = 0.0 if self._calm_since is None else time - self._calm_since
        needed = CALM_TIME if self._begin is None else RESUME_TIME
        self._tell(not reason and (self._going or wait >= needed), reason)
        change = min(elapsed, FADE_TIME) / FADE_TIME
        self._share = min(max(self._share + (change if self._going else -change), 0.0), 1.0)
        if self._share == 0.0 or present is None:
            return inputs
        if self._begin is None:
            self._begin = time
        signal = np.array([channel.value(time - self._begin) for channel in self._signals])
        excited = inputs.copy()
        excited[0] = self._envelope.clip(
            inputs[0] + self._share * self._amplitudes * signal,
            present.airspeed,
            present.path_angle,
        )
        return excited

    def _tell(self, going: bool, reason: str) -> None:
        if going != self._going:
            words = "goes on" if going else f"is suspended: {reason}"
            if going and self._begin is None:
                words = "begins"
            self._events.add(Level.INFO, f"the excitation {words}")
        self._going = going

    def _obstacle(
        self,
        inputs: NDArray[np.float64],
        mode: FallbackMode,
        orbit: Orbit,
        present: Situation | None,
    ) -> str:
        """What speaks against a signal now, in words; empty if nothing does."""
        if not self._wanted:
            return "it is not asked for any more"
        if not mode.nominal or present is None:
            return f"flying {mode.value}"
        x, y, z = present.offset.tolist()
        airspeed, path_angle = present.airspeed, present.path_angle
        off = max(abs(math.hypot(x, y, z) - orbit.range), abs(z - orbit.altitude))
        allowed = max(NEAR, NEAR_SHARE * orbit.range) * (LEFT if self._going else 1.0)
        if not off <= allowed:
            return f"{off:.1f} m off the orbit"
        share = AIRSPEED_LEFT if self._going else AIRSPEED_SHARE
        if not abs(airspeed - orbit.speed) <= share * orbit.speed:
            return f"the airspeed is {airspeed:.1f} m/s"
        if abs(inputs[0]) > TURN_SHARE * self._envelope.turn_rate_max(airspeed):
            return "the turn is near its limit"
        motion = Motion(x, y, z, path_angle, airspeed)
        for limit in self._envelope.limits:
            margin = MARGIN
            if isinstance(limit, PathAngle):
                margin = ANGLE_MARGIN / 0.1
            bound = limit.stage(motion, limit.numbers(present.target[np.newaxis])[0], np)
            if bound is not None and max(bound.inequalities(), default=-math.inf) > -margin:
                return f"near the limit of {limit.label}"
        return ""
