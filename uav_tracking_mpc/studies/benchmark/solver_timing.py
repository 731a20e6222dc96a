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

"""Every solver on one case: a closed-loop transient, warm, and random states, cold.

Our closed loop makes the states of the transient. The solvers then fly through these states in two
ways: each the whole transient, one solver after the other, as in a controller that runs alone; and
in turns at every step, where the others have emptied the processor's caches in between. At the cold
starts they take turns at every state.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.mpc.casadi_solver import PLUGINS, CasadiSolver
from uav_tracking_mpc.mpc.newton_solver import NewtonSolver
from uav_tracking_mpc.mpc.optimality import OptimalityMeasure
from uav_tracking_mpc.mpc.prediction_loop import closed_loop, solutions
from uav_tracking_mpc.mpc.solution import Solution
from uav_tracking_mpc.mpc.solver import Solver
from uav_tracking_mpc.studies.benchmark.cases import Case
from uav_tracking_mpc.studies.flight_start import Start

OURS = "ours"
TRANSIENT_STEPS = 30
LOOP_STEPS = 60
COST_MARGIN = 1e-3  # a cost this close to the best found counts as the best

Progress = Callable[[str], None]


@dataclass
class Record:
    """What one solver did on one case.

    Attributes:
        warm: Times of warm solves in [s], the solver alone.
        warm_iterations: Of these solves.
        warm_converged: Whether they converged.
        alternating: Times of warm solves in [s], in turns with the others at every step.
        residuals: KKT residual or violation of warm plans, whichever is greater [-].
        loop_cost: Of the solver's own closed loop [-].
        cold: Times of cold solves in [s].
        cold_converged: Whether they converged.
        cold_cost: Their costs [-], infinite where not converged.
    """

    warm: list[float] = field(default_factory=list)
    warm_iterations: list[int] = field(default_factory=list)
    warm_converged: list[bool] = field(default_factory=list)
    alternating: list[float] = field(default_factory=list)
    residuals: list[float] = field(default_factory=list)
    loop_cost: float = np.nan
    cold: list[float] = field(default_factory=list)
    cold_converged: list[bool] = field(default_factory=list)
    cold_cost: list[float] = field(default_factory=list)


def all_solvers(case: Case, others: tuple[str, ...] = PLUGINS) -> dict[str, Solver]:
    """Our solver and others, with expanded expressions and their structure given.

    Args:
        case: Whose problem they solve.
        others: Names of plugins of CasADi.
    """
    solvers: dict[str, Solver] = {OURS: NewtonSolver(case.problem)}
    for name in others:
        solvers[name] = CasadiSolver(case.problem, name, iteration_limit=500)
    return solvers


def measure(
    case: Case,
    solvers: dict[str, Solver],
    *,
    repetitions: int,
    cold: int,
    peers_cold: int,
    seed: int,
    progress: Progress = lambda _: None,
) -> dict[str, Record]:
    """Run a case.

    Args:
        case: Problem and starts.
        solvers: By name, :data:`OURS` among them.
        repetitions: Transients of each kind.
        cold: Random states for ours.
        peers_cold: How many of them the peers solve as well.
        seed: Of the random states.
        progress: Called with a word about what begins.
    """
    records = {name: Record() for name in solvers}
    optimality = OptimalityMeasure(case.problem)
    states = _transient_states(case, solvers[OURS])
    for repetition in range(repetitions):
        progress(f"{case.name}: transient {repetition + 1} of {repetitions}")
        for name, solver in solvers.items():
            plans = _transient(case, solver, records[name], states)
            if not repetition:
                records[name].residuals = _residuals(case, optimality, plans)
        _alternating(case, solvers, records, states)
    for name, solver in solvers.items():
        progress(f"{case.name}: closed loop of {name}")
        records[name].loop_cost = _loop_cost(case, solver, optimality)
    for index, start in enumerate(case.cold_starts(cold, seed)):
        if index % 50 == 0:
            progress(f"{case.name}: cold start {index} of {cold}")
        for name in solvers if index < peers_cold else (OURS,):
            solution, duration = _timed(solvers[name], start, start.state, None)
            record = records[name]
            record.cold.append(duration)
            record.cold_converged.append(solution.converged)
            record.cold_cost.append(solution.cost if solution.converged else np.inf)
    return records


def _transient_states(case: Case, solver: Solver) -> list[NDArray[np.float64]]:
    """States of the first closed-loop steps, flown by one solver."""
    start = case.start
    loop = solutions(solver, start.state, start.parameters, start.guess)
    return [solution.states[0] for solution in islice(loop, TRANSIENT_STEPS)]


def _transient(
    case: Case, solver: Solver, record: Record, states: list[NDArray[np.float64]]
) -> list[Solution]:
    """Times into the record; returns the warm plans."""
    solver.reset()
    plans = []
    for step, state in enumerate(states):
        solution, duration = _timed(solver, case.start, state, case.problem.step if step else None)
        if step:  # the first is a cold start
            record.warm.append(duration)
            record.warm_iterations.append(solution.iterations)
            record.warm_converged.append(solution.converged)
            plans.append(solution)
    return plans


def _residuals(case: Case, optimality: OptimalityMeasure, plans: list[Solution]) -> list[float]:
    """How far plans are from optimal and feasible; by one measure for all solvers."""
    found = (
        optimality(plan.states[0], plan.inputs, plan.decision, case.start.parameters)
        for plan in plans
    )
    return [max(stationarity, violation) for _, stationarity, violation in found]


def _loop_cost(case: Case, solver: Solver, optimality: OptimalityMeasure) -> float:
    """What the first steps of a solver's own closed loop cost, on the model of the problem."""
    solver.reset()
    state, total, problem = case.start.state, 0.0, case.problem
    p = np.zeros((problem.horizon + 1, problem.np))
    told = case.start.parameters
    p[:] = problem.usual_parameter if told is None else told
    for step in range(LOOP_STEPS):
        plan, _ = _timed(solver, case.start, state, problem.step if step else None)
        cost, state = optimality.stage_cost(state, plan.inputs[0], plan.decision, p[0])
        total += cost
    return total


