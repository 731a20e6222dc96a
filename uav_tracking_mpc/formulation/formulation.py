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

"""What a formulation of the tracking problem offers: from a situation to a plan."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.dynamics.vehicle import Response
from uav_tracking_mpc.estimation.situation import Forecast, Situation
from uav_tracking_mpc.mpc.bridged_solver import BridgedSolver
from uav_tracking_mpc.mpc.casadi_solver import CasadiSolver
from uav_tracking_mpc.mpc.compiled_method import MachineCode
from uav_tracking_mpc.mpc.newton_solver import NewtonSolver
from uav_tracking_mpc.mpc.problem import OptimalControlProblem
from uav_tracking_mpc.mpc.solver import Solution, Solver
from uav_tracking_mpc.settings.tracking import ProblemParameters, TrackingParameters

if TYPE_CHECKING:
    from uav_tracking_mpc.terminal.decrease import DecreaseCheck, DecreaseMonitor


class Plan(NamedTuple):
    """Answer of a formulation.

    Attributes:
        inputs: (u_psi, u_chi, u_v) at 0, T_s, 2 T_s, ..., shape (N, 3), held in between.
        step: T_s in [s].
        error: Tracking error x, shape (5,).
        solution: What the solver said.
        orbit: Range [m], altitude [m] and airspeed [m/s] of the orbit that it ends on, shape (3,);
            None where that is the one asked for.
        decrease: Whether the optimal cost fell as (54) says; None where that cannot be told.
    """

    inputs: NDArray[np.float64]
    step: float
    error: NDArray[np.float64]
    solution: Solution
    orbit: NDArray[np.float64] | None = None
    decrease: DecreaseCheck | None = None


class Formulation(Protocol):
    """One way to pose the tracking problem, with its solver.

    Attributes:
        solver: Of the problem.
        step: T_s in [s].
    """

    solver: Solver
    step: float

    @property
    def decrease(self) -> DecreaseMonitor | None:
        """Watches (54); None where it says nothing."""

    def check(self, parameters: TrackingParameters) -> None:
        """Whether other parameters, of which no fixed one differs, can be taken.

        Args:
            parameters: All of them.

        Raises:
            ParameterError: They give no problem that can be solved.
        """

    def change(self, parameters: TrackingParameters) -> None:
        """Fly other parameters from now on, of which no fixed one differs.

        Args:
            parameters: The new ones.
        """

    def respond(self, response: Response) -> None:
        """Predict with another response of the aircraft until the parameters change.

        Args:
            response: As it was learnt in flight.
        """

    def soften(self, factors: NDArray[np.float64]) -> None:
        """Weigh changes of the inputs' rates more from now on, as far as they are weighed at all.

        Args:
            factors: Of the weights of turn rate, path-angle rate and acceleration, shape (3,), at
                least 1 [-].
        """

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

    def reset(self) -> None:
        """Forget the last plan."""


SolverMaker = Callable[[OptimalControlProblem, ProblemParameters], Solver]


def solver_of(problem: OptimalControlProblem, parameters: ProblemParameters) -> Solver:
    """The solver that parameters ask for.

    Args:
        problem: What it solves.
        parameters: Name of the solver and its time budget.
    """
    budget = parameters.solve_time_max
    if parameters.solver == "newton":
        return NewtonSolver(problem, time_limit=budget)
    return CasadiSolver(problem, time_limit=budget)


def solver_at_once(report: Callable[[str], None]) -> SolverMaker:
    """Like :func:`solver_of`, but what is to be compiled is compiled while another one solves.

    Args:
        report: Called with what happens, in words.
    """

    def make(problem: OptimalControlProblem, parameters: ProblemParameters) -> Solver:
        if parameters.solver != "newton":
            return solver_of(problem, parameters)
        code = MachineCode(problem, report)
        solver = BridgedSolver(problem, code, parameters.solve_time_max)
        solver.prepare()
        return solver

    return make


def solver_as_told(compiled: Callable[[], bool]) -> SolverMaker:
    """What :func:`solver_at_once` makes, for a flight in which it is known which one solved.

    Args:
        compiled: Whether the compiled one solves from now on.
    """

    def make(problem: OptimalControlProblem, parameters: ProblemParameters) -> Solver:
        if parameters.solver != "newton":
            return solver_of(problem, parameters)
        return BridgedSolver(problem, compiled, parameters.solve_time_max)

    return make
