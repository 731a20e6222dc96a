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

from dataclasses import replace
from itertools import islice, pairwise
from typing import IO, Any

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

# A slice of the state space: ``coordinates``, keys of COORDINATES, along rows and columns;
# ``first`` and ``second``, their values; ``base``, state (r, theta, z, chi, v) that gives the
# others. A map also has ``horizon``; of each state ``feasible`` and ``cost``, V_N, nan where
# infeasible; the state ``marked`` and ``marked_feasible``.
Map = dict[str, Any]


def default_slices(problem: StabilityProblem, points: int = 25) -> list[Map]:
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
    others = {"bearing": (-np.pi, np.pi), "speed": (0.0, 2.5 * orbit.speed)}
    return [
        {
            "coordinates": ["range", name],
            "first": ranges,
            "second": np.linspace(*ends, points),
            "base": base,
        }
        for name, ends in others.items()
    ]


def marked_state(problem: StabilityProblem) -> NDArray[np.float64]:
    """x_o of the paper, scaled to the orbit where that is not the paper's, shape (5,)."""
    r, theta, z, chi, v = PAPER_INITIAL_STATE
    orbit, paper = problem.orbit, paper_numbers.ORBIT
    wider, higher = orbit.range / paper.range, orbit.altitude / paper.altitude
    return np.array([r * wider, theta, z * higher, chi, v])


def attraction_map(
    problem: StabilityProblem,
    level: float | None,
    where: Map,
    horizon: int,
    workers: int | None = None,
) -> Map:
    """Map X_N over a slice.

    Args:
        problem: The configuration.
        level: varrho [-] of the hard terminal set; None leaves the set away.
        where: The slice.
        horizon: N [-].
        workers: Processes, all cores by default.
    """
    changed, marked = replace(problem, horizon=horizon), marked_state(problem)
    first, second = where["coordinates"]
    states = np.tile(where["base"], (len(where["first"]), len(where["second"]), 1))
    states[:, :, COORDINATES[first]] = where["first"][:, None]
    states[:, :, COORDINATES[second]] = where["second"]
    pieces = [(changed, level, row) for row in (*states, marked[None])]
    label = f"X_{horizon} over {first}, {second}"
    *rows, (marked_cost,) = parallel_map(_solve_row, pieces, workers, label)
    costs = np.array(rows)
    return {
        "horizon": horizon,
        **where,
        "feasible": np.isfinite(costs),
        "cost": costs,
        "marked": marked,
        "marked_feasible": bool(np.isfinite(marked_cost)),
    }


def _solve_row(
    problem: StabilityProblem, level: float | None, states: NDArray[np.float64]
) -> list[float]:
    """Costs along a row, nan where no plan was found: forwards, then backwards over the gaps."""
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


def save_maps(maps: list[Map], file: IO[bytes]) -> None:
    """Write maps as a NumPy archive: map k has ``k_feasible``, ``k_cost`` and its axes."""
    arrays = {
        f"{k}_{name}": np.array(value)
        for k, found in enumerate(maps)
        for name, value in found.items()
    }
    np.savez_compressed(file, **arrays)  # type: ignore[arg-type]


def random_states(
    problem: StabilityProblem, level: float, count: int, seed: int = 0
) -> NDArray[np.float64]:
    """States uniform in the volume of X_f with varrho [-], shape (count, 5), error coordinates."""
    generator = np.random.default_rng(seed)
    radius = np.sqrt(level) * generator.uniform(0.0, 1.0, (count, 1)) ** 0.2
    return radius * directions(problem.ingredients().weight, count, generator)


# In how many flights it happened: the state left X_f, an input left U, the cost did not fall at a
# step, a solve failed. All are excluded by a proof, but that the NMPC leaves X_f on its way.
EXCLUDED = ("left", "outside_inputs", "cost_rose", "failures")
OBSERVED = ("nmpc", "left")


def _result(law: str, flights: int, steps: int, largest: float, **counts: int) -> dict[str, Any]:
    """Counts over all flights; ``largest_height`` is the largest V_f seen over varrho [-]."""
    return {
        "law": law,
        "flights": flights,
        "steps": steps,
        **counts,
        "largest_height": largest,
        "clean": not any(count for name, count in counts.items() if (law, name) != OBSERVED),
    }


