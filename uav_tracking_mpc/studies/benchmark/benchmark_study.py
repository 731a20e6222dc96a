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

import dataclasses
import math
import platform
import time
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field
from functools import partial
from itertools import islice
from typing import Any

import casadi as ca
import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray
from rich.console import Console

from uav_tracking_mpc.dynamics.relative import tracking_error
from uav_tracking_mpc.estimation.situation import Situation
from uav_tracking_mpc.formulation.flight_formulation import FlightFormulation
from uav_tracking_mpc.formulation.paper_formulation import problem_of
from uav_tracking_mpc.mpc.casadi_solver import OPTIONS, CasadiSolver
from uav_tracking_mpc.mpc.newton_solver import NewtonSolver
from uav_tracking_mpc.mpc.problem import OptimalControlProblem
from uav_tracking_mpc.mpc.solver import Solution, Solver, solutions, solve_data
from uav_tracking_mpc.report.figure_style import drawing
from uav_tracking_mpc.report.metrics import microseconds
from uav_tracking_mpc.report.pages import Table
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.studies.benchmark.optimality import OptimalityMeasure
from uav_tracking_mpc.studies.feasibility_study import Start, flight_start, random_situations
from uav_tracking_mpc.studies.study import Say, Study
from uav_tracking_mpc.terminal.ingredients import PAPER_INITIAL_STATE

OURS = "ours"
TRANSIENT_STEPS = 30  # control steps from the start
LOOP_STEPS = 60  # control steps of the closed loop
COST_MARGIN = 1e-3  # -, relative difference: a cost this close to the best found counts as the best

# More solvers of a problem by name, and who is told of those that cannot be had: what was lost on
# the way is no longer among them at the end.
Peers = Callable[[OptimalControlProblem, Say], AbstractContextManager[Mapping[str, Solver]]]


@dataclass(frozen=True)
class Case:
    """A problem and where it is solved.

    Attributes:
        name: Key in the JSON.
        problem: What is solved.
        start: Where the transient begins.
        cold_starts: Random starts, from their number and a seed.
    """

    name: str
    problem: OptimalControlProblem
    start: Start
    cold_starts: Callable[[int, int], list[Start]]


def paper_case(horizon: int, ellipsoid: bool = False) -> Case:
    """(16) with the parameters of ``config/paper.yaml``, from the paper's start.

    Args:
        horizon: N [-].
        ellipsoid: With X_f as a soft constraint; else without.
    """
    parameters = dataclasses.replace(
        load_configuration("paper").controller,
        horizon=horizon,
        terminal_constraint="soft" if ellipsoid else "none",
    )

    def cold_starts(count: int, seed: int) -> list[Start]:
        """From near to far and in every direction."""
        random = np.random.default_rng(seed)
        states = [_random_relative_state(random) for _ in range(count)]
        return [Start(tracking_error(state, parameters.orbit)) for state in states]

    return Case(
        name=f"paper_n{horizon}{'_ellipsoid' if ellipsoid else ''}",
        problem=problem_of(parameters),
        start=Start(tracking_error(PAPER_INITIAL_STATE, parameters.orbit)),
        cold_starts=cold_starts,
    )


def _random_relative_state(random: np.random.Generator) -> NDArray[np.float64]:
    r = random.uniform(80.0, 400.0)
    theta = random.uniform(-math.pi, math.pi)
    z = min(random.uniform(10.0, 120.0), 0.8 * r)
    return np.array([r, theta, z, random.uniform(-0.4, 0.4), random.uniform(1.0, 8.0)])


def flight_case(horizon: int = 20) -> Case:
    """The flight problem of ``config/small_uav.yaml``, in the formulation that flies.

    The transient begins where the configuration's simulator does, in still air; the cold starts are
    :func:`~uav_tracking_mpc.studies.feasibility_study.random_situations`, most of them in
    a drift.

    Args:
        horizon: N [-].
    """
    configuration = load_configuration("small_uav")
    parameters = dataclasses.replace(configuration.controller, horizon=horizon)
    formulation = FlightFormulation(parameters)
    begin = Situation(configuration.simulator.initial_state, *np.zeros((4, 3)))

    def cold_starts(count: int, seed: int) -> list[Start]:
        situations = random_situations(parameters, count, seed)
        return [flight_start(formulation, situation) for situation in situations]

    return Case(
        name=f"flight_n{horizon}",
        problem=formulation.solver.problem,
        start=flight_start(formulation, begin),
        cold_starts=cold_starts,
    )


