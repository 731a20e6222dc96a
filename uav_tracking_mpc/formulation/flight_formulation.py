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

"""The flight problem, fed with what is known: parameters, situation, forecast."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.dynamics.vehicle import Response
from uav_tracking_mpc.estimation.situation import Forecast, Situation
from uav_tracking_mpc.estimation.wind_filter import GUST_WALK
from uav_tracking_mpc.formulation.flight_problem import DECISION_SCALE, FlightProblem, part_of
from uav_tracking_mpc.formulation.formulation import Plan, SolverMaker, solver_of
from uav_tracking_mpc.laws.vector_field import VectorField
from uav_tracking_mpc.mpc.solver import FEASIBLE_VIOLATION, Guess, Solution, Solver
from uav_tracking_mpc.settings.tracking import FlightParameters
from uav_tracking_mpc.symbolic.native_code import NativeFunction

# -, share of the wanted range, range and airspeed at which the penalty of the artificial orbit's
# offset turns from quadratic to linear. Steep near the wanted orbit, or errors would be shared
# between both and met half-heartedly; linear beyond, or far away it would drown everything else.
OFFSET_REACH = np.array([0.01, 0.01, 0.03])
# -, share of the wanted range: where the range errs by more, the aircraft is on its way in. There
# its height is no part of the range, for which it would dive towards a target on the ground. And -,
# how many times more changes of climb and acceleration weigh there.
FAR, GENTLER = 0.04, 30.0
LEAST_SOFTENED = 0.01  # -, weight of a rate from which on a loop is softened that has none
# -, times the weight of changes of the turn rate, in calm air and from moderate gusts on: an
# autopilot's roll loop swings near 1 Hz, which no lag and dead time tell, and gusts keep it going.
HELD_SOFTNESS = 4.0, 16.0


class FlightFormulation:
    """Problem of :mod:`flight_problem` and its solver.

    Args:
        parameters: What is flown; :meth:`change` takes new ones while flying.
        solver: Of this problem; made by default.
        make_solver: Makes it, as the parameters say.

    Attributes:
        flight: The problem, with the layout of its parameter.
        solver: Of it.
        step: T_s in [s].
        decrease: None: (54) is about a fixed terminal set.
    """

    def __init__(
        self,
        parameters: FlightParameters,
        solver: Solver | None = None,
        make_solver: SolverMaker = solver_of,
    ) -> None:
        self.step = parameters.horizon_step
        self.decrease = None
        self._stages = parameters.horizon
        self.flight = flight_problem(parameters)
        self.solver = solver or make_solver(self.flight.problem, parameters)
        self._data = np.zeros((self._stages + 1, self.flight.size))
        self._turn_acceleration = NativeFunction(
            self.flight.turn_acceleration, [None, self._data[0]]
        )
        commands = self.flight.commands.map(self._stages).expand()
        self._commands = NativeFunction(commands, [None, self._data[:-1]])
        self._law_stage = NativeFunction(self.flight.law_stage)
        # Altitude above the target [m] and airspeed [m/s] that the last plan has decided on, and
        # the height above the target with which it ends [m].
        self._held: tuple[float, float, float] | None = None
        self._factors = np.ones(3)
        self.change(parameters)

    def check(self, parameters: FlightParameters) -> None:
        """See :meth:`Formulation.check`: every orbit inside the envelope can be taken."""

    def change(self, parameters: FlightParameters) -> None:
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
            "airspeed_band": parameters.airspeed
            * (1.0 + parameters.airspeed_band * np.array([-1.0, 1.0])),
            "offset_weights": parameters.offset_weights,
            "offset_reach": OFFSET_REACH * reach,
            "slant": 1.0,
            **{part_of(limit): limit.numbers(nowhere) for limit in self.envelope.limits},
        }
        for name, values in parts.items():
            self._data[:, self.flight.where[name]] = values
        self._on_ground = [
            (self.flight.where[part_of(limit)], limit)
            for limit in self.envelope.limits
            if limit.on_ground
        ]
        self._weigh()
        self.solver.time_limit = parameters.solve_time_max
        self.respond(parameters.flown_by(parameters.response))

    def respond(self, response: Response) -> None:
        """See :meth:`Formulation.respond`."""
        self.model = self.model.with_lags(response.lags)
        where = self.flight.where
        # Held commands lag by tau, and by half a step behind what they follow.
        lag = float(self.model.lags[0])
        self._data[:, where["lead"]] = lag + 0.5 * self.step
        # What lags by tau behind a step changes by 1 / tau of it per second at the beginning, by
        # (1 - exp(-T / tau)) / T in the mean over a time T. tau is taken as at least T / 2.
        steps = self.step / max(lag, 0.5 * self.step)
        self._data[:, where["onset"]] = steps / -math.expm1(-steps)
        self._data[:, where["model"]] = self.model.numbers(self.step)

    def soften(self, factors: NDArray[np.float64]) -> None:
        """See :meth:`Formulation.soften`."""
        self._factors = factors.copy()
        self._weigh()

    def _weigh(self, gust_walk: float = 0.0) -> None:
        """Weights of the inputs' rates; of an aircraft that is held the gusts count."""
        weights = np.array(self.parameters.rate_weights)
        if self.flight.holds:
            least, most = HELD_SOFTNESS
            weights[0] *= min(max(least, most * gust_walk / GUST_WALK), most)
        softened = self._factors * np.maximum(weights, LEAST_SOFTENED)
        self._rate_weights = np.where(self._factors > 1.0, softened, weights)
        self._data[:, self.flight.where["rate_weights"]] = self._rate_weights

    def _on_way_in(self, far: float) -> None:
        """What counts otherwise where the range errs by so many times :data:`FAR`."""
        where, slant = self.flight.where, 1.0 / (1.0 + far**4)
        gentler = 1.0 + GENTLER * (1.0 - slant)
        self._data[:, where["slant"]] = slant
        self._data[:, where["rate_weights"]] = self._rate_weights * [1.0, gentler, gentler]

    def reset(self) -> None:
        """Forget the last plan."""
        self.solver.reset()
        self._held = None

    def solve(
        self, situation: Situation, forecast: Forecast, orbit: Orbit, elapsed: float | None
    ) -> Plan:
        """See :meth:`Formulation.solve`."""
        x_0, error = self.initial_state(situation), situation.tracking_error(orbit)
        data = self.data(forecast, orbit)
        if not self.flight.holds:
            self._on_way_in(float(error[0]) / (FAR * orbit.range))
        solution = self.solver.solve(
            x_0, data, elapsed, lambda: self.guess(x_0, forecast, orbit, data)
        )
        if not solution.converged and FEASIBLE_VIOLATION < solution.violation < math.inf:
            words = self._missed(forecast)
            solution = solution._replace(message=f"{words}: {solution.message}")
        inputs = self._inputs(solution)
        inputs[0, 0] -= self._lead_of_stage(x_0, solution.decision)
        radius, altitude, airspeed = (solution.decision * DECISION_SCALE).tolist()
        height = altitude
        if self.flight.holds:
            height = float(self.model.State(*solution.states[-1]).z)
            if solution.converged:
                self._held = altitude, airspeed, height
        held = np.array([math.hypot(radius, height), altitude, airspeed])
        return Plan(inputs, self.step, error, solution, held)

    def _missed(self, forecast: Forecast) -> str:
        """What no plan reaches, in words: limits are soft, so it is the orbit at its end."""
        passes, most = math.hypot(*forecast.drift[0, :2].tolist()), self.parameters.airspeed_max
        if passes >= most:
            return f"the target moves through the air at {passes:.3g} m/s, the aircraft at {most:g}"
        return f"no plan of {self.flight.problem.horizon * self.step:g} s ends on an orbit"

    def _inputs(self, solution: Solution) -> NDArray[np.float64]:
        """(u_psi, u_chi, u_v) of each stage, shape (N, 3)."""
        states, _, shares = self._commands.arguments
        states[:], shares[:] = solution.states[:-1].reshape(-1), solution.inputs.reshape(-1)
        self._commands.evaluate()
        return self._commands.results[0].reshape(-1, 3).copy()

    def _lead_of_stage(self, x_0: NDArray[np.float64], decision: NDArray[np.float64]) -> float:
        """By how much the first input leads the turn rate of the orbit when it is flown, [rad/s].

        It is that of the middle of its stage, but the next command comes after a control period.
        """
        state, _, decided = self._turn_acceleration.arguments
        state[:], decided[:] = x_0, decision
        self._turn_acceleration.evaluate()
        acceleration = float(self._turn_acceleration.results[0][0])
        return 0.5 * (self.step - 1.0 / self.parameters.control_rate) * acceleration

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
        data, where = self._data, self.flight.where
        data[:, where["drift"]] = forecast.drift
        data[:, where["drift_rate"]] = forecast.drift_rate
        data[:, where["orbit"]] = orbit.range, orbit.altitude, orbit.speed
        data[:, where["sense"]] = orbit.sense
        if self.flight.holds:
            held = self._held or (orbit.altitude, orbit.speed, orbit.altitude)
            data[:, where["held"]], data[:, where["end_height"]] = held[:2], held[2]
            self._weigh(forecast.gust_walk)
        for part, limit in self._on_ground:
            data[:, part] = limit.numbers(forecast.target)
        return data

    def guess(
        self, x_0: NDArray[np.float64], forecast: Forecast, orbit: Orbit, data: NDArray[np.float64]
    ) -> Guess | None:
        """A flight by the vector field: a plan that is flyable and leads to the orbit.

        Args:
            x_0: State of the problem where the plan begins, shape (nx,).
            forecast: Drift and target over the horizon.
            orbit: What is wanted.
            data: P of every stage, shape (N + 1, np).

        Returns:
            None where something is not finite.
        """
        if not (np.all(np.isfinite(x_0)) and np.all(np.isfinite(data))):
            return None
        law, free = VectorField(orbit, self.envelope), self.model.commanded
        state, shares = np.array(x_0, dtype=float), np.zeros((self._stages, free))
        x, wanted, p = self._law_stage.arguments
        for stage in range(self._stages):
            target = forecast.target[stage]
            vehicle = state[:6].copy()
            vehicle[:3] += target
            now = Situation(
                vehicle, target, forecast.drift[stage], forecast.drift_rate[stage], state[6:9]
            )
            x[:], wanted[:], p[:] = state, law.inputs(now), data[stage]
            self._law_stage.evaluate()
            shares[stage], state = self._law_stage.results
        east, north, up, _, _, airspeed = state[:6].tolist()
        least, most = self.envelope.airspeed_min, self.envelope.airspeed_max
        speed = float(np.clip(airspeed, least, most))
        smallest = self.envelope.smallest_radius(max(speed, 0.1), forecast.drift[-1])
        radius = max(math.hypot(east, north), 1.1 * min(smallest, 1e4))
        return Guess(shares, np.array([radius, up, speed]) / DECISION_SCALE)


def flight_problem(parameters: FlightParameters) -> FlightProblem:
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
