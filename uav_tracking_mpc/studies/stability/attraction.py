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

"""Domain of attraction X_N (20), mapped: from which states is P_N feasible?

X_N is five-dimensional; a map is a slice through it, two coordinates varied, the others held. At
each state P_N is solved with the terminal set hard, from several starts. "Feasible" is a fact: a
plan was found. "Infeasible" is what a local solver says after all its starts, which is no proof;
where a bound on what can be flown at all excludes the state (see
``distance_budget``) it is one.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import IO

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics import paper_numbers
from uav_tracking_mpc.dynamics.relative import tracking_error
from uav_tracking_mpc.formulation.paper_problem import tracking_problem
from uav_tracking_mpc.mpc.newton_solver import NewtonSolver
from uav_tracking_mpc.mpc.solution import Solution
from uav_tracking_mpc.mpc.solver import Solver
from uav_tracking_mpc.studies.parallel import parallel_map
from uav_tracking_mpc.terminal.stability_problem import PAPER_INITIAL_STATE, StabilityProblem

COORDINATES = {"range": 0, "bearing": 1, "altitude": 2, "path_angle": 3, "speed": 4}
UNITS = {"range": "m", "bearing": "rad", "altitude": "m", "path_angle": "rad", "speed": "m/s"}
FEASIBLE_VIOLATION = 1e-5


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


@dataclass(frozen=True)
class _Row:
    problem: StabilityProblem
    level: float | None
    states: NDArray[np.float64]


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
        _Row(changed, level, np.array([where.state(i, j) for j in range(len(where.second_values))]))
        for i in range(len(where.first_values))
    ]
    pieces.append(_Row(changed, level, marked[None]))
    label = f"X_{horizon} over {where.first}, {where.second}"
    *rows, (marked_cost,) = parallel_map(_solve_row, pieces, workers, label, show)
    costs = np.array(rows)
    found = bool(np.isfinite(marked_cost))
    return AttractionMap(where, horizon, np.isfinite(costs), costs, marked, found)


def _solve_row(row: _Row) -> list[float]:
    """Costs along a row, nan where no plan was found: forwards, then backwards over the gaps."""
    solver = NewtonSolver(tracking_problem(row.problem, row.level))
    starts = [tracking_error(state, row.problem.orbit) for state in row.states]
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
