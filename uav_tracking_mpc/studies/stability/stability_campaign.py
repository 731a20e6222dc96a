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

"""Where P_N is feasible, mapped, and random states of X_f, flown on the discrete model.

**Maps** of the domain of attraction X_N (20), which is five-dimensional: a map is a slice through
it, two coordinates varied, the others held. At each state P_N is solved with the terminal set hard,
from several starts. "Feasible" is a fact: a plan was found. "Infeasible" is what a local solver
says after all its starts, which is no proof; where a bound on what can be flown at all excludes the
state (see ``distance_budget``) it is one.

**Flights.** Under kappa_l three things are proved, and counted here: the state stays in X_f, the
input in U, V_f falls by at least the stage cost. Under the NMPC with the hard terminal set the
optimal cost falls and inputs stay in U; that x itself stays in X_f is not a theorem (the optimum
may leave and return: its cost stays below varrho all the same) and is counted as an observation.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import islice
from typing import IO

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics import paper_numbers
from uav_tracking_mpc.dynamics.relative import tracking_error
from uav_tracking_mpc.formulation.paper_formulation import tracking_problem
from uav_tracking_mpc.mpc.newton_solver import NewtonSolver
from uav_tracking_mpc.mpc.solver import Solution, Solver, solutions
from uav_tracking_mpc.studies.executors import parallel_map
from uav_tracking_mpc.terminal.ingredients import (
    PAPER_INITIAL_STATE,
    StabilityProblem,
    directions,
    q_star,
)

# Columns of an error, and the units of their names.
COORDINATES = {"range": 0, "bearing": 1, "altitude": 2, "path_angle": 3, "speed": 4}
UNITS = {"range": "m", "bearing": "rad", "altitude": "m", "path_angle": "rad", "speed": "m/s"}
FEASIBLE_VIOLATION = 1e-5  # -, largest violation of a hard constraint, scaled


@dataclass(frozen=True)
class Slice:
    """A two-dimensional slice of the state space.

    Attributes:
        first: Coordinate along the rows, a key of :data:`COORDINATES`.
        first_values: Its values, shape (n,).
        second: Coordinate along the columns.
        second_values: Its values, shape (m,).
        base: State (r, theta, z, chi, v) that gives the other coordinates, shape (5,).
    """

    first: str
    first_values: NDArray[np.float64]
    second: str
    second_values: NDArray[np.float64]
    base: NDArray[np.float64]

    def state(self, i: int, j: int) -> NDArray[np.float64]:
        """State at row i, column j, shape (5,)."""
        state = np.array(self.base, dtype=float)
        state[COORDINATES[self.first]] = self.first_values[i]
        state[COORDINATES[self.second]] = self.second_values[j]
        return state


@dataclass(frozen=True)
class AttractionMap:
    """Feasibility over a slice.

    Attributes:
        slice: Where.
        horizon: N.
        feasible: Shape (n, m).
        cost: V_N there, nan where infeasible, shape (n, m).
        marked: State that is marked, shape (5,).
        marked_feasible: Whether P_N is feasible from it.
    """

    slice: Slice
    horizon: int
    feasible: NDArray[np.bool_]
    cost: NDArray[np.float64]
    marked: NDArray[np.float64]
    marked_feasible: bool


def default_slices(problem: StabilityProblem, points: int = 25) -> list[Slice]:
    """(range, bearing) and (range, speed) about the paper's initial state.

    Args:
        problem: The configuration: the slices' height and speed are the paper's where the orbit is
            the paper's, else the orbit's own.
        points: Along each coordinate.
    """
    orbit = problem.orbit
    base = marked_state(problem)
    low = max(1.05 * abs(base[COORDINATES["altitude"]]), 0.3 * orbit.range)
    ranges = np.linspace(low, 2.0 * orbit.range, points)
    bearings = np.linspace(-np.pi, np.pi, points)
    speeds = np.linspace(0.0, 2.5 * orbit.speed, points)
    return [
        Slice("range", ranges, "bearing", bearings, base),
        Slice("range", ranges, "speed", speeds, base),
    ]


def marked_state(problem: StabilityProblem) -> NDArray[np.float64]:
    """x_o of the paper, scaled to the orbit where that is not the paper's, shape (5,).

    Args:
        problem: The configuration.
    """
    orbit = problem.orbit
    r, theta, z, chi, v = PAPER_INITIAL_STATE
    wider, higher = (
        orbit.range / paper_numbers.ORBIT.range,
        orbit.altitude / paper_numbers.ORBIT.altitude,
    )
    return np.array([r * wider, theta, z * higher, chi, v])


def attraction_map(
    problem: StabilityProblem,
    level: float | None,
    where: Slice,
    horizon: int,
    workers: int | None = None,
    show: bool = True,
) -> AttractionMap:
    """Map X_N over a slice.

    Args:
        problem: The configuration.
        level: varrho [-] of the hard terminal set; None leaves the set away.
        where: The slice.
        horizon: N [-].
        workers: Processes, all cores by default.
        show: Progress bar on stderr.
    """
    changed = replace(problem, horizon=horizon)
    marked = marked_state(problem)
    pieces = [
        (changed, level, np.array([where.state(i, j) for j in range(len(where.second_values))]))
        for i in range(len(where.first_values))
    ]
    pieces.append((changed, level, marked[None]))
    label = f"X_{horizon} over {where.first}, {where.second}"
    *rows, (marked_cost,) = parallel_map(_solve_row, pieces, workers, label, show)
    costs = np.array(rows)
    found = bool(np.isfinite(marked_cost))
    return AttractionMap(where, horizon, np.isfinite(costs), costs, marked, found)


def _solve_row(row: tuple[StabilityProblem, float | None, NDArray[np.float64]]) -> list[float]:
    """Costs along a row, nan where no plan was found: forwards, then backwards over the gaps."""
    problem, level, states = row
    solver = NewtonSolver(tracking_problem(problem, level))
    starts = [tracking_error(state, problem.orbit) for state in states]
    costs = [_cheapest(solver, start) for start in starts]
    for j in reversed(range(len(starts) - 1)):
        if np.isnan(costs[j]) and np.isfinite(costs[j + 1]):
            # A feasible neighbour's plan is the best start that there is.
            solver.solve(starts[j + 1])
            costs[j] = _cost(solver.solve(starts[j], elapsed=0.0))
    return costs


def _cheapest(solver: Solver, start: NDArray[np.float64]) -> float:
    """Cost of the first plan found, nan if there is none.

    Tried are: warm from the neighbour's plan; cold; and cold with the bearing counted the other way
    round, which is another way round the target.
    """
    r, theta, z, chi, v = start
    turned = np.array([r, theta - np.copysign(2.0 * np.pi, theta), z, chi, v])
    for state, elapsed in ((start, 0.0), (start, None), (turned, None)):
        cost = _cost(solver.solve(state, elapsed=elapsed))
        if np.isfinite(cost):
            return cost
    return float("nan")


def _cost(solution: Solution) -> float:
    found = solution.converged and solution.violation <= FEASIBLE_VIOLATION
    return solution.cost if found else float("nan")


def save_maps(maps: list[AttractionMap], file: IO[bytes]) -> None:
    """Write maps as a NumPy archive: map k has ``k_feasible``, ``k_cost`` and its axes.

    Args:
        maps: Any number of them.
        file: Open for writing.
    """
    arrays = {}
    for k, entry in enumerate(maps):
        where = entry.slice
        content = {
            "horizon": entry.horizon,
            "coordinates": [where.first, where.second],
            "first": where.first_values,
            "second": where.second_values,
            "base": where.base,
            "feasible": entry.feasible,
            "cost": entry.cost,
            "marked": entry.marked,
            "marked_feasible": entry.marked_feasible,
        }
        arrays.update({f"{k}_{name}": np.array(value) for name, value in content.items()})
    np.savez_compressed(file, **arrays)  # type: ignore[arg-type]


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
    star = q_star(problem, parts.gain)
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
    pieces = [(problem, level, chunk, steps) for chunk in chunks]
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


def _fly_piece(piece: tuple[StabilityProblem, float, NDArray[np.float64], int]) -> list[_Flight]:
    problem, level, states, step_limit = piece
    weight = problem.ingredients().weight
    lower, upper = problem.deviation_bounds()
    solver = NewtonSolver(tracking_problem(problem, level))
    flights = []
    for start in states:
        steps, height, cost = 0, 0.0, np.inf
        outside = rose = failed = False
        for solution in islice(solutions(solver, start), step_limit):
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
