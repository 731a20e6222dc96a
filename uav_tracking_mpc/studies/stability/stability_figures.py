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

"""Pictures: the ellipsoid, the decrease on it, and the maps of X_N."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from uav_tracking_mpc.report.figure_style import BLACK, BLUE, GREEN, OTHERS, VERMILLION, drawing
from uav_tracking_mpc.studies.stability.attraction import COORDINATES, UNITS, AttractionMap
from uav_tracking_mpc.terminal.stability_problem import StabilityProblem
from uav_tracking_mpc.terminal.theorems import q_star
from uav_tracking_mpc.terminal.violation import Excess, directions

PAIRS = (("range", "bearing"), ("altitude", "path_angle"), ("range", "speed"))


def ellipsoid_figure(problem: StabilityProblem, level: float) -> Figure:
    """Shadows of X_f on pairs of states, with flights of kappa_l that start on its edge.

    Args:
        problem: The configuration.
        level: varrho [-].
    """
    parts, dynamics = problem.ingredients(), problem.dynamics()
    inverse = np.linalg.inv(parts.weight)
    states = np.sqrt(level) * directions(parts.weight, 12, np.random.default_rng(3))
    flights = [states]
    for _ in range(60):
        states = np.array(dynamics(states.T, (states @ parts.gain.T).T)).T
        flights.append(states)
    paths = np.array(flights)
    turn = np.linspace(0.0, 2.0 * np.pi, 200)
    circle = np.stack([np.cos(turn), np.sin(turn)])
    with drawing(11.0, 3.8) as figure:
        for axes, (first, second) in zip(figure.subplots(1, 3), PAIRS, strict=True):
            i, j = COORDINATES[first], COORDINATES[second]
            # The shadow on (i, j) of x'Px <= level has the matrix (P^-1)_ij,ij.
            block = inverse[np.ix_([i, j], [i, j])]
            edge = np.sqrt(level) * np.linalg.cholesky(block) @ circle
            axes.fill(*edge, alpha=0.15, color=BLUE)
            axes.plot(*edge, color=BLUE)
            axes.plot(paths[:, :, i], paths[:, :, j], lw=0.7, color=VERMILLION)
            axes.plot(paths[0, :, i], paths[0, :, j], "o", ms=3, color=VERMILLION)
            axes.set_xlabel(f"error of {_label(first)}")
            axes.set_ylabel(f"error of {_label(second)}")
        figure.suptitle(f"Terminal set at level {level:.4g}, and flights of the local controller")
        figure.tight_layout()
    return figure


def decrease_figure(problem: StabilityProblem, marks: dict[str, float], ceiling: float) -> Figure:
    """Worst decrease over the sphere of each level, and the levels that matter.

    Args:
        problem: The configuration.
        marks: Levels to mark [-], by name.
        ceiling: Largest level shown [-].
    """
    parts = problem.ingredients()
    weight = parts.weight
    star = q_star(problem.state_weight, problem.input_weight, parts.gain)
    excess = Excess(problem.dynamics(), parts.gain, weight, weight - star)
    rays = directions(weight, 6_000, np.random.default_rng(0))
    levels = np.linspace(0.01, 1.0, 45) * ceiling
    relative = np.array([excess(np.sqrt(level) * rays) / level for level in levels])
    with drawing(8.0, 4.2) as figure:
        axes = figure.add_subplot()
        axes.plot(levels, np.nanmax(relative, axis=1), color=BLUE, label="worst of 6000 directions")
        axes.plot(levels, np.nanmedian(relative, axis=1), color=BLUE, ls="--", label="median")
        axes.axhline(0.0, color=BLACK, lw=0.8)
        for colour, (name, level) in zip((VERMILLION, GREEN, *OTHERS), marks.items(), strict=False):
            axes.axvline(level, color=colour, lw=1.2, label=f"{name}: {level:.3g}")
        axes.set_xlabel("level of the ellipsoid")
        axes.set_ylabel("(change of V_f + stage cost) / V_f")
        axes.legend()
        figure.tight_layout()
    return figure


def maps_figure(maps: list[AttractionMap]) -> Figure:
    """Maps of X_N: rows of slices, columns of horizons; feasible states are coloured.

    Args:
        maps: Any number of them; those of one slice stand in one row.
    """
    rows: dict[tuple[str, str], list[AttractionMap]] = {}
    for entry in maps:
        rows.setdefault((entry.slice.first, entry.slice.second), []).append(entry)
    columns = max(map(len, rows.values()))
    with drawing(3.7 * columns, 3.4 * len(rows)) as figure:
        panels = figure.subplots(len(rows), columns, squeeze=False)
        for row, members in zip(panels, rows.values(), strict=True):
            for axes, member in zip(row, members, strict=False):
                _draw_map(axes, member)
            for axes in row[len(members) :]:
                axes.set_axis_off()
        figure.tight_layout()
    return figure


def _draw_map(axes: Axes, entry: AttractionMap) -> None:
    where = entry.slice
    axes.pcolormesh(
        where.second_values,
        where.first_values,
        entry.feasible.astype(float),
        cmap="Blues",
        vmin=0.0,
        vmax=1.6,
        shading="nearest",
        rasterized=True,
    )
    first, second = COORDINATES[where.first], COORDINATES[where.second]
    colour, word = (GREEN, "feasible") if entry.marked_feasible else (VERMILLION, "infeasible")
    axes.plot(
        entry.marked[second], entry.marked[first], "*", ms=14, color=colour, mec="white", mew=0.8,
        clip_on=False, zorder=3,
    )  # fmt: skip
    axes.set_title(f"N = {entry.horizon}: marked start {word}")
    axes.set_xlabel(_label(where.second))
    axes.set_ylabel(_label(where.first))


def _label(coordinate: str) -> str:
    return f"{coordinate.replace('_', ' ')} [{UNITS[coordinate]}]"