def cases() -> list[Case]:
    """All cases, in the order in which they are reported."""
    paper = [paper_case(horizon, soft) for horizon in (10, 30) for soft in (False, True)]
    return [*paper, flight_case()]


Solve = tuple[Solution, float]  # a solve and its time in [s], of the solver alone


@dataclass
class Record:
    """What one solver did on one case.

    Attributes:
        warm: Warm solves.
        alternating: Times of warm solves in [s], in turns with the others at every step.
        residuals: KKT residual or violation of warm plans, whichever is greater [-].
        loop_cost: Of the solver's own closed loop [-].
        cold: Cold solves.
    """

    warm: list[Solve] = field(default_factory=list)
    alternating: list[float] = field(default_factory=list)
    residuals: list[float] = field(default_factory=list)
    loop_cost: float = np.nan
    cold: list[Solve] = field(default_factory=list)


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
    """Our solver and others, with expanded expressions and their structure found."""
    peers = [peer(case.problem, iteration_limit=500) for peer in (CasadiSolver, FatropSolver)]
    return {OURS: NewtonSolver(case.problem), **{peer.name: peer for peer in peers}}


def measure(
    case: Case,
    solvers: Mapping[str, Solver],
    *,
    repetitions: int,
    cold: int,
    peers_cold: int,
    seed: int,
    progress: Say = lambda _: None,
) -> dict[str, Record]:
    """Run a case with solvers, :data:`OURS` among them.

    Args:
        repetitions: Transients of each kind.
        cold: Random states for ours.
        peers_cold: How many of them the peers solve as well.
    """
    records = {name: Record() for name in solvers}
    optimality, start = OptimalityMeasure(case.problem), case.start
    loop = solutions(solvers[OURS], start.state, start.parameters, start.guess)
    states = [solution.states[0] for solution in islice(loop, TRANSIENT_STEPS)]
    for repetition in range(repetitions):
        progress(f"{case.name}: transient {repetition + 1} of {repetitions}")
        for name, solver in solvers.items():
            _, *warm = _solves(case, solver, states)
            records[name].warm += warm
        _, *turns = zip(*(_solves(case, each, states) for each in solvers.values()), strict=True)
        for record, solves in zip(records.values(), zip(*turns, strict=True), strict=True):
            record.alternating += [duration for _, duration in solves]
    for name, solver in solvers.items():
        progress(f"{case.name}: closed loop of {name}")
        records[name].residuals = [
            max(optimality(plan.states[0], plan.inputs, plan.decision, start.parameters)[1:])
            for plan, _ in records[name].warm[: TRANSIENT_STEPS - 1]
        ]
        records[name].loop_cost = _loop_cost(case, solver, optimality)
    for index, begin in enumerate(case.cold_starts(cold, seed)):
        if index % 50 == 0:
            progress(f"{case.name}: cold start {index} of {cold}")
        for name in solvers if index < peers_cold else (OURS,):
            records[name].cold.append(_timed(solvers[name], begin, begin.state, None))
    return records


def _solves(case: Case, solver: Solver, states: list[NDArray[np.float64]]) -> Iterator[Solve]:
    """Solves from one state after the other, the first of them cold."""
    solver.reset()
    for step, state in enumerate(states):
        yield _timed(solver, case.start, state, case.problem.step if step else None)


def _loop_cost(case: Case, solver: Solver, optimality: OptimalityMeasure) -> float:
    """What the first steps of a solver's own closed loop cost, on the model of the problem."""
    _, p = solve_data(case.problem, case.start.state, case.start.parameters)
    states, total = [case.start.state], 0.0  # a solve at the last state appends the next one
    for plan, _ in islice(_solves(case, solver, states), LOOP_STEPS):
        cost, following = optimality.stage_cost(states[-1], plan.inputs[0], plan.decision, p[0])
        states.append(following)
        total += cost
    return total


def _timed(
    solver: Solver, start: Start, state: NDArray[np.float64], elapsed: float | None
) -> Solve:
    guess = None if start.guess is None else partial(start.guess, state)
    begin = time.perf_counter()
    solution = solver.solve(state, start.parameters, elapsed, guess)
    duration = time.perf_counter() - begin
    inside = getattr(solver, "timed_inside", False)  # in another process
    return solution, solution.solve_time if inside else duration


