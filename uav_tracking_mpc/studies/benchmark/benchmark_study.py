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

"""Our solver and others on the paper's problems and on that of a small aircraft, timed.

Our closed loop makes the states of the transient. The solvers then fly through these states in two
ways: each the whole transient, one solver after the other, as in a controller that runs alone; and
in turns at every step, where the others have emptied the processor's caches in between. At the cold
starts they take turns at every state.
"""

from __future__ import annotations

import platform
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from itertools import islice
from typing import Any

import casadi as ca
import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray
from rich.console import Console

from uav_tracking_mpc.mpc.casadi_solver import OPTIONS, CasadiSolver
from uav_tracking_mpc.mpc.newton_solver import NewtonSolver
from uav_tracking_mpc.mpc.solver import Solution, Solver, solutions
from uav_tracking_mpc.report.figure_style import drawing
from uav_tracking_mpc.report.pages import Table
from uav_tracking_mpc.studies.benchmark.acados_peer import acados_peers
from uav_tracking_mpc.studies.benchmark.cases import Case, cases, paper_case
from uav_tracking_mpc.studies.benchmark.optimality import OptimalityMeasure
from uav_tracking_mpc.studies.flight_start import Start
from uav_tracking_mpc.studies.study import Study

OURS = "ours"
TRANSIENT_STEPS = 30  # control steps from the start
LOOP_STEPS = 60  # control steps of the closed loop
COST_MARGIN = 1e-3  # -, relative difference: a cost this close to the best found counts as the best

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


class FatropSolver(CasadiSolver):
    """fatrop on the same program: four times as fast as IPOPT, but not for flight.

    It has been seen never to return where the model has no value (a state outside its domain), and
    knows no time limit.
    """

    name = "fatrop"

    def _build(self, limit: float) -> None:
        structure: dict[str, Any] = {
            "structure_detection": "auto",
            "equality": self._program.equality,
            "fatrop": {"print_level": 0, "tol": self._tolerance, "max_iter": self._iteration_limit},
        }
        program = ca.nlpsol("tracking", "fatrop", self._program.nlp, {**OPTIONS, **structure})
        self._cold = self._warm = program


def all_solvers(case: Case) -> dict[str, Solver]:
    """Our solver and others, with expanded expressions and their structure found.

    Args:
        case: Whose problem they solve.
    """
    peers = [peer(case.problem, iteration_limit=500) for peer in (CasadiSolver, FatropSolver)]
    return {OURS: NewtonSolver(case.problem), **{peer.name: peer for peer in peers}}


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
    begins = []
    for _ in range(1 + count):
        begins.append(time.perf_counter())
        list(islice(solutions(solver, start.state, start.parameters), steps))
    return count / (time.perf_counter() - begins[1])


MISSION_STEPS = 150  # control steps of a mission
HORIZONS = [5, 10, 20, 30, 50, 100]  # stages


def benchmark(
    *,
    cold: int = 2000,
    peers_cold: int = 20,
    seed: int = 0,
    quick: bool = False,
    acados: str | None = None,
) -> dict[str, Any]:
    """Run all cases; what runs is said on stderr.

    Args:
        cold: Random cold starts for ours.
        peers_cold: How many of them the peers solve as well.
        seed: Of the random states.
        acados: Python that has acados_template; None to go without this peer.
        quick: At most 50 cold starts, 5 for the peers, 2 transients, and no sweep of the horizon.

    Returns:
        ``cases.<case>.<solver>`` as
        :func:`summary`, with the ratios of
        the medians to ours (``ratios``: each solver alone; ``ratios_alternating``: in turns at
        every step), missions a second, the sweep of the horizon, and the duration.
    """
    begin = time.perf_counter()
    if quick:
        cold, peers_cold = min(cold, 50), min(peers_cold, 5)
    results: dict[str, Any] = {
        "seed": seed,
        "machine": platform.processor() or platform.machine(),
        "cases": {},
        "ratios": {},
        "ratios_alternating": {},
        "mission_steps": MISSION_STEPS,
    }
    console = Console(stderr=True)
    with console.status("benchmark") as status:
        for case in cases():
            status.update(f"{case.name}: preparing")
            with acados_peers(case.problem, acados, console.print) as peers:
                records = measure(
                    case,
                    {**all_solvers(case), **peers},
                    repetitions=2 if quick else 6,
                    cold=cold,
                    peers_cold=min(cold, peers_cold),
                    seed=seed,
                    progress=status.update,
                )
            for name in [name for name, peer in peers.items() if peer.lost]:
                del records[name]
            figures = summary(records)
            results["cases"][case.name] = figures
            results["ratios"][case.name] = _ratios(figures, "transient_median_us")
            results["ratios_alternating"][case.name] = _ratios(figures, "alternating_median_us")
        status.update("missions")
        results["missions_per_second"] = missions_per_second(paper_case(10), MISSION_STEPS)
        if not quick:
            results["horizons"] = HORIZONS
            results["horizon_median_us"] = horizon_sweep(HORIZONS, paper_case, status.update)
    results["duration_s"] = time.perf_counter() - begin
    return results


