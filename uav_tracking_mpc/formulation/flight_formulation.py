"""The flight problem, fed with what is known: parameters, situation, forecast."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.orbit import COUNTER_CLOCKWISE, Orbit
from uav_tracking_mpc.dynamics.vehicle_models import Drift
from uav_tracking_mpc.estimation.forecast import Forecast
from uav_tracking_mpc.estimation.situation import Situation
from uav_tracking_mpc.formulation.flight_problem import DECISION_SCALE, FlightProblem, part_of
from uav_tracking_mpc.formulation.formulation import Plan, solver_of
from uav_tracking_mpc.laws.vector_field import VectorField
from uav_tracking_mpc.mpc.solver import Guess, Solver
from uav_tracking_mpc.settings.tracking import TrackingParameters

# Where the cost of the artificial orbit's offset turns from quadratic to linear, as a share of the
# wanted range, range and airspeed. Steep near the wanted orbit, or errors would be shared between
# both and met half-heartedly; linear beyond, or far away it would drown everything else.
OFFSET_REACH = np.array([0.01, 0.01, 0.03])


class FlightFormulation:
    """Problem of :mod:`flight_problem` and its solver.

    Args:
        parameters: What is flown; :meth:`change` takes new ones while flying.
        solver: Of this problem; made as the parameters say by default.

    Attributes:
        flight: The problem, with the layout of its parameter.
        solver: Of it.
        step: T_s in [s].
        decrease: None: (54) is about a fixed terminal set.
    """

    def __init__(self, parameters: TrackingParameters, solver: Solver | None = None) -> None:
        self.step = parameters.horizon_step
        self.decrease = None
        self._stages = parameters.horizon
        self.flight = flight_problem(parameters)
        self.solver = solver or solver_of(self.flight.problem, parameters)
        function = self.flight.turn_acceleration
        self._arguments = [np.zeros(function.size1_in(k)) for k in range(3)]
        self._turn_acceleration = np.zeros(1)
        # A call of the function converts its arguments, which takes 200 times as long.
        self._buffer, self._evaluate = function.buffer()
        for k, argument in enumerate(self._arguments):
            self._buffer.set_arg(k, memoryview(argument))  # type: ignore
        self._buffer.set_res(0, memoryview(self._turn_acceleration))  # type: ignore
        self._data = np.zeros((self._stages + 1, self.flight.layout.size))
        # Altitude above the target [m] and airspeed [m/s] that the last plan has decided on, and
        # the height above the target with which it ends [m].
        self._held: tuple[float, float, float] | None = None
        self.change(parameters)

    def change(self, parameters: TrackingParameters) -> None:
        """Fly other orbits, weights, limits and lags from now on.

        Args:
            parameters: The new ones.
        """
        self.parameters = parameters
        self.envelope = parameters.envelope
        self.model = parameters.vehicle
        reach = np.array([parameters.range, parameters.range, parameters.airspeed])
        nowhere = np.zeros((self._stages + 1, 3))
        parts = {
            "state_weights": parameters.state_weights,
            "input_weights": parameters.input_weights,
            "rate_weights": parameters.rate_weights,
            "airspeed_band": parameters.airspeed
            * (1.0 + parameters.airspeed_band * np.array([-1.0, 1.0])),
            "offset_weights": parameters.offset_weights,
            "offset_reach": OFFSET_REACH * reach,
            # Held commands lag by tau, and by half a step behind what they follow.
            "lead": float(self.model.lags[0]) + 0.5 * self.step,
            "model": self.model.numbers(self.step),
            **{part_of(limit): limit.numbers(nowhere) for limit in self.envelope.limits},
        }
        for name, values in parts.items():
            self._data[:, self.flight.layout.where[name]] = values
        self._on_ground = [
            (self.flight.layout.where[part_of(limit)], limit)
            for limit in self.envelope.limits
            if limit.on_ground
        ]
        self.solver.time_limit = parameters.solve_time_max

    def reset(self) -> None:
        """Forget the last plan."""
        self.solver.reset()
        self._held = None

    def error(self, situation: Situation, orbit: Orbit) -> NDArray[np.float64]:
        """Tracking error of the relative motion (Section 3.1), shape (5,), angles wrapped.

        Args:
            situation: Aircraft and target.
            orbit: What is wanted.
        """
        x, y, z = situation.offset
        w_x, w_y, _ = situation.relative_velocity
        theta = math.atan2(w_y, w_x) - math.atan2(y, x) - math.pi - orbit.bearing
        _, _, _, _, path_angle, airspeed = situation.vehicle
        return np.array(
            [
                math.sqrt(x * x + y * y + z * z) - orbit.range,
                math.remainder(theta, 2.0 * math.pi),
                z - orbit.altitude,
                path_angle,
                airspeed - orbit.speed,
            ]
        )

    def solve(
        self, situation: Situation, forecast: Forecast, orbit: Orbit, elapsed: float | None
    ) -> Plan:
        """See :meth:`Formulation.solve`."""
        x_0 = self.initial_state(situation)
        data = self.data(forecast, orbit)
        solution = self.solver.solve(
            x_0, data, elapsed, lambda: self.guess(x_0, situation, forecast, orbit, data)
        )
        states = self.model.State(*solution.states[:-1].T)
        inputs = np.array(self.flight.inputs(solution.inputs.T, states, data[:-1].T)).T
        inputs[0, 0] -= self._lead_of_stage(x_0, data[0], solution.decision)
        radius, altitude, airspeed = (solution.decision * DECISION_SCALE).tolist()
        height = altitude
        if self.flight.holds:
            height = float(self.model.State(*solution.states[-1]).z)
            if solution.converged:
                self._held = altitude, airspeed, height
        held = np.array([math.hypot(radius, height), altitude, airspeed])
        return Plan(inputs, self.step, self.error(situation, orbit), solution, held)

    def _lead_of_stage(
        self, x_0: NDArray[np.float64], data: NDArray[np.float64], decision: NDArray[np.float64]
    ) -> float:
        """By how much the first input leads the turn rate of the orbit when it is flown, [rad/s].

        It is that of the middle of its stage, but the next command comes after a control period.
        """
        for kept, value in zip(self._arguments, (x_0, data, decision), strict=True):
            kept[:] = value
        self._evaluate()
        (acceleration,) = self._turn_acceleration
        return 0.5 * (self.step - 1.0 / self.parameters.control_rate) * float(acceleration)

    def initial_state(self, situation: Situation) -> NDArray[np.float64]:
        """x_0 of the problem, shape (nx,).

        Args:
            situation: Where the plan begins.
        """
        return np.array(self.model.initial(situation.vehicle, situation.target, situation.rates))

    def data(self, forecast: Forecast, orbit: Orbit) -> NDArray[np.float64]:
        """P of every stage, shape (N + 1, np): one array, filled anew at each call.

        Args:
            forecast: Drift and target over the horizon.
            orbit: What is wanted.
        """
        data, where = self._data, self.flight.layout.where
        data[:, where["drift"]] = forecast.drift
        data[:, where["drift_rate"]] = forecast.drift_rate
        data[:, where["orbit"]] = orbit.range, orbit.altitude, orbit.speed
        data[:, where["sense"]] = 1.0 if orbit.direction == COUNTER_CLOCKWISE else -1.0
        if self.flight.holds:
            held = self._held or (orbit.altitude, orbit.speed, orbit.altitude)
            data[:, where["held"]], data[:, where["end_height"]] = held[:2], held[2]
        for part, limit in self._on_ground:
            data[:, part] = limit.numbers(forecast.target)
        return data

    def guess(
        self,
        x_0: NDArray[np.float64],
        situation: Situation,
        forecast: Forecast,
        orbit: Orbit,
        data: NDArray[np.float64],
    ) -> Guess | None:
        """A flight by the vector field: a plan that is flyable and leads to the orbit.

        Args:
            x_0: State of the problem where the plan begins, shape (nx,).
            situation: What else is known of the aircraft.
            forecast: Drift and target over the horizon.
            orbit: What is wanted.
            data: P of every stage, shape (N + 1, np).

        Returns:
            None where something is not finite.
        """
        if not (np.all(np.isfinite(x_0)) and np.all(np.isfinite(data))):
            return None
        law, free = VectorField(orbit, self.envelope), self.model.commanded
        state, shares = self.model.State(*x_0.tolist()), np.zeros((self._stages, free))
        numbers = self.model.numbers(self.step).tolist()
        for stage in range(self._stages):
            target = forecast.target[stage]
            x, y, z, psi, chi, v, *rates = state
            now = replace(
                situation,
                vehicle=np.array([x + target[0], y + target[1], z + target[2], psi, chi, v]),
                target=target,
                drift=forecast.drift[stage],
                drift_rate=forecast.drift_rate[stage],
                rates=np.array(rates[:3]),
            )
            middle, half = (np.array(part) for part in self.flight.span(state, data[stage]))
            shares[stage] = np.clip((law.inputs(now) - middle) / half, -1.0, 1.0)[:free]
            drift = Drift(now.drift.tolist(), now.drift_rate.tolist())
            flown = [float(u) for u in self.flight.inputs(shares[stage], state, data[stage])]
            state = self.model.step(state, flown, self.step, numbers, drift)
        least, most = self.envelope.airspeed_min, self.envelope.airspeed_max
        speed = float(np.clip(state.airspeed, least, most))
        smallest = self.envelope.smallest_radius(max(speed, 0.1), forecast.drift[-1])
        radius = max(math.hypot(state.x, state.y), 1.1 * min(smallest, 1e4))
        return Guess(shares, np.array([radius, state.z, speed]) / DECISION_SCALE)


def flight_problem(parameters: TrackingParameters) -> FlightProblem:
    """The flight problem that parameters ask for.

    Args:
        parameters: Horizon, model and limits; of the latter only which they are.
    """
    return FlightProblem(
        parameters.vehicle,
        parameters.envelope.limits,
        parameters.horizon,
        parameters.horizon_step,
        parameters.limit_penalty,
    )
