"""Every solver on one case: a closed-loop transient, warm, and random states, cold.

Our closed loop makes the states of the transient; then the solvers take turns at flying it, so that
whatever else the machine does falls on all of them. At the cold starts they take turns at every
state.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.mpc.casadi_solver import PLUGINS, CasadiSolver
from uav_tracking_mpc.mpc.newton_solver import NewtonSolver
from uav_tracking_mpc.mpc.prediction_loop import closed_loop
from uav_tracking_mpc.mpc.solution import Solution
from uav_tracking_mpc.mpc.solver import Solver
from uav_tracking_mpc.studies.benchmark.cases import Case

OURS = "ours"
TRANSIENT_STEPS = 30
COST_MARGIN = 1e-3  # a cost this close to the best found counts as the best

Progress = Callable[[str], None]


@dataclass
class Record:
    """What one solver did on one case: times in [s], warm and cold; costs of cold solves."""

    warm: list[float] = field(default_factory=list)
    warm_iterations: list[int] = field(default_factory=list)
    warm_converged: list[bool] = field(default_factory=list)
    cold: list[float] = field(default_factory=list)
    cold_converged: list[bool] = field(default_factory=list)
    cold_cost: list[float] = field(default_factory=list)  # inf where not converged


def peers(case: Case, names: tuple[str, ...] = PLUGINS) -> dict[str, Solver]:
    """The other solvers, with expanded expressions and their structure given."""
    return {name: CasadiSolver(case.problem, name, iteration_limit=500) for name in names}


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
        repetitions: Transients, flown by all solvers in turn.
        cold: Random states for ours.
        peers_cold: How many of them the peers solve as well.
        seed: Of the random states.
        progress: Called with a word about what begins.
    """
    records = {name: Record() for name in solvers}
    states = _transient_states(case, solvers[OURS])
    for repetition in range(repetitions):
        progress(f"{case.name}: transient {repetition + 1} of {repetitions}")
        for name, solver in solvers.items():
            _transient(case, solver, records[name], states)
    for index, state in enumerate(case.cold_states(cold, seed)):
        if index % 50 == 0:
            progress(f"{case.name}: cold start {index} of {cold}")
        for name in solvers if index < peers_cold else (OURS,):
            solution, duration = _timed(solvers[name], state, case, None)
            record = records[name]
            record.cold.append(duration)
            record.cold_converged.append(solution.converged)
            record.cold_cost.append(solution.cost if solution.converged else np.inf)
    return records


def _transient_states(case: Case, solver: Solver) -> list[NDArray[np.float64]]:
    """States of the first closed-loop steps, flown by one solver."""
    plant, states = case.plant(), [case.start]
    solver.reset()
    for step in range(TRANSIENT_STEPS - 1):
        solution = solver.solve(states[-1], case.parameters, case.problem.step if step else None)
        states.append(plant(states[-1], solution.inputs[0]))
    return states


def _transient(
    case: Case, solver: Solver, record: Record, states: list[NDArray[np.float64]]
) -> None:
    solver.reset()
    for step, state in enumerate(states):
        solution, duration = _timed(solver, state, case, case.problem.step if step else None)
        if step:  # the first is a cold start
            record.warm.append(duration)
            record.warm_iterations.append(solution.iterations)
            record.warm_converged.append(solution.converged)


def _timed(
    solver: Solver, state: NDArray[np.float64], case: Case, elapsed: float | None
) -> tuple[Solution, float]:
    begin = time.perf_counter()
    solution = solver.solve(state, case.parameters, elapsed)
    return solution, time.perf_counter() - begin


def summary(records: dict[str, Record]) -> dict[str, dict[str, float | int | None]]:
    """Figures of every solver on a case; times in microseconds.

    The best cost of a state is the lowest that any solver found; only states that all solvers
    tried count for ``best_cost_share`` (all states if there is one solver).
    """
    common = min(len(record.cold_cost) for record in records.values())
    costs = np.array([record.cold_cost[:common] for record in records.values()])
    best = np.min(costs, axis=0) if common else np.zeros(0)
    return {
        name: {
            "transient_median_us": _microseconds(record.warm, 50.0),
            "p99_us": _microseconds(record.warm, 99.0),
            "max_us": _microseconds(record.warm, 100.0),
            "iterations_median": float(np.median(record.warm_iterations)),
            "warm_converged_share": float(np.mean(record.warm_converged)),
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
    horizons: list[int],
    make_case: Callable[[int], Case],
    progress: Progress = lambda _: None,
) -> dict[str, list[float]]:
    """Median transient time in [us] of every solver at every horizon."""
    medians: dict[str, list[float]] = {}
    for horizon in horizons:
        case = make_case(horizon)
        progress(f"horizon {horizon}")
        solvers: dict[str, Solver] = {OURS: NewtonSolver(case.problem), **peers(case)}
        records = {name: Record() for name in solvers}
        states = _transient_states(case, solvers[OURS])
        for name, solver in solvers.items():
            _transient(case, solver, records[name], states)
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
    solver = NewtonSolver(case.problem)
    closed_loop(solver, case.start, steps, case.parameters)
    begin = time.perf_counter()
    for _ in range(count):
        closed_loop(solver, case.start, steps, case.parameters)
    return count / (time.perf_counter() - begin)
