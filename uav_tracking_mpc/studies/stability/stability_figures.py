"""Pictures: the ellipsoid, the decrease on it, and the maps of X_N."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.studies.stability.attraction import UNITS, AttractionMap
from uav_tracking_mpc.terminal.stability_problem import StabilityProblem
from uav_tracking_mpc.terminal.theorems import q_star
from uav_tracking_mpc.terminal.violation import Excess, directions

_LABELS = ("range [m]", "bearing [rad]", "height [m]", "path angle [rad]", "speed [m/s]")


def _new_figure(*arguments: Any, **options: Any) -> tuple[Any, Any]:
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    return pyplot.subplots(*arguments, **options)


def _save(figure: Any, path: Path) -> None:
    from matplotlib import pyplot

    figure.tight_layout()
    figure.savefig(path, dpi=100)
    pyplot.close(figure)


def ellipsoid_figure(problem: StabilityProblem, level: float, path: Path) -> None:
    """Shadows of X_f on pairs of states, with flights of kappa_l that start on its edge.

    Args:
        problem: The configuration.
        level: varrho.
        path: File to write.
    """
    parts, dynamics = problem.ingredients(), problem.dynamics()
    inverse = np.linalg.inv(parts.weight)
    states = np.sqrt(level) * directions(parts.weight, 12, np.random.default_rng(3))
    flights = [states]
    for _ in range(60):
        states = np.array(dynamics(states.T, (states @ parts.gain.T).T)).T
        flights.append(states)
    paths = np.array(flights)
    figure, axes = _new_figure(1, 3, figsize=(11, 3.8))
    turn = np.linspace(0.0, 2.0 * np.pi, 200)
    circle = np.stack([np.cos(turn), np.sin(turn)])
    for axis, (i, j) in zip(axes, ((0, 1), (2, 3), (0, 4)), strict=True):
        # The shadow on (i, j) of x'Px <= level has the matrix (P^-1)_ij,ij.
        block = inverse[np.ix_([i, j], [i, j])]
        edge = np.sqrt(level) * np.linalg.cholesky(block) @ circle
        axis.fill(edge[0], edge[1], alpha=0.15, color="C0")
        axis.plot(edge[0], edge[1], color="C0")
        axis.plot(paths[:, :, i], paths[:, :, j], lw=0.7, color="C1")
        axis.plot(paths[0, :, i], paths[0, :, j], "o", ms=3, color="C1")
        axis.set_xlabel(f"error of {_LABELS[i]}")
        axis.set_ylabel(f"error of {_LABELS[j]}")
        axis.grid(alpha=0.3)
    figure.suptitle(f"Terminal set at level {level:.4g}, and flights of the local controller")
    _save(figure, path)


def decrease_figure(
    problem: StabilityProblem, marks: dict[str, float], ceiling: float, path: Path
) -> None:
    """Worst decrease over the sphere of each level, and the levels that matter.

    Args:
        problem: The configuration.
        marks: Levels to mark, by name.
        ceiling: Largest level shown.
        path: File to write.
    """
    parts = problem.ingredients()
    weight = parts.weight
    star = q_star(problem.state_weight, problem.input_weight, parts.gain)
    excess = Excess(problem.dynamics(), parts.gain, weight, weight - star)
    rays = directions(weight, 6_000, np.random.default_rng(0))
    levels = np.linspace(0.01, 1.0, 45) * ceiling
    worst, typical = [], []
    for level in levels:
        relative = excess(np.sqrt(level) * rays) / level
        worst.append(np.nanmax(relative))
        typical.append(np.nanmedian(relative))
    figure, axis = _new_figure(figsize=(8, 4.2))
    axis.plot(levels, worst, label="worst of 6000 directions")
    axis.plot(levels, typical, label="median", ls="--")
    axis.axhline(0.0, color="k", lw=0.8)
    for index, (name, level) in enumerate(marks.items()):
        axis.axvline(level, color=f"C{index + 2}", lw=1.2, label=f"{name}: {level:.3g}")
    axis.set_xlabel("level of the ellipsoid")
    axis.set_ylabel("(change of V_f + stage cost) / V_f")
    axis.legend(fontsize=8)
    axis.grid(alpha=0.3)
    _save(figure, path)


def maps_figure(maps: list[AttractionMap], path: Path) -> None:
    """Maps of X_N: rows of slices, columns of horizons; feasible states are coloured.

    Args:
        maps: Any number of them; those of one slice stand in one row.
        path: File to write.
    """
    kinds = list(dict.fromkeys((entry.slice.first, entry.slice.second) for entry in maps))
    columns = max(sum((m.slice.first, m.slice.second) == kind for m in maps) for kind in kinds)
    figure, axes = _new_figure(
        len(kinds), columns, figsize=(3.7 * columns, 3.4 * len(kinds)), squeeze=False
    )
    for row, kind in enumerate(kinds):
        members = [m for m in maps if (m.slice.first, m.slice.second) == kind]
        for column in range(columns):
            if column < len(members):
                _draw_map(axes[row][column], members[column])
            else:
                axes[row][column].set_axis_off()
    _save(figure, path)


def _draw_map(axis: Any, entry: AttractionMap) -> None:
    from uav_tracking_mpc.studies.stability.attraction import COORDINATES

    where = entry.slice
    shown: NDArray[np.float64] = entry.feasible.astype(float)
    axis.pcolormesh(
        where.second_values,
        where.first_values,
        shown,
        cmap="Blues",
        vmin=0.0,
        vmax=1.6,
        shading="nearest",
        rasterized=True,
    )
    first, second = COORDINATES[where.first], COORDINATES[where.second]
    colour, word = ("C2", "feasible") if entry.marked_feasible else ("C3", "infeasible")
    axis.plot(entry.marked[second], entry.marked[first], "*", ms=13, color=colour)
    axis.set_title(f"N = {entry.horizon}: marked start {word}", fontsize=9)
    axis.set_xlabel(f"{where.second} [{UNITS[where.second]}]")
    axis.set_ylabel(f"{where.first} [{UNITS[where.first]}]")
