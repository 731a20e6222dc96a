"""The flight problem, fed with what is known: parameters, situation, forecast."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.lagged_vehicle import advance
from uav_tracking_mpc.dynamics.orbit import COUNTER_CLOCKWISE, Orbit
from uav_tracking_mpc.estimation.forecast import Forecast
from uav_tracking_mpc.estimation.situation import Situation
from uav_tracking_mpc.formulation.flight_problem import (
    DECISION_SCALE,
    PARAMETERS,
    WHERE,
    FlightData,
    flight_problem,
    input_span,
    physical_inputs,
)
from uav_tracking_mpc.formulation.formulation import Plan
from uav_tracking_mpc.laws.vector_field import VectorField
from uav_tracking_mpc.limits._envelope import GRAVITY
from uav_tracking_mpc.mpc.casadi_solver import CasadiSolver
from uav_tracking_mpc.mpc.newton_solver import NewtonSolver
from uav_tracking_mpc.mpc.solver import Guess, Solver
from uav_tracking_mpc.settings.tracking import TrackingParameters

# Where the cost of the artificial orbit's offset turns from quadratic to linear, as a share of the
# wanted range, range and airspeed. Steep near the wanted orbit, or errors would be shared between
# both and met half-heartedly; linear beyond, or far away it would drown everything else.
OFFSET_REACH = np.array([0.01, 0.01, 0.03])
# Kept back of bank and force in plans: within a stage, and while commands take effect, airspeed and
# path angle move on, and the limits with them.
BANK_SHARE, FORCE_MARGIN = 0.98, 0.2  # -, m/s^2
NO_FENCE = 1e6  # m, radius
FLOOR_LIMIT = 1e4  # m below the target, as deep as a floor is told to the problem


class FlightFormulation:
    """Problem of :mod:`flight_problem` and its solver.

    Args:
        parameters: What is flown; :meth:`change` takes new ones while flying.
        solver: Of this problem; made as the parameters say by default.
    """

    def __init__(self, parameters: TrackingParameters, solver: Solver | None = None) -> None:
        self.step = parameters.horizon_step
        self.decrease = None  # (54) is about a fixed terminal set
        self.lag = effective_lag(parameters.rate_lag)
        self._stages = parameters.horizon
        self.solver = solver or _solver(parameters, self.lag)
        self._data = np.zeros((self._stages + 1, PARAMETERS))
        self.change(parameters)

    def change(self, parameters: TrackingParameters) -> None:
        """Fly other orbits, weights and limits from now on."""
        self.parameters = parameters
        self.envelope = parameters.envelope
        self._constant = constant_data(parameters)
        self._data[:] = self._constant.vector()
        self.solver.time_limit = parameters.solve_time_max

    def reset(self) -> None:
        """Forget the last plan."""
        self.solver.reset()

    def error(self, situation: Situation, orbit: Orbit) -> NDArray[np.float64]:
        """Tracking error of the relative motion (Section 3.1), shape (5,), angles wrapped."""
        x, y, z = situation.offset
        w_x, w_y, _ = situation.relative_velocity
        theta = math.atan2(w_y, w_x) - math.atan2(y, x) - math.pi - orbit.bearing
        return np.array(
            [
                math.sqrt(x * x + y * y + z * z) - orbit.range,
                math.remainder(theta, 2.0 * math.pi),
                z - orbit.altitude,
                situation.vehicle[4],
                situation.vehicle[5] - orbit.speed,
            ]
        )

    def solve(
        self, situation: Situation, forecast: Forecast, orbit: Orbit, elapsed: float | None
    ) -> Plan:
        """Best plan from a situation.

        Args:
            situation: Where the plan begins.
            forecast: Drift and target over its horizon.
            orbit: What is wanted.
            elapsed: Time in [s] since the situation of the last plan; None if that counts no more.
        """
        x_0 = self._state(situation)
        data = self._fill(forecast, orbit)
        solution = self.solver.solve(
            x_0, data, elapsed, lambda: self._guess(x_0, situation, forecast, orbit, data)
        )
        states = solution.states[:-1]
        inputs = np.column_stack(
            physical_inputs(solution.inputs.T, states[:, 4], states[:, 5], self._constant, np)
        )
        return Plan(inputs, self.step, self.error(situation, orbit), solution)

    def _state(self, situation: Situation) -> NDArray[np.float64]:
        parts = [situation.offset, situation.vehicle[3:6]]
        if self.lag:
            parts.append(situation.rates)
        return np.concatenate(parts)

    def _fill(self, forecast: Forecast, orbit: Orbit) -> NDArray[np.float64]:
        data, envelope = self._data, self.envelope
        data[:, WHERE["drift"]] = forecast.drift
        data[:, WHERE["drift_rate"]] = forecast.drift_rate
        data[:, WHERE["orbit"]] = orbit.range, orbit.altitude, orbit.speed
        data[:, WHERE["sense"]] = 1.0 if orbit.direction == COUNTER_CLOCKWISE else -1.0
        floor = envelope.height_min - forecast.target[:, 2]
        data[:, WHERE["floor"].start] = np.maximum(floor, -FLOOR_LIMIT)
        if envelope.fence_radius > 0.0:
            centre = np.array(envelope.fence_centre) - forecast.target[:, :2]
            data[:, WHERE["fence"].start : WHERE["fence"].start + 2] = centre
        return data

    def _guess(
        self,
        x_0: NDArray[np.float64],
        situation: Situation,
        forecast: Forecast,
        orbit: Orbit,
        data: NDArray[np.float64],
    ) -> Guess | None:
        """A flight by the vector field: a plan that is flyable and leads to the orbit."""
        if not (np.all(np.isfinite(x_0)) and np.all(np.isfinite(data))):
            return None
        law = VectorField(orbit, self.envelope)
        state, shares = list(x_0), np.zeros((self._stages, 3))
        for stage in range(self._stages):
            target = forecast.target[stage]
            now = replace(
                situation,
                vehicle=np.concatenate([np.array(state[:3]) + target, state[3:6]]),
                target=target,
                drift=forecast.drift[stage],
                drift_rate=forecast.drift_rate[stage],
                rates=np.array(state[6:9]) if self.lag else situation.rates,
            )
            inputs = law.inputs(now)
            middle, half = (
                np.array(part) for part in input_span(state[4], state[5], self._constant, np)
            )
            shares[stage] = np.clip((inputs - middle) / half, -1.0, 1.0)
            flown = middle + half * shares[stage]
            state = advance(
                state, list(flown), self.step, self.lag, list(now.drift), list(now.drift_rate)
            )
        speed = float(np.clip(state[5], self.envelope.airspeed_min, self.envelope.airspeed_max))
        smallest = self.envelope.smallest_radius(max(speed, 0.1), forecast.drift[-1])
        radius = max(math.hypot(state[0], state[1]), 1.1 * min(smallest, 1e4))
        return Guess(shares, np.array([radius, state[2], speed]) / DECISION_SCALE)


def effective_lag(lag: tuple[float, ...]) -> tuple[float, ...]:
    """Time constants for the problem: none if all are 0, else at least a millisecond each."""
    return tuple(max(value, 1e-3) for value in lag) if any(lag) else ()


def constant_data(parameters: TrackingParameters) -> FlightData:
    """What parameters alone decide; drift, orbit, floor and fence centre change with the flight."""
    envelope = parameters.envelope
    span = envelope.airspeed_max - envelope.airspeed_min
    slopes = [(force[1] - force[0]) / span for force in (envelope.force_min, envelope.force_max)]
    at_rest = [
        force[0] - slope * envelope.airspeed_min
        for force, slope in zip((envelope.force_min, envelope.force_max), slopes, strict=True)
    ]
    return FlightData(
        drift=np.zeros(3),
        drift_rate=np.zeros(3),
        orbit=np.zeros(3),
        sense=1.0,
        state_weights=parameters.state_weights,
        input_weights=parameters.input_weights,
        offset_weights=parameters.offset_weights,
        offset_reach=OFFSET_REACH
        * np.array([parameters.range, parameters.range, parameters.airspeed]),
        airspeed=(envelope.airspeed_min, envelope.airspeed_max),
        path_angle=(envelope.path_angle_min, envelope.path_angle_max),
        lateral=BANK_SHARE * GRAVITY * math.tan(envelope.bank_max),
        rates=(envelope.yaw_rate_max, envelope.pitch_rate_max),
        acceleration=(envelope.acceleration_min, envelope.acceleration_max),
        force_min=(at_rest[0] + FORCE_MARGIN, slopes[0]),
        force_max=(at_rest[1] - FORCE_MARGIN, slopes[1]),
        floor=-FLOOR_LIMIT,
        distance=envelope.distance_min,
        fence=(0.0, 0.0, envelope.fence_radius or NO_FENCE),
    )


def _solver(parameters: TrackingParameters, lag: tuple[float, ...]) -> Solver:
    problem = flight_problem(
        parameters.horizon, parameters.horizon_step, lag, parameters.limit_penalty
    )
    if parameters.solver == "newton":
        return NewtonSolver(problem, time_limit=parameters.solve_time_max)
    return CasadiSolver(problem, parameters.solver, time_limit=parameters.solve_time_max)
