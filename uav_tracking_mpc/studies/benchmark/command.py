"""``uav_tracking benchmark``: run the cases, print the table, save JSON and figure."""

from __future__ import annotations

import argparse
import json
import logging
import platform
import sys
import time
from pathlib import Path
from typing import Any

from uav_tracking_mpc.mpc.newton_solver import NewtonSolver
from uav_tracking_mpc.studies.benchmark.cases import cases, paper_case
from uav_tracking_mpc.studies.benchmark.solver_timing import (
    OURS,
    horizon_sweep,
    measure,
    missions_per_second,
    peers,
    summary,
)

MISSION_STEPS = 150
HORIZONS = [5, 10, 20, 30, 50, 100]


def add_parser(subparsers: Any) -> argparse.ArgumentParser:
    """Add the command ``benchmark``; its handler is ``run`` of the namespace."""
    parser = subparsers.add_parser(
        "benchmark",
        help="time the solver against CasADi with fatrop and IPOPT",
        description="Time the solver against its peers: same problems, same starts, one run.",
    )
    add_arguments(parser)
    parser.set_defaults(run=main)
    return parser


def _count(text: str) -> int:
    if int(text) < 1:
        raise ValueError(f"{text} is not positive")
    return int(text)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of the command."""
    parser.add_argument(
        "--config", default="paper", choices=["paper"], help="what the cases are built on"
    )
    parser.add_argument("--output", type=Path, metavar="DIR", help="where the figure and JSON go")
    parser.add_argument(
        "--json", action="store_true", help="print one JSON object and nothing else"
    )
    parser.add_argument("--cold", type=_count, default=2000, help="random cold starts for ours")
    parser.add_argument(
        "--peers-cold", type=_count, default=20, help="how many of them the peers solve as well"
    )
    parser.add_argument("--seed", type=int, default=0, help="of the random states")
    parser.add_argument("--quick", action="store_true", help="few repetitions, no figure")


def main(arguments: argparse.Namespace) -> int:
    """Run the command; returns the exit code."""
    results = run(
        cold=arguments.cold,
        peers_cold=arguments.peers_cold,
        seed=arguments.seed,
        quick=arguments.quick,
        output=arguments.output,
    )
    if arguments.json:
        print(json.dumps(results))
    else:
        _print_table(results)
        if arguments.output is not None:
            print(f"saved in {arguments.output}")
    shares = [figures[OURS]["converged_share"] for figures in results["cases"].values()]
    return 0 if all(share is None or share >= 0.99 for share in shares) else 1


def run(
    *,
    cold: int = 2000,
    peers_cold: int = 20,
    seed: int = 0,
    quick: bool = False,
    output: Path | None = None,
) -> dict[str, Any]:
    """Run all cases.

    Args:
        cold: Random cold starts for ours.
        peers_cold: How many of them the peers solve as well.
        seed: Of the random states.
        quick: At most 50 cold starts, 5 for the peers, 2 transients, and no figure.
        output: Folder for ``benchmark.json`` and ``solve_time.png``, or None.

    Returns:
        ``cases.<case>.<solver>`` as
        :func:`uav_tracking_mpc.studies.benchmark.solver_timing.summary`, with the ratios of
        the medians, versions and the duration.
    """
    begin = time.perf_counter()
    if quick:
        cold, peers_cold = min(cold, 50), min(peers_cold, 5)
    results: dict[str, Any] = {"seed": seed, "machine": platform.processor() or platform.machine()}
    results["cases"], results["ratios"] = {}, {}
    with _Progress() as progress:
        for case in cases():
            progress(f"{case.name}: preparing")
            solvers = {OURS: NewtonSolver(case.problem), **peers(case)}
            figures = summary(
                measure(
                    case,
                    solvers,
                    repetitions=2 if quick else 6,
                    cold=cold,
                    peers_cold=min(cold, peers_cold),
                    seed=seed,
                    progress=progress,
                )
            )
            results["cases"][case.name] = figures
            medians = {
                name: float(row["transient_median_us"] or 0) for name, row in figures.items()
            }
            results["ratios"][case.name] = {
                name: medians[name] / medians[OURS] for name in medians if name != OURS
            }
        progress("missions")
        results["missions_per_second"] = missions_per_second(paper_case(10), MISSION_STEPS)
        if not quick:
            results["horizons"] = HORIZONS
            results["horizon_median_us"] = horizon_sweep(HORIZONS, paper_case, progress)
    results["duration_s"] = time.perf_counter() - begin
    if output is not None:
        output.mkdir(parents=True, exist_ok=True)
        (output / "benchmark.json").write_text(json.dumps(results, indent=2), encoding="utf-8")
        if not quick:
            _save_figure(results, output / "solve_time.png")
    return results


class _Progress:
    """One line on stderr that says what runs; silent where nobody looks."""

    def __enter__(self) -> _Progress:
        from rich.console import Console

        console = Console(stderr=True)
        self._status = console.status("benchmark") if console.is_terminal else None
        if self._status is not None:
            self._status.start()
        elif not logging.getLogger().handlers:
            print("benchmark: a few minutes", file=sys.stderr)
        return self

    def __call__(self, text: str) -> None:
        if self._status is not None:
            self._status.update(text)

    def __exit__(self, *_: object) -> None:
        if self._status is not None:
            self._status.stop()


COLUMNS = (
    ("case", 20), ("solver", 8), ("median us", 10), ("p99 us", 9), ("max us", 9), ("iter", 5),
    ("ratio", 7), ("cold us", 9), ("cold n", 7), ("conv %", 7), ("best %", 7),
)  # fmt: skip


def _print_table(results: dict[str, Any]) -> None:
    print(" ".join(title.rjust(width) for title, width in COLUMNS))
    for case, solvers in results["cases"].items():
        for name, figures in solvers.items():
            ratio = results["ratios"][case].get(name)
            words = (
                case, name, _number(figures["transient_median_us"], 1),
                _number(figures["p99_us"], 1), _number(figures["max_us"], 1),
                _number(figures["iterations_median"], 0), _number(ratio, 1),
                _number(figures["cold_median_us"], 0),
                str(figures["cold_solves"]), _percent(figures["converged_share"]),
                _percent(figures["best_cost_share"]),
            )  # fmt: skip
            print(" ".join(w.rjust(width) for w, (_, width) in zip(words, COLUMNS, strict=True)))
    print(
        "median, p99, max: warm, first 30 closed-loop steps; ratio: their median over ours; "
        "best: cost within 0.1 % of the best found, over the states that all solved."
    )
    missions = results["missions_per_second"]
    print(f"missions of {MISSION_STEPS} steps (paper_n10, ours): {missions:.0f} a second")
    print(f"{results['duration_s']:.0f} s")


def _number(value: float | None, digits: int) -> str:
    return "" if value is None else f"{value:.{digits}f}"


def _percent(value: float | None) -> str:
    return "" if value is None else f"{100.0 * value:.1f}"


def _save_figure(results: dict[str, Any], path: Path) -> None:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(6.4, 4.2), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    for name, medians in results["horizon_median_us"].items():
        axes.loglog(results["horizons"], medians, marker="o", label=name)
    axes.set_xlabel("horizon N")
    axes.set_ylabel("median solve time [us], warm, to convergence")
    axes.set_xticks(results["horizons"], [str(n) for n in results["horizons"]])
    axes.minorticks_off()
    axes.grid(which="major", alpha=0.3)
    axes.legend()
    figure.savefig(path, dpi=150)