def summary(records: Mapping[str, Record]) -> dict[str, dict[str, Any]]:
    """Figures of every solver on a case; times in microseconds.

    The best cost of a state is the lowest that any solver found; only states that all solvers
    tried count for ``best_cost_share`` (all states if there is one solver).
    """
    common = min(len(record.cold) for record in records.values())
    costs = np.array(
        [
            [plan.cost if plan.converged else np.inf for plan, _ in record.cold[:common]]
            for record in records.values()
        ]
    )
    best = costs <= np.min(costs, axis=0, initial=np.inf) * (1.0 + COST_MARGIN)
    best &= np.isfinite(costs)
    return {
        name: {**_figures(record), "best_cost_share": _share(shares), "best_cost_states": common}
        for (name, record), shares in zip(records.items(), best, strict=True)
    }


def _figures(record: Record) -> dict[str, Any]:
    warm, warm_times = zip(*record.warm, strict=True)
    transient, turns, cold = (
        microseconds(np.array(times))
        for times in (warm_times, record.alternating, [duration for _, duration in record.cold])
    )
    return {
        "transient_median_us": transient["median_us"],
        "p99_us": transient["p99_us"],
        "max_us": transient["max_us"],
        "alternating_median_us": turns["median_us"],
        "alternating_p99_us": turns["p99_us"],
        "iterations_median": float(np.median([plan.iterations for plan in warm])),
        "warm_converged_share": _share([plan.converged for plan in warm]),
        "kkt_median": float(np.median(record.residuals)),
        "kkt_p99": float(np.percentile(record.residuals, 99.0)),
        "closed_loop_cost": record.loop_cost,
        "cold_median_us": cold["median_us"],
        "cold_solves": len(record.cold),
        "converged_share": _share([plan.converged for plan, _ in record.cold]),
    }


def _share(hits: Any) -> float | None:
    return float(np.mean(hits)) if len(hits) else None


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
    peers: Peers | None = None,
) -> dict[str, Any]:
    """Run all cases; what runs is said on stderr.

    Args:
        cold: Random cold starts for ours.
        peers_cold: How many of them the peers solve as well.
        seed: Of the random states.
        quick: At most 50 cold starts, 5 for the peers, 2 transients, and no sweep of the horizon.
        peers: Further solvers; none by default.

    Returns:
        ``cases.<case>.<solver>`` as :func:`summary`, with the ratios of the medians to ours
        (``ratios``: each solver alone; ``ratios_alternating``: in turns at every step), missions a
        second, the sweep of the horizon, and the duration.
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
            own = all_solvers(case)
            with peers(case.problem, console.print) if peers else nullcontext({}) as more:
                records = measure(
                    case,
                    {**own, **more},
                    repetitions=2 if quick else 6,
                    cold=cold,
                    peers_cold=min(cold, peers_cold),
                    seed=seed,
                    progress=status.update,
                )
            figures = summary({name: records[name] for name in (*own, *more)})
            results["cases"][case.name] = figures
            for ratios, key in (("ratios", "transient"), ("ratios_alternating", "alternating")):
                medians = {name: row[f"{key}_median_us"] for name, row in figures.items()}
                ours = medians.pop(OURS)
                results[ratios][case.name] = {name: time / ours for name, time in medians.items()}
        status.update("missions")
        results["missions_per_second"] = missions_per_second(paper_case(10), MISSION_STEPS)
        if not quick:
            results["horizons"] = HORIZONS
            found = results["horizon_median_us"] = defaultdict(list)
            for horizon in HORIZONS:
                status.update(f"horizon {horizon}")
                case = paper_case(horizon)
                swept = measure(
                    case, all_solvers(case), repetitions=1, cold=0, peers_cold=0, seed=seed
                )
                for name, row in summary(swept).items():
                    found[name].append(row["transient_median_us"])
    results["duration_s"] = time.perf_counter() - begin
    return results


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


def benchmark_table(results: dict[str, Any]) -> Table:
    """One row for every solver on every case."""
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


def benchmark_study(results: dict[str, Any]) -> Study:
    """The study: numbers, table and, where the horizon was swept, the figure.

    It is good if our solver converged from nearly all cold starts of every case.
    """
    shares = [figures[OURS]["converged_share"] for figures in results["cases"].values()]
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
        good=all(share is None or share >= LEAST_CONVERGED for share in shares),
    )


def _figure(results: dict[str, Any]) -> Figure:
    """Solve time over the horizon."""
    horizons = results["horizons"]
    with drawing(6.4, 4.2) as figure:
        axes = figure.add_subplot()
        for name, medians in results["horizon_median_us"].items():
            axes.loglog(horizons, medians, marker="o", label=name)
        axes.set(xlabel="horizon N", ylabel="median solve time [us], warm, to convergence")
        axes.set_xticks(horizons, [str(n) for n in horizons])
        axes.minorticks_off()
        axes.legend()
        figure.tight_layout()
    return figure
