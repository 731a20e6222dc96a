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

r"""Commands inside their limits, without jumps, with a small test signal where that is asked for.

What is sent is what is wanted plus an offset that always decays. Where what is wanted jumps, since
another kind of guidance or other parameters are flown, the offset takes up the jump: the command
goes on from where it was, and converges to what is wanted however often that changes. After a break
the turn goes on from the one that the aircraft flies.

From the test signal a flight tells how the aircraft answers commands. Each channel flies doublets:
plus the amplitude for a time d, minus the amplitude for the same time, so that heading, path angle
and airspeed come back to where they were. Short ones (0.2 and 0.3 s)
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
from uav_tracking_mpc.estimation.response_estimator import ACCELERATION
from uav_tracking_mpc.estimation.situation import Situation
from uav_tracking_mpc.limits import Motion
from uav_tracking_mpc.limits.airspeed import Airspeed
from uav_tracking_mpc.limits.climb import PathAngle
from uav_tracking_mpc.settings.tracking import TrackingParameters

HALVES = (0.2, 0.2, 0.2, 0.3, 0.3, 0.3, 1.7)  # s, of the doublets of a cycle
CALM_TIME, RESUME_TIME = 5.0, 1.0  # s on the orbit before the signal begins, and goes on
EXCITATION_FADE_TIME = 1.0  # s from nothing to all of it, and back
# m, -: from the orbit, for the signal to begin, in range and height, also as a share of the range.
NEAR, NEAR_SHARE = 10.0, 0.03
LEFT = 2.0  # -, multiple of these beyond which the orbit counts as left
AIRSPEED_SHARE, AIRSPEED_LEFT = 0.15, 0.25  # -, of the airspeed asked for, likewise
TURN_SHARE = 0.85  # -, of the greatest turn rate that may be commanded beside the signal
# -, rad: from limits, in units of `Bound.scale`: 2 m/s of airspeed, 10 m of height or distance,
# 20 m of the fence; of the path angle, which the signal itself moves.
MARGIN, ANGLE_MARGIN = 2.0, 0.03
SPEED_MARGIN = 0.1  # -, share of the airspeed asked for, where that is less than 2 m/s
WAIT_TIME = 60.0  # s after which a signal that has not begun tells why


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
        self._waits_since: float | None = None
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
        self._tell_waiting(time, reason)
        change = min(elapsed, EXCITATION_FADE_TIME) / EXCITATION_FADE_TIME
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

    def _tell_waiting(self, time: float, reason: str) -> None:
        if self._waits_since is None:
            self._waits_since = time
        if self._begin is None and reason and time - self._waits_since >= WAIT_TIME:
            self._events.add(Level.INFO, f"the excitation has not begun yet: {reason}")
            self._waits_since = time

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
        off = max(map(abs, orbit.errors_at(x, y, z)))
        allowed = max(NEAR, NEAR_SHARE * orbit.range) * (LEFT if self._going else 1.0)
        if not off <= allowed:
            return f"{off:.1f} m off the orbit"
        share = AIRSPEED_LEFT if self._going else AIRSPEED_SHARE
        if not abs(airspeed - orbit.speed) <= share * orbit.speed:
            return f"the airspeed is {airspeed:.1f} m/s"
        if abs(inputs[0]) > TURN_SHARE * self._envelope.turn_rate_max(airspeed):
            return "the turn is near its limit"
        turn_rate, _, acceleration = present.rates.tolist()
        motion = Motion(x, y, z, path_angle, airspeed, turn_rate, acceleration)
        for limit in self._envelope.limits:
            margin = MARGIN
            if isinstance(limit, PathAngle):
                margin = ANGLE_MARGIN / 0.1
            elif isinstance(limit, Airspeed):
                margin = min(MARGIN, SPEED_MARGIN * orbit.speed)
            bound = limit.stage(motion, limit.numbers(present.target[np.newaxis])[0], np)
            if bound is not None and max(bound.inequalities(), default=-math.inf) > -margin:
                return f"near the limit of {limit.label}"
        return ""


# s, time constant of the offset that a change leaves. Changes with every command make it a lag in
# the loop, which must stay below the delay margin that is asked for by default.
FADE_TIME = 0.25
TURN = 0  # index of u_psi among the inputs


class CommandShaper:
    """Clips commands and keeps them from jumping.

    Args:
        parameters: Limits of the inputs and of the bank, and the excitation.
        events: Where the excitation is reported.

    Attributes:
        excitation: The test signal that is added to what is shaped.
    """

    def __init__(self, parameters: TrackingParameters, events: EventLog) -> None:
        self.excitation = Excitation(parameters, events)
        self.change(parameters)
        self.reset()

    def change(self, parameters: TrackingParameters) -> None:
        """Use other limits from now on.

        The offset takes up the difference: a wider orbit would begin at the bank limit.

        Args:
            parameters: The new ones.
        """
        self._envelope = parameters.envelope
        self._lower, self._upper = parameters.input_lower, parameters.input_upper
        self._fastest = float(self._upper[ACCELERATION])  # m/s^2
        self._changed = True
        self.excitation.change(parameters)

    def reset(self) -> None:
        """Forget what was commanded: the next command comes as it is."""
        self._wanted: NDArray[np.float64] | None = None
        self._mode = FallbackMode.SILENCE
        self._offset, self._time = np.zeros(3), 0.0
        self._changed = self._broken = False
        self.excitation.reset()

    def pause(self) -> None:
        """Nothing is commanded for a while: the next command goes on from the turn flown then."""
        self.reset()
        self._broken = True

    def shape(
        self,
        time: float,
        inputs: NDArray[np.float64],
        step: float,
        airspeed: float,
        mode: FallbackMode,
        surplus: float = 0.0,
        present: Situation | None = None,
        too_fast: bool = False,
    ) -> NDArray[np.float64]:
        """Inputs to be sent.

        Args:
            time: From which on they count, in [s].
            inputs: (u_psi, u_chi, u_v) at time, time + step, ..., shape (n, 3).
            step: In [s].
            airspeed: v in [m/s], which with the bank limits the turn rate.
            mode: Where the inputs come from.
            surplus: What the aircraft turns quicker than its bank says, in [rad/s]: one that turns
                slower is not banked beyond the limit for it.
            present: What the aircraft flies; None where that is not known.
            too_fast: Whether it must not accelerate.

        Returns:
            Finite inputs inside their limits, shape (n, 3).
        """
        if math.isfinite(airspeed):
            most = self._envelope.turn_rate_max(airspeed)
            self._upper[TURN] = max(min(most, most + surplus), 0.0)
            self._lower[TURN] = min(max(-most, surplus - most), 0.0)
        self._upper[ACCELERATION] = min(self._fastest, 0.0) if too_fast else self._fastest
        inside = self._clipped(inputs)
        other = mode is not self._mode and not (mode.planned and self._mode.planned)
        self._offset *= math.exp(-max(0.0, time - self._time) / FADE_TIME)
        if self._wanted is not None and (other or self._changed):
            self._offset += self._wanted - inside[0]
        if self._broken and present is not None:
            self._offset[TURN] = present.rates[TURN] - inside[0, TURN]
        self._broken = False
        self._wanted, self._time, self._mode, self._changed = inside[0], time, mode, False
        if not any(self._offset.tolist()):
            return inside
        share = np.exp(-step / FADE_TIME * np.arange(len(inside)))
        return self._clipped(inside + share[:, np.newaxis] * self._offset)

    def _clipped(self, inputs: NDArray[np.float64]) -> NDArray[np.float64]:
        """Inputs inside their limits; what is not finite becomes 0."""
        if not math.isfinite(np.vdot(inputs, inputs)):  # finite only if each of them is
            inputs = np.where(np.isfinite(inputs), inputs, 0.0)
        return np.minimum(np.maximum(inputs, self._lower), self._upper)
