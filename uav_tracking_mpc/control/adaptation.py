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

"""The response that is predicted with: the one that the aircraft shows replaces the told one."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.control.authority import Authority
from uav_tracking_mpc.control.event import EventLog
from uav_tracking_mpc.control.softening import Softening
from uav_tracking_mpc.control.watches import OscillationReport
from uav_tracking_mpc.dynamics.vehicle import Response
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.estimation.response_estimator import ResponseEstimator
from uav_tracking_mpc.settings.tracking import PREDICTIVE, TrackingParameters

TAKING_OVER = 5.0  # s after an aircraft begins to fly the commands, in which nothing is learnt
PERIOD = 0.5  # s between changes of what is flown
SPEED = 0.2  # s of lag or dead time, or share of the gain, by which it changes in a second
# s or -, and -: an estimate replaces what was told if it differs by more than LEAST, and by more
# than so many standard deviations; what was told comes back below half of it.
LEAST, SIGNIFICANT = 0.02, 2.0
ROUNDING = 1e-4  # s, to which what is flown follows
LAG = "lag", "lag_deviation", "lag_trusted"
DELAY = "delay", "delay_deviation", "trusted"
GAIN = "gain", "gain_deviation", "gain_trusted"


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
        softening: What is done about them.
        flown: What is flown by. What is sent is what is wanted divided by its gains.
        limited: What was told, with the limits that the aircraft shows.
    """

    def __init__(self, parameters: TrackingParameters, events: EventLog) -> None:
        self.oscillation, self.softening = OscillationReport(events), Softening(events)
        self._authority, self.limited = Authority(events), parameters
        self._air = [0.0] * 3  # psi, chi, v of the measurement
        self._commanded = parameters.vehicle.commanded
        self.estimator = ResponseEstimator(self._commanded)
        self._told = parameters
        self._engaged = True
        self._stamp = 0.0
        self._bank_lost = False
        self._learns_from = -math.inf  # s
        self._seen: tuple[Measurement, bool, float] | None = None  # not yet learnt from; so is
        self._sent: tuple[float, float, NDArray[np.float64], float, float, list[float]] | None = (
            None
        )
        self._begin()

    @property
    def enabled(self) -> bool:
        """Whether the response is estimated: while the aircraft flies the commands, and is there.

        Where it takes over from another flight, bank and climb first go over to what is commanded
        as quickly as they can, which is neither lag nor dead time. A nose whose bank is lost turns
        outwards as it rolls, and swings: its turn is not that of the path.
        """
        flies = self._engaged and self._stamp >= self._learns_from and not self._bank_lost
        return self._told.response_estimation and flies

    def reset(self) -> Response | None:
        """Forget what was learnt: what was told is flown by.

        Returns:
            What was told; None if it has been flown by.
        """
        before = self.flown
        self._seen = self._sent = None
        self.estimator = ResponseEstimator(self._commanded)
        self.oscillation.reset()
        self.softening.reset()
        self._authority.reset()
        self.limited = self._told
        self._begin()
        return None if np.array_equal(before, self.flown) else self.flown

    def _begin(self) -> None:
        self._learnt = self._told.response
        self.flown = self._told.flown_by(self._learnt)
        self._time: float | None = None
        # Whether estimates replace what was told, of each channel.
        self._replaced = {names: np.zeros(3, dtype=bool) for names in (LAG, DELAY, GAIN)}

    def interrupt(self) -> None:
        """Forget commands and times, keep what was learnt."""
        self._seen = self._sent = None
        self.estimator.interrupt()
        self._authority.interrupt()
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
            self._learns_from = math.inf  # from some time after the next state on
            self.interrupt()

    def tell(self, parameters: TrackingParameters) -> Response | None:
        """Take other parameters; what was learnt stays unless they tell another response.

        Args:
            parameters: What is told now.

        Returns:
            What was learnt; None where what is told is flown by.
        """
        self.learn()
        before, self._told = self._told, parameters
        limits = before.bank_max, before.force_max
        if limits != (parameters.bank_max, parameters.force_max):
            self._authority.reset()
        self.limited = self._authority.within(parameters)
        if before.response_estimation != parameters.response_estimation or not np.array_equal(
            before.response, parameters.response
        ):
            self._begin()
        told = parameters.flown_by(parameters.response)
        return None if np.array_equal(self.flown, told) else self.flown

    @property
    def delays(self) -> list[float]:
        """Lag plus dead time that each channel is flown by, in [s]."""
        return (self.flown.lags + self.flown.dead_times).tolist()  # type: ignore[no-any-return]

    def see(
        self,
        measurement: Measurement,
        vehicle: NDArray[np.float64],
        airspeed_measured: bool,
        gusts: float = 0.0,
        bank_lost: bool = False,
    ) -> None:
        """Take in a measurement; :meth:`learn` learns from it.

        Args:
            measurement: Of the aircraft.
            vehicle: (x, y, z, psi, chi, v), shape (6,).
            airspeed_measured: Whether v is measured.
            gusts: Intensity of level gusts in [m^2/s^3]; 0 where nothing is known of them.
            bank_lost: Whether a body has told its bank, and it is not gone by now.
        """
        self.learn()
        self._air, self._stamp = vehicle[3:].tolist(), measurement.stamp
        if bank_lost != self._bank_lost:
            self.interrupt()
        self._bank_lost = bank_lost
        if self._engaged:
            # Also where time has gone back since
            self._learns_from = min(self._learns_from, self._stamp + TAKING_OVER)
        self._seen = measurement, airspeed_measured, gusts

    def commanded(
        self,
        stamp: float,
        delay: float,
        plan: NDArray[np.float64],
        step: float,
        forced: float = 0.0,
    ) -> NDArray[np.float64]:
        """Record a plan that has been sent: see :meth:`Navigator.commanded`.

        Args:
            stamp: Of the measurement that it answers in [s].
            delay: From the stamp to when it was sent in [s].
            plan: (u_psi, u_chi, u_v) of each segment as sent, shape (n, 3).
            step: Length of a segment in [s].
            forced: Acceleration of the target in [m/s^2], which the aircraft must follow.

        Returns:
            What the aircraft makes of it at its gain, shape (n, 3).
        """
        flown = plan * self.flown.gains
        self._sent = stamp, delay, plan, step, forced, flown[0].tolist()
        return flown

    def learn(self) -> None:
        """Learn from the latest measurement and plan.

        No command waits for it: at the latest the next measurement does it.
        """
        seen, sent = self._seen, self._sent
        self._seen = self._sent = None
        *_, airspeed = self._air
        if seen is not None and self.enabled:
            measurement, airspeed_measured, gusts = seen
            self.estimator.see(
                measurement.stamp,
                measurement.turn_rate,
                measurement.path_angle_rate,
                airspeed if airspeed_measured else None,
                self._told.envelope.turn_rate_max(airspeed),
            )
        if sent is None:
            return
        stamp, delay, plan, step, forced, inputs = sent
        delays = self.delays
        if self.enabled:
            self.estimator.commanded(stamp + delay, stamp, plan, step)
            if (
                seen is not None
                and airspeed_measured
                and self._told.law == PREDICTIVE
                and self._authority.see(measurement, self._air, inputs, self._told, delays, gusts)
            ):
                self.limited = self._authority.within(self._told)
        if self._engaged:
            rates = plan[0, : min(self._commanded, 2)].tolist()
            self.oscillation.see(stamp, rates, airspeed, self.estimator.channels, delays, forced)

    def soften(self, time: float) -> NDArray[np.float64] | None:
        """Factors of the weights of the inputs' rates from now on, shape (3,), [-].

        Args:
            time: Now in [s].

        Returns:
            None if they stay.
        """
        swings, going_on = self.oscillation.swings, self.oscillation.going_on
        gains = self.flown.gains.tolist()
        if not self.softening.follow(time, swings, going_on, self.delays, gains):
            return None
        self.estimator.swing = self.softening.factors > 1.0
        return self.softening.factors

    def follow(self, time: float) -> Response | None:
        """Move what is flown towards what is trusted.

        Args:
            time: Now in [s].

        Returns:
            What to predict with from now on; None if it stays.
        """
        if not self.enabled or self._told.law != PREDICTIVE:
            return None
        elapsed = math.inf if self._time is None else time - self._time
        if 0.0 <= elapsed < PERIOD:
            return None
        self._time = time
        most = SPEED * min(max(elapsed, 0.0), PERIOD)
        before = self.flown
        self._follow(most)
        self.flown = self._told.flown_by(self._learnt)
        return None if np.array_equal(before, self.flown) else self.flown

    def _follow(self, most: float) -> None:
        """Move every channel by at most so many [s], or so much gain."""
        told, (lags, dead_times, gains) = self._told.response, self._learnt
        delays, told_delays = lags + dead_times, told.lags + told.dead_times
        wanted_gains = self._wanted(GAIN, gains, np.ones(3))
        wanted_delays = self._wanted(DELAY, delays, told_delays)
        shared = wanted_delays * told.lags / np.where(told_delays > 0.0, told_delays, math.inf)
        likely = np.where([each.lag_trusted for each in self.estimator.channels], told.lags, shared)
        wanted_lags = self._wanted(LAG, lags, likely)
        # A lag without the sum that it is a part of would become dead time.
        summed = self._replaced[DELAY] | [each.trusted for each in self.estimator.channels]
        wanted_lags = np.where(summed, wanted_lags, shared)
        off = np.maximum(np.abs(wanted_lags - lags), np.abs(wanted_delays - delays))
        delays = delays + np.clip(wanted_delays - delays, -most, most)
        after = np.minimum(lags + np.clip(wanted_lags - lags, -most, most), delays)
        after = np.array(self._told.vehicle.with_lags(after).lags)  # a model may have its own
        left = np.maximum(delays - after, 0.0)
        apart = np.maximum(np.abs(after - told.lags), np.abs(left - told.dead_times))
        stays, arrived = off < ROUNDING, apart < ROUNDING
        self._learnt = Response(
            np.where(stays, lags, np.where(arrived, told.lags, after)),
            np.where(stays, dead_times, np.where(arrived, told.dead_times, left)),
            gains + np.clip(wanted_gains - gains, -most, most),
        )

    def _wanted(
        self, names: tuple[str, str, str], flown: NDArray[np.float64], told: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """The estimates where they are trusted and contradict what was told, shape (3,).

        What was learnt stays until an estimate contradicts it, be it a trusted one or not.

        Args:
            names: Of the estimate, its standard deviation, and whether it is trusted.
            flown: What is flown by, shape (3,).
            told: What was told, shape (3,).
        """
        found, deviation, trusted = (
            np.array([getattr(each, name) for each in self.estimator.channels]) for name in names
        )
        before = self._replaced[names]
        stays = before & (np.abs(found - flown) <= SIGNIFICANT * deviation)
        needed = np.where(before, 0.5 * LEAST, np.maximum(LEAST, SIGNIFICANT * deviation))
        self._replaced[names] = np.where(trusted, np.abs(found - told) > needed, stays)
        return np.where(self._replaced[names], np.where(trusted, found, flown), told)