def local_flights(
    problem: StabilityProblem, gain: NDArray[np.float64], states: NDArray[np.float64], steps: int
) -> NDArray[np.float64]:
    """States under kappa_l: those of shape (count, 5), then those after each step.

    Args:
        problem: The configuration.
        gain: K, shape (3, 5).
        states: Where the flights begin.
        steps: Of every flight.
    """
    dynamics, path = problem.dynamics(), [np.asarray(states, dtype=float)]
    for _ in range(steps):
        path.append(np.array(dynamics(path[-1].T, (path[-1] @ gain.T).T)).T)
    return np.array(path)


def fly_local(
    problem: StabilityProblem, level: float, states: NDArray[np.float64], steps: int = 60
) -> dict[str, Any]:
    """Fly kappa_l from every state of shape (count, 5) for some steps, with varrho [-]."""
    parts, (lower, upper) = problem.ingredients(), problem.deviation_bounds()
    path = local_flights(problem, parts.gain, states, steps)
    inputs = path[:-1] @ parts.gain.T
    squares = "tki,ij,tkj->tk"
    stages = np.einsum(squares, path[:-1], q_star(problem, parts.gain), path[:-1])
    heights = np.einsum(squares, path, parts.weight, path)
    happened = (
        ~(heights[1:] <= level * (1.0 + 1e-12)),  # also where they are no numbers
        np.any((inputs < lower - 1e-12) | (inputs > upper + 1e-12), axis=2),
        # Below a rounding floor there is no decrease left to see.
        ~(heights[1:] <= heights[:-1] - stages + 1e-12 * level),
    )
    counts = {n: int(each.any(axis=0).sum()) for n, each in zip(EXCLUDED, happened, strict=False)}
    count, largest = len(states), float(heights.max()) / level
    return _result("kappa_l", count, count * steps, largest, **counts, failures=0)


def fly_nmpc(
    problem: StabilityProblem,
    level: float,
    states: NDArray[np.float64],
    steps: int = 20,
    workers: int | None = None,
) -> dict[str, Any]:
    """Fly the NMPC with the hard terminal set from every state.

    Args:
        problem: The configuration; its N counts.
        level: varrho [-].
        states: Shape (count, 5).
        steps: Of every flight; it ends sooner once the cost is below a millionth of varrho.
        workers: Processes.
    """
    chunks = np.array_split(np.asarray(states, dtype=float), max(1, len(states) // 50))
    pieces = [(problem, level, chunk, steps) for chunk in chunks]
    parts = parallel_map(_fly_piece, pieces, workers, "NMPC flights")
    flights = [flight for part in parts for flight in part]
    counts = {name: sum(flight[name] for flight in flights) for name in ("steps", *EXCLUDED)}
    largest = max((flight["height"] for flight in flights), default=0.0) / level
    return _result("nmpc", len(flights), largest=largest, **counts)


def _fly_piece(
    problem: StabilityProblem, level: float, states: NDArray[np.float64], step_limit: int
) -> list[dict[str, Any]]:
    """Of each flight its solves, whether what is excluded happened, and the largest V_f."""
    weight = problem.ingredients().weight
    lower, upper = problem.deviation_bounds()
    solver = NewtonSolver(tracking_problem(problem, level))
    flights = []
    for start in states:
        flown: list[Solution] = []
        for solution in islice(solutions(solver, start), step_limit):
            flown.append(solution)
            if not solution.converged or solution.cost < 1e-6 * level:
                break
        good = [solution for solution in flown if solution.converged]
        inputs = np.array([each.inputs[0] for each in good]).reshape(-1, len(lower))
        following = [each.states[1] for each in good]
        height = max((float(x @ weight @ x) for x in following), default=0.0)
        happened = (
            height > level * (1.0 + 1e-9),
            bool(np.any((inputs < lower - 1e-9) | (inputs > upper + 1e-9))),
            # Solvers stop at a tolerance: allow it, not more.
            any(after.cost > before.cost + 1e-7 * level for before, after in pairwise(good)),
            len(good) < len(flown),
        )
        flights.append(
            {"steps": len(flown), "height": height, **dict(zip(EXCLUDED, happened, strict=True))}
        )
    return flights
