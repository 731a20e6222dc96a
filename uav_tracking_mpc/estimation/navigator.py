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

"""Where the aircraft is relative to the target, in which drift, when a command takes effect."""

from __future__ import annotations

import math
from collections import deque
from types import SimpleNamespace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uav_tracking_mpc.dynamics import vehicle as vehicle_model
from uav_tracking_mpc.dynamics.vehicle import Response, followed
from uav_tracking_mpc.dynamics.vehicle_models import step_function
from uav_tracking_mpc.estimation.air_data import AirData
from uav_tracking_mpc.estimation.air_estimate import AirEstimate
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.estimation.motion_check import FAR
from uav_tracking_mpc.estimation.sensor_health import AIRSPEED, OFF, USED, VELOCITY
from uav_tracking_mpc.estimation.situation import FADE_TIME, Forecast, Situation, outlook
from uav_tracking_mpc.estimation.target_filter import TargetFilter
from uav_tracking_mpc.settings.tracking import TrackingParameters
from uav_tracking_mpc.symbolic.functions import one_at_a_time
from uav_tracking_mpc.symbolic.native_code import NativeFunction

LONGEST_SUBSTEP = 0.05  # s, in which dead time is flown through
ROUNDING = 1e-9  # -, of a count of steps
LATENCY_LIMIT = 1.5  # s, counted on at most: beyond it the clocks do not agree
LATENCY_SHARE = 0.05  # -, of a new measurement in the latency that the prediction starts with
BELOW = 20.0  # m below its target: then z is most likely reported positive down
TOLD_EXCESS = 0.1  # -, share by which an airspeed reads too much or too little that is reported


class Estimate(NamedTuple):
    """What a command is computed from.

    Attributes:
        present: Situation when the aircraft was measured.
        effect: Situation when a command sent now takes effect.
        forecast: Target and drift from then on.
    """

    present: Situation
    effect: Situation
    forecast: Forecast


class CommandHistory:
    """Commands that were sent, as the aircraft flies them: plans by the time of sending.

    A plan's segments are laid out from the stamp of the state that it answers, but the aircraft
    flies the plan before it until the new one has been sent.

    Args:
        memory: How long a plan is kept after another has replaced it, in [s].
    """

    def __init__(self, memory: float) -> None:
        self.memory = memory
        # When each was sent and begins, its inputs and its step
        self._plans: deque[tuple[float, float, NDArray[np.float64], float]] = deque()

    def add(self, sent: float, begin: float, inputs: NDArray[np.float64], step: float) -> None:
        """Record a plan that takes effect when it is sent.

        Args:
            sent: From when on it is flown in [s].
            begin: When its first segment begins in [s], at or before ``sent``.
            inputs: (u_psi, u_chi, u_v) at begin, begin + step, ..., shape (n, 3), held in between.
            step: Length of a segment in [s].
        """
        while self._plans and self._plans[-1][0] > sent:
            self._plans.pop()  # never flown: a clock that stood ahead has gone back
        self._plans.append((sent, begin, inputs, step))
        while len(self._plans) > 1 and self._plans[1][0] <= sent - self.memory:
            self._plans.popleft()

    def demanded(self, time: float, axis: int) -> float:
        """Input demanded at a time by what has been sent so far.

        The last segment of a plan is held; before the first command nothing is demanded.

        Args:
            time: Past or future, in [s].
            axis: 0 for u_psi, 1 for u_chi, 2 for u_v.

        Returns:
            In [rad/s] or [m/s^2].
        """
        for sent, begin, inputs, step in reversed(self._plans):
            if sent <= time:
                return inputs.item(min(int((time - begin) / step), len(inputs) - 1), axis)
        return 0.0


