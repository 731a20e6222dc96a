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

"""The benchmark for people: a table, a figure, and whether our solver converged."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from uav_tracking_mpc.report.atomic_write import write_json
from uav_tracking_mpc.report.figure_style import drawing, save_figure
from uav_tracking_mpc.report.table import Table
from uav_tracking_mpc.studies.benchmark.solver_timing import OURS

LEAST_CONVERGED = 0.99  # share of the cold starts
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
        results: Of :func:`~uav_tracking_mpc.studies.benchmark.benchmark_study.benchmark`.
    """
    shares = [figures[OURS]["converged_share"] for figures in results["cases"].values()]
    return all(share is None or share >= LEAST_CONVERGED for share in shares)


def in_words(results: dict[str, Any]) -> list[Any]:
    """Lines of text and a table of rich.

    Args:
        results: Of :func:`~uav_tracking_mpc.studies.benchmark.benchmark_study.benchmark`.
    """
    return [
        benchmark_table(results).as_rich(),
        f"missions of {results['mission_steps']} steps (paper_n10, ours): "
        f"{results['missions_per_second']:.0f} a second",
        f"{results['duration_s']:.0f} s",
    ]


def benchmark_table(results: dict[str, Any]) -> Table:
    """One row for every solver on every case.

    Args:
        results: Of :func:`~uav_tracking_mpc.studies.benchmark.benchmark_study.benchmark`.
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


def save(results: dict[str, Any], output: Path) -> None:
    """Write ``benchmark.json`` and, where the horizon was swept, ``solve_time.png``.

    Args:
        results: Of :func:`~uav_tracking_mpc.studies.benchmark.benchmark_study.benchmark`.
        output: Folder, made if it is not there.
    """
    output.mkdir(parents=True, exist_ok=True)
    write_json(output / "benchmark.json", results)
    if "horizons" in results:
        save_figure(_figure(results), output / "solve_time.png")


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
