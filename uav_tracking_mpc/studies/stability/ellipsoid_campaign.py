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

"""Fly many random states of X_f on the discrete model: does what was proved show?

Under kappa_l three things are proved, and counted here: the state stays in X_f, the input in U,
V_f falls by at least the stage cost. Under the NMPC with the hard terminal set the optimal cost
falls and inputs stay in U; that x itself stays in X_f is not a theorem (the optimum may leave and
return: its cost stays below varrho all the same) and is counted as an observation.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.formulation.paper_problem import tracking_problem
from uav_tracking_mpc.mpc.newton_solver import NewtonSolver
from uav_tracking_mpc.mpc.prediction_loop import solutions
from uav_tracking_mpc.studies.parallel import parallel_map
from uav_tracking_mpc.terminal.stability_problem import StabilityProblem
from uav_tracking_mpc.terminal.theorems import q_star
from uav_tracking_mpc.terminal.violation import directions


@dataclass(frozen=True)
class CampaignResult:
    """Counts over all flights.

    Attributes:
        law: ``kappa_l`` or ``nmpc``.
        flights: States flown.
        steps: Steps flown in all.
        left: Flights in which the state left X_f.
        outside_inputs: Flights in which the input left U.
        cost_rose: Flights in which the cost did not fall at some step.
        failures: Flights in which a solve failed.
        largest_height: Largest V_f seen over varrho [-].
    """

    law: str
    flights: int
    steps: int
    left: int
    outside_inputs: int
    cost_rose: int
    failures: int
    largest_height: float

    @property
    def clean(self) -> bool:
        """Nothing happened that the proof excludes."""
        return not (self.outside_inputs or self.cost_rose or self.failures or self.left)


def random_states(
    problem: StabilityProblem, level: float, count: int, seed: int = 0
) -> NDArray[np.float64]:
    """States uniform in the volume of X_f, shape (count, 5), error coordinates.

    Args:
        problem: The configuration.
        level: varrho [-].
        count: How many.
        seed: Of the generator.
    """
    generator = np.random.default_rng(seed)
    radius = np.sqrt(level) * generator.uniform(0.0, 1.0, (count, 1)) ** 0.2
    return radius * directions(problem.ingredients().weight, count, generator)


def fly_local(
    problem: StabilityProblem, level: float, states: NDArray[np.float64], steps: int = 60
) -> CampaignResult:
    """Fly kappa_l from every state.

    Args:
        problem: The configuration.
        level: varrho [-].
        states: Shape (count, 5).
        steps: Of every flight.
    """
    parts, dynamics = problem.ingredients(), problem.dynamics()
    lower, upper = problem.deviation_bounds()
    star = q_star(problem.state_weight, problem.input_weight, parts.gain)
    x = np.asarray(states, dtype=float)
    count = len(x)
    left, outside, rose = (np.zeros(count, dtype=bool) for _ in range(3))
    height = np.einsum("ki,ij,kj->k", x, parts.weight, x)
    largest = float(height.max())
    for _ in range(steps):
        u = x @ parts.gain.T
        outside |= np.any((u < lower - 1e-12) | (u > upper + 1e-12), axis=1)
        stage = np.einsum("ki,ij,kj->k", x, star, x)
        x = np.array(dynamics(x.T, u.T)).T
        following = np.einsum("ki,ij,kj->k", x, parts.weight, x)
        # Below a rounding floor there is no decrease left to see.
        rose |= ~(following <= height - stage + 1e-12 * level)
        left |= ~(following <= level * (1.0 + 1e-12))
        height = following
        largest = max(largest, float(height.max()))
    return CampaignResult(
        law="kappa_l",
        flights=count,
        steps=count * steps,
        left=int(left.sum()),
        outside_inputs=int(outside.sum()),
        cost_rose=int(rose.sum()),
        failures=0,
        largest_height=largest / level,
    )


@dataclass(frozen=True)
class _Piece:
    problem: StabilityProblem
    level: float
    states: NDArray[np.float64]
    steps: int


def fly_nmpc(
    problem: StabilityProblem,
    level: float,
    states: NDArray[np.float64],
    steps: int = 20,
    workers: int | None = None,
    show: bool = True,
) -> CampaignResult:
    """Fly the NMPC with the hard terminal set from every state.

    Args:
        problem: The configuration; its N counts.
        level: varrho [-].
        states: Shape (count, 5).
        steps: Of every flight; it ends sooner once the cost is below a millionth of varrho.
        workers: Processes.
        show: Progress bar on stderr.
    """
    chunks = np.array_split(np.asarray(states, dtype=float), max(1, len(states) // 50))
    pieces = [_Piece(problem, level, chunk, steps) for chunk in chunks]
    parts = parallel_map(_fly_piece, pieces, workers, "NMPC flights", show)
    flights = [flight for part in parts for flight in part]
    return CampaignResult(
        law="nmpc",
        flights=len(flights),
        steps=sum(flight.steps for flight in flights),
        left=sum(flight.height > level * (1.0 + 1e-9) for flight in flights),
        outside_inputs=sum(flight.outside_inputs for flight in flights),
        cost_rose=sum(flight.cost_rose for flight in flights),
        failures=sum(flight.failed for flight in flights),
        largest_height=max((flight.height for flight in flights), default=0.0) / level,
    )


@dataclass(frozen=True)
class _Flight:
    """One flight of the NMPC.

    Attributes:
        steps: Solves.
        height: Largest V_f [-] after a step.
        outside_inputs: An input left U.
        cost_rose: The cost did not fall at some step.
        failed: A solve did not converge; the flight ended there.
    """

    steps: int
    height: float
    outside_inputs: bool
    cost_rose: bool
    failed: bool


def _fly_piece(piece: _Piece) -> list[_Flight]:
    problem, level = piece.problem, piece.level
    weight = problem.ingredients().weight
    lower, upper = problem.deviation_bounds()
    solver = NewtonSolver(tracking_problem(problem, level))
    flights = []
    for start in piece.states:
        steps, height, cost = 0, 0.0, np.inf
        outside = rose = failed = False
        for solution in islice(solutions(solver, start), piece.steps):
            steps += 1
            failed = not solution.converged
            if failed:
                break
            # Solvers stop at a tolerance: allow it, not more.
            rose |= bool(solution.cost > cost + 1e-7 * level)
            cost, inputs, following = solution.cost, solution.inputs[0], solution.states[1]
            outside |= bool(np.any((inputs < lower - 1e-9) | (inputs > upper + 1e-9)))
            height = max(height, float(following @ weight @ following))
            if cost < 1e-6 * level:
                break
        flights.append(_Flight(steps, height, outside, rose, failed))
    return flights