def _alternating(
    case: Case,
    solvers: dict[str, Solver],
    records: dict[str, Record],
    states: list[NDArray[np.float64]],
) -> None:
    for solver in solvers.values():
        solver.reset()
    for step, state in enumerate(states):
        elapsed = case.problem.step if step else None
        for name, solver in solvers.items():
            _, duration = _timed(solver, case.start, state, elapsed)
            if step:
                records[name].alternating.append(duration)


def _timed(
    solver: Solver, start: Start, state: NDArray[np.float64], elapsed: float | None
) -> tuple[Solution, float]:
    guess = None if start.guess is None else partial(start.guess, state)
    begin = time.perf_counter()
    solution = solver.solve(state, start.parameters, elapsed, guess)
    duration = time.perf_counter() - begin
    return solution, solution.solve_time if getattr(solver, "timed_inside", False) else duration


def summary(records: dict[str, Record]) -> dict[str, dict[str, float | int | None]]:
    """Figures of every solver on a case; times in microseconds.

    The best cost of a state is the lowest that any solver found; only states that all solvers
    tried count for ``best_cost_share`` (all states if there is one solver).

    Args:
        records: By solver.
    """
    common = min(len(record.cold_cost) for record in records.values())
    costs = np.array([record.cold_cost[:common] for record in records.values()])
    best = np.min(costs, axis=0) if common else np.zeros(0)
    return {
        name: {
            "transient_median_us": _microseconds(record.warm, 50.0),
            "p99_us": _microseconds(record.warm, 99.0),
            "max_us": _microseconds(record.warm, 100.0),
            "alternating_median_us": _microseconds(record.alternating, 50.0),
            "alternating_p99_us": _microseconds(record.alternating, 99.0),
            "iterations_median": float(np.median(record.warm_iterations)),
            "warm_converged_share": float(np.mean(record.warm_converged)),
            "kkt_median": float(np.median(record.residuals)),
            "kkt_p99": float(np.percentile(record.residuals, 99.0)),
            "closed_loop_cost": record.loop_cost,
            "cold_median_us": _microseconds(record.cold, 50.0),
            "cold_solves": len(record.cold),
            "converged_share": float(np.mean(record.cold_converged)) if record.cold else None,
            "best_cost_share": float(np.mean(costs[row] <= best * (1.0 + COST_MARGIN)))
            if common
            else None,
            "best_cost_states": common,
        }
        for row, (name, record) in enumerate(records.items())
    }


def _microseconds(times: list[float], percentile: float) -> float | None:
    return float(np.percentile(times, percentile) * 1e6) if times else None


def horizon_sweep(
    horizons: list[int], make_case: Callable[[int], Case], progress: Progress = lambda _: None
) -> dict[str, list[float]]:
    """Median transient time in [us] of every solver at every horizon.

    Args:
        horizons: Values of N [-].
        make_case: Makes the case of a horizon.
        progress: Called with a word about what begins.
    """
    medians: dict[str, list[float]] = {}
    for horizon in horizons:
        progress(f"horizon {horizon}")
        case = make_case(horizon)
        records = measure(case, all_solvers(case), repetitions=1, cold=0, peers_cold=0, seed=0)
        for name, record in records.items():
            medians.setdefault(name, []).append(float(np.median(record.warm) * 1e6))
    return medians


def missions_per_second(case: Case, steps: int, count: int = 200) -> float:
    """Complete closed-loop missions that one core flies in a second, cold start included.

    Args:
        case: What is flown, from its start.
        steps: Length of a mission.
        count: Missions that are timed, after one that is not.
    """
    solver, start = NewtonSolver(case.problem), case.start
    closed_loop(solver, start.state, steps, start.parameters)
    begin = time.perf_counter()
    for _ in range(count):
        closed_loop(solver, start.state, steps, start.parameters)
    return count / (time.perf_counter() - begin)
