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

"""Flies by the response that the aircraft shows in place of the one that was told, slowly."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.control.event import EventLog, Level
from uav_tracking_mpc.control.oscillation import OscillationReport
from uav_tracking_mpc.estimation.channel_response import CHANNELS, ChannelResponse
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.estimation.response_estimator import ResponseEstimator
from uav_tracking_mpc.parameters.specification import changed
from uav_tracking_mpc.settings.tracking import PREDICTIVE, TrackingParameters

TAKING_OVER = 5.0  # s after an aircraft begins to fly the commands, in which nothing is learnt
PERIOD = 0.5  # s between changes of what is flown
SPEED = 0.03  # s of lag or dead time, or share of the gain, by which it changes in a second
# An estimate replaces what was told if it differs by more than this in [s], [s] and [-], and by
# more than so many standard deviations; what was told comes back below half of it.
LEAST_LAG, LEAST_DELAY, LEAST_GAIN, SIGNIFICANT = 0.03, 0.015, 0.03, 2.0
ROUNDING = 1e-4  # s, to which what is flown follows


class ResponseAdaptation:
    """Lag, dead time and gain of each channel as they are flown by.

    Without ``response_estimation``, and where a guidance law is flown, what was told stays; so it
    does for channels that are not commanded.

    Args:
        parameters: What was told.
        events: Where limit cycles are told.

    Attributes:
        estimator: Of the response.
        oscillation: Limit cycles of the commands.
        lag: Flown by, shape (3,), in [s].
        dead_time: Flown by, shape (3,), in [s].
        gain: Flown by, shape (3,): what is sent is what is wanted divided by it [-].
    """

    def __init__(self, parameters: TrackingParameters, events: EventLog) -> None:
        self.oscillation = OscillationReport(events)
        self._events = events
        self._airspeed = 0.0
        self._commanded = parameters.vehicle.commanded
        self.estimator = ResponseEstimator(self._commanded)
        self._told = parameters
        self._engaged = True
        self._stamp = 0.0
        self._learns_from: float | None = -math.inf  # s; None: from the next state on
        self._seen: tuple[Measurement, bool] | None = None  # not yet learnt from; so is
        self._sent: tuple[float, float, NDArray[np.float64], float] | None = None
        self._begin()

    @property
    def enabled(self) -> bool:
        """Whether the response is estimated: while the aircraft flies the commands, and is there.

        Where it takes over from another flight, bank and climb first go over to what is commanded
        as quickly as they can, which is neither lag nor dead time.
        """
        learns = self._learns_from is not None and self._stamp >= self._learns_from
        return self._told.response_estimation and self._engaged and learns

    @property
    def channels(self) -> list[ChannelResponse]:
        """What is known of turn rate, path-angle rate and acceleration."""
        return self.estimator.channels

    def reset(self) -> TrackingParameters | None:
        """Forget what was learnt: what was told is flown by.

        Returns:
            What was told; None if it has been flown by.
        """
        self._seen = self._sent = None
        self.estimator.reset()
        self.oscillation.reset()
        same = self.flown is self._told
        self._begin()
        return None if same else self._told

    def _begin(self) -> None:
        self.gain = np.ones(3)
        self.lag, self.dead_time = np.array(self._told.rate_lag), np.array(self._told.dead_time)
        self._time: float | None = None
        # Whether estimates replace what was told: of lag, delay, gain of each channel.
        self._replaced = np.zeros((3, 3), dtype=bool)

    def _begin_anew(self, axis: int) -> TrackingParameters:
        """Fly by what was told again, since the loop swings with what was learnt.

        An aircraft that rolls no faster than it can seems to lag the more the further it swings,
        and at its bank limit nothing more can be learnt.
        """
        self._events.add(
            Level.WARNING,
            f"the {CHANNELS[axis]} swings with the response that was learnt: it is learnt anew",
        )
        self.estimator.reset()
        self.oscillation.reset()
        self._begin()
        return self._told

    def interrupt(self) -> None:
        """Forget commands and times, keep what was learnt."""
        self._seen = self._sent = None
        self.estimator.interrupt()
        self.oscillation.reset()
        self._time = None

    def engage(self, engaged: bool) -> None:
        """Say whether the aircraft flies the commands; what was learnt stays.

        Args:
            engaged: Whether it does; so at the start.
        """
        if engaged != self._engaged:
            self.learn()
            self._engaged = engaged
            self._learns_from = None
            self.interrupt()

    def tell(self, parameters: TrackingParameters) -> TrackingParameters:
        """Take other parameters; what was learnt stays unless they tell another response.

        Args:
            parameters: What is told now.

        Returns:
            What to fly by.
        """
        self.learn()
        before, self._told = self._told, parameters
        told = [(p.rate_lag, p.dead_time, p.response_estimation) for p in (before, parameters)]
        if told[0] != told[1]:
            self._begin()
        return self.flown

    def delay(self, axis: int) -> float:
        """Lag plus dead time that a channel is flown by, in [s].

        Args:
            axis: 0 for u_psi, 1 for u_chi, 2 for u_v.
        """
        return float(self.lag[axis] + self.dead_time[axis])

    @property
    def flown(self) -> TrackingParameters:
        """The parameters that were told, with the lag and the dead time that are flown by."""
        lag, dead_time = tuple(self.lag.tolist()), tuple(self.dead_time.tolist())
        if (lag, dead_time) == (self._told.rate_lag, self._told.dead_time):
            return self._told
        return changed(self._told, {"rate_lag": lag, "dead_time": dead_time})

    def see(
        self, measurement: Measurement, vehicle: NDArray[np.float64], airspeed_measured: bool
    ) -> None:
        """Take in a measurement; :meth:`learn` learns from it.

        Args:
            measurement: Of the aircraft.
            vehicle: (x, y, z, psi, chi, v), shape (6,).
            airspeed_measured: Whether v is measured.
        """
        self.learn()
        self._airspeed, self._stamp = float(vehicle[5]), measurement.stamp
        if self._engaged and self._learns_from is None:
            self._learns_from = measurement.stamp + TAKING_OVER
        self._seen = measurement, airspeed_measured

    def commanded(
        self, stamp: float, delay: float, plan: NDArray[np.float64], step: float
    ) -> NDArray[np.float64]:
        """Record a plan that has been sent: see :meth:`Navigator.commanded`.

        Args:
            stamp: Of the measurement that it answers in [s].
            delay: From the stamp to when it was sent in [s].
            plan: (u_psi, u_chi, u_v) of each segment as sent, shape (n, 3).
            step: Length of a segment in [s].

        Returns:
            What the aircraft makes of it at its gain, shape (n, 3).
        """
        self._sent = stamp, delay, plan, step
        return plan * self.gain

    def learn(self) -> None:
        """Learn from the latest measurement and plan.

        No command waits for it: at the latest the next measurement does it.
        """
        seen, sent = self._seen, self._sent
        self._seen = self._sent = None
        if seen is not None and self.enabled:
            measurement, airspeed_measured = seen
            self.estimator.see(
                measurement.stamp,
                measurement.turn_rate,
                measurement.path_angle_rate,
                self._airspeed if airspeed_measured else None,
                self._told.envelope.turn_rate_max(self._airspeed),
            )
        if sent is None:
            return
        stamp, delay, plan, step = sent
        if self.enabled:
            self.estimator.commanded(stamp + delay, stamp, plan, step)
        if self._engaged:
            rates = plan[0, : min(self._commanded, 2)].tolist()
            delays = (self.lag + self.dead_time).tolist()
            self.oscillation.see(stamp, rates, self._airspeed, self.channels, delays)

    def follow(self, time: float) -> TrackingParameters | None:
        """Move what is flown towards what is trusted.

        Args:
            time: Now in [s].

        Returns:
            What to fly by from now on; None if it stays.
        """
        if not self.enabled or self._told.law != PREDICTIVE:
            return None
        elapsed = math.inf if self._time is None else time - self._time
        if 0.0 <= elapsed < PERIOD:
            return None
        self._time = time
        for axis, swing in enumerate(self.oscillation.swings):
            if swing is not None and self._replaced[:, axis].any():
                return self._begin_anew(axis)
        most = SPEED * min(max(elapsed, 0.0), PERIOD)
        before = self.lag.copy(), self.dead_time.copy()
        for axis, channel in enumerate(self.channels):
            self._follow(axis, channel, most)
        moved = np.abs(before[0] - self.lag) + np.abs(before[1] - self.dead_time)
        return self.flown if moved.max() > 0.0 else None

    def _follow(self, axis: int, channel: ChannelResponse, most: float) -> None:
        """Move one channel by at most so many [s], or so much gain."""
        told_lag, told_dead_time = self._told.rate_lag[axis], self._told.dead_time[axis]
        lag, delay = float(self.lag[axis]), self.delay(axis)
        gain = float(self.gain[axis])
        if channel.gain_trusted:
            least = LEAST_GAIN, channel.gain_deviation
            gain = self._wanted((axis, 2), channel.gain, 1.0, *least)
        self.gain[axis] += min(max(gain - self.gain[axis], -most), most)
        wanted_lag, wanted_delay = lag, delay
        if channel.trusted:
            told = told_lag + told_dead_time
            least = LEAST_DELAY, channel.delay_deviation
            wanted_delay = self._wanted((axis, 1), channel.delay, told, *least)
        if channel.lag_trusted:
            least = LEAST_LAG, channel.lag_deviation
            wanted_lag = self._wanted((axis, 0), channel.lag, told_lag, *least)
        if max(abs(wanted_lag - lag), abs(wanted_delay - delay)) < ROUNDING:
            return
        delay += min(max(wanted_delay - delay, -most), most)
        self.lag[axis] = min(lag + min(max(wanted_lag - lag, -most), most), delay)
        self.dead_time[axis] = delay - self.lag[axis]
        off = abs(self.lag[axis] - told_lag), abs(self.dead_time[axis] - told_dead_time)
        if max(off) < ROUNDING:
            self.lag[axis], self.dead_time[axis] = told_lag, told_dead_time

    def _wanted(
        self, which: tuple[int, int], found: float, told: float, least: float, deviation: float
    ) -> float:
        """The estimate where it contradicts what was told, else that."""
        needed = 0.5 * least if self._replaced[which] else max(least, SIGNIFICANT * deviation)
        self._replaced[which] = abs(found - told) > needed
        return found if self._replaced[which] else told
