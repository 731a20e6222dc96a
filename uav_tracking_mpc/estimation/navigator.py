"""Where the aircraft is relative to the target, in which drift, when a command takes effect."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uav_tracking_mpc.dynamics import vehicle as vehicle_model
from uav_tracking_mpc.dynamics.vehicle_models import Drift
from uav_tracking_mpc.estimation.command_history import CommandHistory
from uav_tracking_mpc.estimation.forecast import Forecast
from uav_tracking_mpc.estimation.situation import Situation
from uav_tracking_mpc.estimation.target_filter import TargetFilter
from uav_tracking_mpc.settings.tracking import TrackingParameters

LONGEST_SUBSTEP = 0.05  # s, in which dead time is flown through
ROUNDING = 1e-9
LATENCY_LIMIT = 0.5  # s
# What a measurement corrects of the target's track is faded in with this time constant [s]: the
# steps of a noisy track would go straight into the bank angle.
FADE_TIME = 0.8


class Navigator:
    """Measurements in, situation and forecast out.

    The drift is the present wind triangle, c = v_ground - v_air - v_target: a mean wind would still
    lose in gusts. Turn rate and path-angle rate are measured; the acceleration that is flown comes
    from the commands and the aircraft's lag.

    Args:
        parameters: Lag, dead time, horizon and filter settings.

    Attributes:
        wind: At the latest situation, shape (3,), in [m/s].
        target: The filter of the target's positions.
        latency: Time in [s] from a state to the command that answers it, as measured by the caller.
    """

    def __init__(self, parameters: TrackingParameters) -> None:
        self.target = TargetFilter(parameters.target_noise, parameters.target_agility)
        self.latency = 0.0
        self._history = CommandHistory(2.0 * max(parameters.dead_time) + 1.0)
        self.change(parameters)
        self.reset()

    def change(self, parameters: TrackingParameters) -> None:
        """Use other parameters from now on; what is known of the target is kept."""
        self._parameters = parameters
        self._model = parameters.vehicle
        self._lag = float(self._model.lags[2])
        self._dead_time = parameters.dead_time
        self._stages = parameters.horizon_step * np.arange(parameters.horizon + 1)
        self._times = np.zeros(len(self._stages) + 1)
        self._shares = np.exp(-self._stages / FADE_TIME)[:, np.newaxis]
        self.target.tune(parameters.target_noise, parameters.target_agility)

    def reset(self) -> None:
        """Forget target and commands."""
        self.target.reset()
        self._history.reset()
        self.wind = np.zeros(3)
        self._faded, self._fade_begin = np.zeros((2, 3)), 0.0
        self._acceleration = 0.0
        self._time: float | None = None

    def see_target(self, time: float, position: ArrayLike) -> bool:
        """Take in a measured position of the target: see :meth:`TargetFilter.update`."""
        known = self.target.time
        before = None if known is None else self.target.predict(max(time, known))
        taken = self.target.update(time, position)
        if taken and before is not None:
            after = self.target.predict(time)
            self._faded = self._fading(time)
            self._faded += before.position - after.position, before.velocity - after.velocity
            self._fade_begin = time
        return taken

    def _fading(self, time: float) -> NDArray[np.float64]:
        """What is not yet corrected of position and velocity at a time, shape (2, 3)."""
        return self._faded * math.exp(-max(0.0, time - self._fade_begin) / FADE_TIME)

    def commanded(self, time: float, plan: NDArray[np.float64], step: float) -> None:
        """A plan has been sent in answer to the state of a time [s]."""
        self._history.add(time, plan, step)

    def situation(
        self,
        time: float,
        vehicle: NDArray[np.float64],
        ground_velocity: ArrayLike,
        turn_rates: ArrayLike,
    ) -> Situation:
        """Situation at the time of a measured state.

        Args:
            time: Of the state in [s].
            vehicle: (x, y, z, psi, chi, v) of position and air velocity, shape (6,).
            ground_velocity: In ``map``, shape (3,), in [m/s].
            turn_rates: Measured psi' and chi', shape (2,), in [rad/s].

        Raises:
            ValueError: No target position is known.
        """
        self._delay = max(self._dead_time) + min(max(self.latency, 0.0), LATENCY_LIMIT)
        self._times[0] = time
        self._times[1:] = time + self._delay + self._stages
        self._track = self.target.ahead(self._times)
        position, velocity, acceleration = (part[0] for part in self._track)
        fading = self._fading(time)
        self.wind = np.asarray(ground_velocity, dtype=float) - vehicle_model.velocity(vehicle)
        self._follow_acceleration(time)
        turn, pitch = (float(value) for value in np.asarray(turn_rates))
        return Situation(
            vehicle=vehicle,
            target=position + fading[0],
            drift=self.wind - velocity - fading[1],
            drift_rate=-acceleration,
            rates=np.array([turn, pitch, self._acceleration]),
        )

    def at_effect(self, time: float, situation: Situation) -> tuple[Situation, Forecast]:
        """Situation when a command sent now takes effect, and the forecast from then on.

        Args:
            time: Of the situation in [s].
            situation: The latest of :meth:`situation`.
        """
        positions, velocities, accelerations = (part[1:] for part in self._track)
        fading = self._fading(time + self._delay)[:, np.newaxis] * self._shares
        forecast = Forecast(
            positions + fading[0], self.wind - velocities - fading[1], -accelerations
        )
        if self._delay == 0.0:
            return situation, forecast
        state = self._flown_through(time, situation)
        turns = [math.remainder(angle, 2.0 * math.pi) for angle in state[3:5]]
        vehicle = np.array([*state[:3], *turns, state[5]])
        vehicle[:3] += forecast.target[0]
        later = replace(
            situation,
            vehicle=vehicle,
            target=forecast.target[0],
            drift=forecast.drift[0],
            drift_rate=forecast.drift_rate[0],
            rates=np.array(state[6:9]),
        )
        return later, forecast

    def _flown_through(self, time: float, situation: Situation) -> Any:
        """State relative to the target after the delay, by the commands already under way."""
        model = self._model
        state = model.initial(situation.vehicle, situation.target, situation.rates)
        drift, rate = situation.drift.tolist(), situation.drift_rate.tolist()
        count = max(1, math.ceil(self._delay / LONGEST_SUBSTEP - ROUNDING))
        substep = self._delay / count
        numbers = model.numbers(substep).tolist()
        for index in range(count):
            middle = time + (index + 0.5) * substep
            inputs = [
                self._history.demanded(middle - self._dead_time[axis], axis) for axis in range(3)
            ]
            now = [drift[axis] + index * substep * rate[axis] for axis in range(3)]
            state = model.step(state, inputs, substep, numbers, Drift(now, rate))
        return state

    def _follow_acceleration(self, time: float) -> None:
        """Acceleration flown at a time: the commands, after dead time and lag."""
        elapsed = 0.0 if self._time is None else time - self._time
        self._time = time
        if not elapsed > 0.0:
            return
        demanded = self._history.demanded(time - 0.5 * elapsed - self._dead_time[2], 2)
        share = -math.expm1(-elapsed / self._lag) if self._lag else 1.0
        self._acceleration += share * (demanded - self._acceleration)