class Navigator:
    """Measurements in, situations and forecast out.

    The drift is the wind less the target's velocity. With ``air_estimation`` the mean wind goes on
    as it changes over the horizon and the gust of now fades with its correlation time, sensors'
    biases and faults are taken out, and what is noisy is smoothed; without it the wind is that of
    the present wind triangle, v_ground - v_air. The acceleration that is flown comes from the
    commands and the aircraft's lag.

    Args:
        parameters: Lag, dead time, horizon and filter settings.

    Attributes:
        engaged: Whether the aircraft flies what is commanded; so at the start.
        claimed: Whether it does because somebody engaged it.
        air: The airspeed that came by itself.
        target: The filter of the target's positions.
        air_estimate: Of aircraft and air, with the health of the sensors.
        wind: At the latest estimate, gust included, shape (3,), in [m/s].
        airspeed: As it was measured last in [m/s], before noise and bias are taken out.
        latency: Time from a measurement to the command that answers it, averaged, in [s].
    """

    @one_at_a_time
    def __init__(self, parameters: TrackingParameters) -> None:
        self.air_estimate = AirEstimate()
        self.air = AirData(parameters.state_timeout, self.air_estimate.found)
        self.target = TargetFilter(parameters.target_noise, parameters.target_agility)
        self.latency = self.airspeed = 0.0
        self._history = CommandHistory(0.0)
        self.engaged, self.claimed = True, False
        self._estimating, self._model = parameters.air_estimation, parameters.vehicle
        self._step = NativeFunction(step_function(self._model))
        self.air.holds_altitude = self._model.commanded == 1
        self._stages = parameters.horizon_step * np.arange(parameters.horizon + 1)
        self._outlook = NativeFunction(outlook(len(self._stages) + 1))
        self.change(parameters)
        self.reset()

    def change(self, parameters: TrackingParameters) -> None:
        """Use other parameters from now on; what is known of the target is kept.

        Args:
            parameters: The new ones, with the fixed ones as they are.
        """
        self._model, self.air.timeout = parameters.vehicle, parameters.state_timeout
        self._latest = min(parameters.state_timeout, LATENCY_LIMIT)
        self.respond(parameters.flown_by(parameters.response))
        if self._estimating:  # something stands in for an airspeed that is left out
            self.air.limits = parameters.airspeed_min, parameters.airspeed_max
        self.target.tune(parameters.target_noise, parameters.target_agility)

    def respond(self, response: Response) -> None:
        """Predict with another response of the aircraft until the parameters change.

        Args:
            response: As it was learnt in flight.
        """
        self._model = self._model.with_lags(response.lags)
        self._lags = self._model.lags.tolist()
        self._dead_time = response.dead_times.tolist()
        self._history.memory = 2.0 * max(self._dead_time) + 2.0 * self._latest

    def reset(self) -> None:
        """Forget aircraft, air, target and commands."""
        self.air.reset()
        self.target.reset()
        self.begin_anew()

    def begin_anew(self) -> None:
        """Forget an aircraft that is elsewhere, with what is known of the air, and its commands."""
        self.air.begin_anew()
        self._history = CommandHistory(self._history.memory)
        self.air_estimate.reset()
        self.wind = np.zeros(3)
        self._faded, self._fade_begin = np.zeros((2, 3)), 0.0
        self._flown = np.zeros(3)  # rates by the commands, in [rad/s] and [m/s^2]
        self._below = 0.0
        self._told: set[str] = set()  # concerns
        self._turn_failed = False
        self._time: float | None = None

    @property
    def lost(self) -> bool:
        """Whether the position has been carried on for so long that it is none any more."""
        return bool(self.air_estimate.found.astray[0] > FAR)

    @property
    def airspeed_known(self) -> bool:
        """Whether the airspeed is measured and believed."""
        return not self.air.missing and self.air_estimate.health.states[AIRSPEED] == USED

    @property
    def gusts(self) -> float:
        """Intensity of level gusts in [m^2/s^3]; 0 where nothing is known of them."""
        return float(self.air_estimate.found.walk[0])

    @property
    def airspeed_uncertainty(self) -> tuple[float, tuple[float, float]]:
        """What is not known of the airspeed, in [m/s].

        The standard deviation of what stands in for one that is not used, else 0; and by how much
        one that is used may be too high, and too low.
        """
        found = self.air_estimate.found
        if self.airspeed_known:
            return 0.0, (float(found.doubts[0]), float(found.doubts[1]))
        return float(found.deviation[0]), (0.0, 0.0)

    def complaints(self) -> list[str]:
        """What has become of the sensors since it was asked last, in words."""
        excess = float(self.air_estimate.state.alpha[0])
        concerns = self.air.concerns(self._estimating) | {
            "the aircraft is {0:.0f} m below the target: z must be positive up (ENU)": (
                self._below > BELOW
            ),
            f"the airspeed reads too {{1}} by more than {TOLD_EXCESS:.0%}: it is corrected": (
                abs(excess) > TOLD_EXCESS
            ),
        }
        new = [words for words, holds in concerns.items() if holds and words not in self._told]
        self._told.update(new)
        return [
            *(words.format(self._below, "much" if excess > 0.0 else "little") for words in new),
            *self.air_estimate.health.news(),
        ]

    def see_state(self, measurement: Measurement) -> tuple[Measurement, NDArray[np.float64]]:
        """See :meth:`AirData.see_state`; all begins anew once z or heading count the other way.

        Args:
            measurement: Of the aircraft, not older than the one before.
        """
        signs, seen = self.air.signs, self.air.see_state(measurement)
        if self.air.signs == signs:
            return seen
        self.begin_anew()
        return self.air.see_state(measurement)

    def see_target(
        self,
        time: float,
        position: ArrayLike,
        velocity: ArrayLike | None = None,
        covariance: ArrayLike | None = None,
    ) -> bool:
        """Take in a measurement of the target: see :meth:`TargetFilter.update`.

        Args:
            time: When it was measured in [s].
            position: In ``map``, shape (3,), in [m].
            velocity: In ``map``, shape (3,), in [m/s]; None if it is not known.
            covariance: Of position, shape (3, 3), or of position and velocity, shape (6, 6), in
                SI units; None if it is not known.
        """
        known = self.target.time
        before = None if known is None else self.target.motion(max(time, known))
        taken = self.target.update(time, position, velocity, covariance)
        if taken and before is not None:
            corrected = (before - self.target.motion(time))[:2]
            self._faded, self._fade_begin = self._fading(time) + corrected, time
        return taken

    def _fading(self, time: float) -> NDArray[np.float64]:
        """What is not yet corrected of position and velocity at a time, shape (2, 3)."""
        return self._faded * math.exp(-max(0.0, time - self._fade_begin) / FADE_TIME)

    def engage(self, engaged: bool) -> None:
        """Say whether the aircraft flies what is commanded; while not, that counts for nothing.

        Args:
            engaged: Whether it does; so at the start.
        """
        self.claimed = engaged
        if engaged != self.engaged:
            self.engaged = engaged
            self._history = CommandHistory(self._history.memory)
            self.air_estimate.trust_compass()

    def begin(self, delay: float) -> None:
        """Count with a latency at once: an average of nothing would take seconds to get there.

        Args:
            delay: From the stamp of the first measurement to now in [s].
        """
        self.latency = min(max(0.0, delay), self._latest)  # in this order 0 for no number

    def commanded(self, stamp: float, delay: float, plan: NDArray[np.float64], step: float) -> None:
        """Record a plan that has been sent.

        Args:
            stamp: Of the measurement that it answers, at which its first segment begins, in [s].
            delay: From the stamp to when it was sent in [s].
            plan: (u_psi, u_chi, u_v) of each segment, shape (n, 3).
            step: Length of a segment in [s].
        """
        if self.engaged:
            self._history.add(stamp + delay, stamp, plan, step)
        self.latency += LATENCY_SHARE * (min(delay, self._latest) - self.latency)

    def estimate(self, measurement: Measurement, vehicle: NDArray[np.float64]) -> Estimate:
        """Situations and forecast of a measurement.

        Args:
            measurement: Of the aircraft, not older than the one before.
            vehicle: (x, y, z, psi, chi, v) of it, as of :meth:`AirData.see_state`, shape (6,).

        Raises:
            ValueError: No target position is known.
        """
        time, self.airspeed = measurement.stamp, float(vehicle[5])
        delay = max(self._dead_time) + min(max(self.latency, 0.0), self._latest)
        track = self.target.track
        travelled, left = track.bridge(time - track.time)
        ground = float(track.state[0, 2])
        elapsed = 0.0 if self._time is None else max(0.0, time - self._time)
        self._time = time
        if elapsed > 0.0:  # what is flown: the commands, after dead time and lag
            for axis, (dead_time, lag) in enumerate(zip(self._dead_time, self._lags, strict=True)):
                demanded = self._history.demanded(time - 0.5 * elapsed - dead_time, axis)
                self._flown[axis] += followed(elapsed, lag) * (demanded - self._flown[axis])
        air = self._aircraft_in_air(measurement, vehicle, ground)
        self._below = ground - float(air.vehicle[2])
        self.air.far_below = self.engaged and self._below > BELOW
        known, times = self._outlook.arguments
        faded = self._fading(time).reshape(-1).tolist()
        known[:] = [  # in the order of KNOWN
            *track.state.reshape(-1).tolist(), track.variance(2), track.turn_rate,
            travelled, left, *faded,
            *air.wind.tolist(), *air.trend.tolist(), *air.gust.tolist(), *air.times.tolist(),
        ]  # fmt: skip
        np.add(self._stages, delay, out=times[1:])  # the first one is now
        self._outlook.evaluate()
        ahead = self._outlook.results[0].reshape(-1, 3, 3).swapaxes(0, 1).copy()
        target, drift, drift_rate = ahead[:, 0]
        present = Situation(air.vehicle.copy(), target, drift, drift_rate, air.rates.copy())
        self.wind = air.wind + air.gust
        targets, drifts, drift_rates = ahead[:, 1:]
        forecast = Forecast(targets, drifts, drift_rates, float(air.walk[0]))
        if delay == 0.0:
            return Estimate(present, present, forecast)
        return Estimate(present, self._at_effect(time, delay, present, forecast), forecast)

    def _aircraft_in_air(
        self, measurement: Measurement, vehicle: NDArray[np.float64], ground: float
    ) -> SimpleNamespace:
        """What is measured, by :data:`FOUND`, less noise and biases as far as they are known."""
        rates = np.array([measurement.turn_rate, measurement.path_angle_rate, self._flown[2]])
        if self._estimating:
            air = self.air
            if air.turn_failed and not self._turn_failed:
                self.air_estimate.trust_compass()  # it was judged by what it turned
            self._turn_failed = air.turn_failed
            found = self.air_estimate.update(
                measurement, vehicle, rates, ground, air.missing, air.nose, air.stuck, air.by_turn
            )
            states = self.air_estimate.health.states
            if air.impossible:
                states[AIRSPEED] = OFF
            if states[VELOCITY] == USED:
                states[VELOCITY] = air.climb_state
            if air.bank_lost:  # the nose swings, and turns outwards as the body rolls
                found.rates[:] = self._flown
            return found
        if not measurement.placed:
            raise ValueError("no position is measured")
        wind = measurement.ground_velocity - vehicle_model.velocity(vehicle)
        still = {"trend": np.zeros(3), "gust": np.zeros(3), "times": np.ones(3)}
        return SimpleNamespace(vehicle=vehicle, rates=rates, wind=wind, walk=[math.inf], **still)

    def _at_effect(
        self, time: float, delay: float, present: Situation, forecast: Forecast
    ) -> Situation:
        """Situation when a command sent now takes effect, by the commands already under way."""
        model, step, demanded = self._model, self._step, self._history.demanded
        count = max(1, math.ceil(delay / LONGEST_SUBSTEP - ROUNDING))
        substep = delay / count
        state, inputs, numbers, drift, rate, duration = step.arguments
        state[:] = model.initial(present.vehicle, present.target, present.rates)
        numbers[:] = model.numbers(substep)
        drift[:], rate[:], duration[0] = present.drift, present.drift_rate, substep
        change = substep * rate
        for index in range(count):
            middle = time + (index + 0.5) * substep
            inputs[:] = [
                demanded(middle - dead_time, axis) for axis, dead_time in enumerate(self._dead_time)
            ]
            step.evaluate()
            state[:] = step.results[0]
            drift += change
        vehicle, target = state[:6].copy(), forecast.target[0]
        vehicle[:3] += target
        vehicle[3:5] = [math.remainder(angle, math.tau) for angle in vehicle[3:5].tolist()]
        return Situation(
            vehicle, target, forecast.drift[0], forecast.drift_rate[0], state[6:9].copy()
        )