def _ratios(figures: dict[str, dict[str, Any]], key: str) -> dict[str, float]:
    """Figure of every other solver over ours."""
    return {name: row[key] / figures[OURS][key] for name, row in figures.items() if name != OURS}


LEAST_CONVERGED = 0.99  # -, share of the cold starts
# Heading, key of the figure, its format, factor.
FIGURES = (
    ("median [us]", "transient_median_us", ".1f", 1.0),
    ("p99 [us]", "p99_us", ".1f", 1.0),
    ("max [us]", "max_us", ".1f", 1.0),
    ("KKT", "kkt_median", ".0e", 1.0),
    ("iter", "iterations_median", ".0f", 1.0),
    ("ratio", "ratio", ".1f", 1.0),
    ("in turns [us]", "alternating_median_us", ".1f", 1.0),
    ("ratio [in turns]", "ratio_alternating", ".1f", 1.0),
    ("loop cost [%]", "loop_cost_share", ".3f", 100.0),
    ("cold [us]", "cold_median_us", ".0f", 1.0),
    ("cold solves", "cold_solves", ".0f", 1.0),
    ("converged [%]", "converged_share", ".1f", 100.0),
    ("best [%]", "best_cost_share", ".1f", 100.0),
)
CAPTION = (
    "median, p99, max: warm, first 30 closed-loop steps, one solver after the other; in turns: "
    "median where the solvers alternate at every step, with cold caches; ratio: their median over "
    "ours; KKT: median residual or violation of the warm plans, by one measure for all; loop cost: "
    "of the first 60 steps, each solver in its own closed loop, over ours; best: cost within 0.1 % "
    "of the best found, over the states that all solved. acados is timed without the Python around "
    "it."
)


def converged(results: dict[str, Any]) -> bool:
    """Whether our solver converged from nearly all cold starts of every case.

    Args:
        results: Of :func:`benchmark`.
    """
    shares = [figures[OURS]["converged_share"] for figures in results["cases"].values()]
    return all(share is None or share >= LEAST_CONVERGED for share in shares)


def benchmark_table(results: dict[str, Any]) -> Table:
    """One row for every solver on every case.

    Args:
        results: Of :func:`benchmark`.
    """
    rows = []
    for case, solvers in results["cases"].items():
        for name, row in solvers.items():
            figures = {
                **row,
                "ratio": results["ratios"][case].get(name),
                "ratio_alternating": results["ratios_alternating"][case].get(name),
                "loop_cost_share": row["closed_loop_cost"] / solvers[OURS]["closed_loop_cost"],
            }
            cells = [
                "" if figures[key] is None else f"{scale * figures[key]:{form}}"
                for _, key, form, scale in FIGURES
            ]
            rows.append([case if name == OURS else "", name, *cells])
    headings = [heading for heading, *_ in FIGURES]
    return Table(("case", "solver", *headings), rows, numeric=headings, caption=CAPTION)


def benchmark_results(results: dict[str, Any]) -> Study:
    """The study: numbers, table and, where the horizon was swept, the figure.

    Args:
        results: Of :func:`benchmark`.
    """
    return Study(
        name="benchmark",
        content=results,
        words=[
            benchmark_table(results),
            f"missions of {results['mission_steps']} steps (paper_n10, ours): "
            f"{results['missions_per_second']:.0f} a second",
            f"{results['duration_s']:.0f} s",
        ],
        written="saved in {}",
        figures={"solve_time": partial(_figure, results)} if "horizons" in results else {},
    )


def _figure(results: dict[str, Any]) -> Figure:
    """Solve time over the horizon."""
    horizons = results["horizons"]
    with drawing(6.4, 4.2) as figure:
        axes = figure.add_subplot()
        for name, medians in results["horizon_median_us"].items():
            axes.loglog(horizons, medians, marker="o", label=name)
        axes.set_xlabel("horizon N")
        axes.set_ylabel("median solve time [us], warm, to convergence")
        axes.set_xticks(horizons, [str(n) for n in horizons])
        axes.minorticks_off()
        axes.legend()
        figure.tight_layout()
    return figure
