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

"""Solves at once, with IPOPT, while the Newton method is being compiled for the problem.

IPOPT needs no compilation, but some fifty times as long for a solve: a few plans a second about a
hard problem, which an aircraft can fly by. Between two solves the Newton method takes over and goes
on from IPOPT's last plan.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from numpy.typing import ArrayLike

from uav_tracking_mpc.mpc.casadi_solver import CasadiSolver
from uav_tracking_mpc.mpc.compiled_method import BRIDGE, MachineCode
from uav_tracking_mpc.mpc.newton_solver import NewtonSolver
from uav_tracking_mpc.mpc.problem import OptimalControlProblem
from uav_tracking_mpc.mpc.solver import Guess, Solution, Solver, shift

TOLERANCE = 1e-4  # -, tolerance of IPOPT's optimality: half the iterations of 1e-8, the same flight
# s, that IPOPT has for a solve at least; it takes half of it for an attempt, and a command that is
# later than that is worth nothing.
BUDGET = 0.8


class BridgedSolver:
    """Solver (see :class:`uav_tracking_mpc.mpc.solver.Solver`) that is ready at once.

    Args:
        problem: What to solve.
        compiled: Whether the Newton method can be loaded; asked before every solve.
        time_limit: For a whole solve of the Newton method, in [s]; IPOPT has at least
            :data:`BUDGET`.

    Attributes:
        problem: As above.
        time_limit: As above; what is set counts from the next solve on.
    """

    def __init__(
        self,
        problem: OptimalControlProblem,
        compiled: Callable[[], bool],
        time_limit: float = math.inf,
    ) -> None:
        self.problem = problem
        self._compiled = compiled
        self.time_limit = time_limit
        self._solver: Solver | None = None

    def prepare(self) -> Solver:
        """The solver that solves next; made now if it is not there."""
        longer = max(self.time_limit, BUDGET)
        if self._solver is None and self._compiled():
            self._solver = NewtonSolver(self.problem)
        elif self._solver is None:
            self._solver = CasadiSolver(self.problem, TOLERANCE, time_limit=longer)
        self._solver.time_limit = longer if self._solver.name == BRIDGE else self.time_limit
        return self._solver

    @property
    def name(self) -> str:
        """Of the solver that has solved last, or solves next."""
        return self.prepare().name

    @property
    def compiling(self) -> bool:
        """Whether another solver stands in only until this problem's is compiled."""
        waits = isinstance(self._compiled, MachineCode) and self._compiled.pending
        return waits and self.name == BRIDGE

    def change(self, problem: OptimalControlProblem) -> None:
        """See :meth:`uav_tracking_mpc.mpc.solver.Solver.change`."""
        self.problem = problem
        if self._solver is not None:
            self._solver.change(problem)

    def reset(self) -> None:
        """Forget the last plan: the next solve starts cold."""
        if self._solver is not None:
            self._solver.reset()

    def solve(
        self,
        initial_state: ArrayLike,
        parameters: ArrayLike | None = None,
        elapsed: float | None = None,
        guess: Callable[[], Guess | None] | None = None,
    ) -> Solution:
        """Solve P_N(x_0), (16): see :meth:`uav_tracking_mpc.mpc.solver.Solver.solve`."""
        solver = self.prepare()
        if isinstance(solver, CasadiSolver) and self._compiled():
            last, self._solver = solver.last, None
            solver = self.prepare()
            if last is not None and elapsed is not None:
                inputs = shift(last.inputs, max(0.0, elapsed) / self.problem.step)
                begin = Guess(inputs, last.decision)
                return solver.solve(initial_state, parameters, None, lambda: begin)
        return solver.solve(initial_state, parameters, elapsed, guess)
