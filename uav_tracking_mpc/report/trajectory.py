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

"""The flight in space, as Figure 2 of the paper, with dots along it that say when."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MaxNLocator
from matplotlib.transforms import Bbox
from mpl_toolkits.mplot3d import proj3d
from mpl_toolkits.mplot3d.axes3d import Axes3D
from numpy.typing import NDArray

from uav_tracking_mpc.report.figure_style import BLACK, BLUE, GREY, LIGHT_GREY, VERMILLION, drawing
from uav_tracking_mpc.simulation.flight_log import FlightLog

INTERVALS = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 30.0, 60.0, 120.0, 300.0, 600.0, 1800.0)
MOST_MARKS = 16
LABEL_SIZE = np.array([32.0, 11.0])  # width and height of a label, [point]
LABEL_DISTANCE = np.array([21.0, 11.0])  # from the dot to the middle of its label, [point]
DOT_DISTANCE = 20.0  # least distance between dots, [point]
DIRECTIONS = np.deg2rad([0, 35, -35, 70, -70, 105, -105, 140, -140, 180])  # tried from outward on


def mark_times(
    axes: Axes3D,
    time: NDArray[np.float64],
    path: NDArray[np.float64],
    ground: float,
    clear: NDArray[np.float64],
) -> None:
    """Draw a dot every so many seconds, on a stem from the ground, with its time beside it.

    Where a flight passes the same place again, dots would pile up: one that is too close to
    another, or has no room left for its label, is not drawn.

    Args:
        axes: Axes whose limits and projection are final.
        time: Shape (n,), in [s].
        path: Shape (n, 3), in [m], nan where unknown.
        ground: Height where the stems begin, in [m].
        clear: Places to keep free of dots and labels, shape (k, 3), in [m].
    """
    if len(time) < 2 or not np.all(np.diff(time) > 0.0):
        return
    points = 72.0 / axes.figure.dpi  # per pixel
    fine = np.linspace(time[0], time[-1], 1500)
    shown = np.column_stack([np.interp(fine, time, column) for column in path.T])
    shown = shown[np.isfinite(shown).all(axis=1)]
    if not len(shown):
        return
    floor = np.column_stack([shown[:, :2], np.full(len(shown), ground)])
    lines = points * on_screen(axes, np.vstack([shown, floor]))
    track = lines[: len(shown)]
    middle = 0.5 * (track.min(axis=0) + track.max(axis=0))
    labels = list(points * on_screen(axes, clear))
    dots = list(labels)
    for instant in _instants(float(time[-1] - time[0])):
        place = np.array([[np.interp(time[0] + instant, time, column) for column in path.T]])
        if not np.all(np.isfinite(place)):
            continue
        dot = points * on_screen(axes, place)[0]
        label = _room_beside(dot, middle, labels, lines)
        if label is None or min(np.hypot(*(dot - other)) for other in dots) < DOT_DISTANCE:
            continue
        labels.append(label)
        dots.append(dot)
        x, y, z = place[0]
        axes.plot([x, x], [y, y], [ground, z], color=GREY, lw=0.6, alpha=0.6, zorder=2)
        axes.plot([x], [y], [z], "o", color=BLUE, mec="white", mew=0.8, ms=5.5, zorder=8)
        axes.annotate(
            f"{instant:g} s",
            tuple(dot / points),
            xycoords="figure pixels",
            xytext=tuple(label - dot),
            textcoords="offset points",
            ha="center",
            va="center",
            fontsize=8,
            color=BLACK,
            zorder=9,
            path_effects=[withStroke(linewidth=2.5, foreground="white")],
        )


def on_screen(axes: Axes3D, places: NDArray[np.float64]) -> NDArray[np.float64]:
    """Where points of space are drawn, shape (n, 2), in [pixel].

    Args:
        axes: Axes whose limits and projection are final.
        places: Points of space, shape (n, 3), in [m].
    """
    x, y, _ = proj3d.proj_transform(*places.T, axes.get_proj())
    return np.asarray(axes.transData.transform(np.column_stack([x, y])))


def _instants(span: float) -> NDArray[np.float64]:
    """Round times within a span, at most :data:`MOST_MARKS`, in [s]."""
    interval = next((dt for dt in INTERVALS if span / dt <= MOST_MARKS), 3600.0)
    interval *= max(1.0, np.ceil(span / interval / MOST_MARKS))
    return np.arange(1, int(span / interval + 1e-9) + 1) * interval


def _room_beside(
    dot: NDArray[np.float64],
    middle: NDArray[np.float64],
    labels: list[NDArray[np.float64]],
    lines: NDArray[np.float64],
) -> NDArray[np.float64] | None:
    """Middle of a label beside a dot: off other labels, and off the lines as far as possible.

    Args:
        dot: Place of the dot, shape (2,), like all places here in [point].
        middle: Middle of the path; the label rather goes away from it.
        labels: Middles of the labels that stand already.
        lines: Points of the curves that a label should not hide, shape (k, 2).

    Returns:
        Shape (2,), or None if every place near the dot is taken.
    """
    outward = np.arctan2(*(dot - middle)[::-1])
    best, fewest = None, float("inf")
    for turn in DIRECTIONS:
        angle = outward + turn
        label = dot + LABEL_DISTANCE * (np.cos(angle), np.sin(angle))
        if any(np.all(np.abs(label - other) < LABEL_SIZE) for other in labels):
            continue
        hidden = float(np.sum(np.all(np.abs(lines - label) < 0.5 * LABEL_SIZE, axis=1)))
        if hidden < fewest:
            best, fewest = label, hidden
    return best


SIZE = (8.0, 5.6)  # [inch]
SCENE = (0.03, 0.03, 0.97, 0.92)  # where axes and labels go: left, bottom, right, top [of figure]


def trajectory_figure(log: FlightLog) -> Figure:
    """Path in ``map`` with equal axes.

    The ground is the plane of the lowest point of target and flight. Time marks stand on stems
    from their place on the ground.

    Args:
        log: Record of the flight, of any length; the target may move.
    """
    path = np.where(np.isfinite(log.vehicle[:, :3]), log.vehicle[:, :3], np.nan)
    target = np.where(np.isfinite(log.target), log.target, np.nan)
    if not len(path):
        path, target = np.full((1, 3), np.nan), np.zeros((1, 3))
    start, goal = _known(path, np.nan)[:1].T, _known(target, 0.0)[-1:].T
    angle = np.linspace(0.0, 2.0 * np.pi, 181)
    level = log.orbit.radius * np.column_stack([np.cos(angle), np.sin(angle)])
    orbit = goal.T + np.insert(level, 2, log.orbit.altitude, axis=1)
    with drawing(*SIZE) as figure:
        # Larger than the figure: mplot3d clips lines at the axes, and the scene is fitted below.
        axes: Axes3D = figure.add_axes((-0.5, -0.5, 2.0, 2.0), projection="3d")
        # Draw in the order of the calls: sorting whole curves by depth breaks their crossings.
        axes.computed_zorder = False
        ground = _frame(axes, np.vstack([path, target, orbit]))
        _fit(figure, axes)
        dashed: dict[str, Any] = {"color": BLACK, "ls": (0, (5, 2.5))}
        axes.plot(*path.T, color=BLUE, lw=2.4, label="UAV", zorder=5)
        axes.plot(*start, "s", color=BLACK, ms=6, ls="none", label="start", zorder=8)
        axes.plot(*orbit.T, lw=1.0, label="desired orbit", zorder=6, **dashed)
        axes.plot(*goal, "*", color=VERMILLION, ms=13, ls="none", label="target", zorder=4)
        if np.nanmax(np.abs(target - goal.T), initial=0.0) > 0.0:
            axes.plot(*target.T, color=VERMILLION, lw=1.4, label="target path", zorder=3)
        axes.plot(path[:, 0], path[:, 1], ground, color=GREY, lw=1.0, label="ground track")
        axes.plot(orbit[:, 0], orbit[:, 1], ground, lw=0.6, alpha=0.5, **dashed)
        mark_times(axes, log.time, path, ground, np.hstack([start, goal]).T)
        figure.legend(loc="upper center", ncols=6, bbox_to_anchor=(0.5, 0.985), columnspacing=1.6)
    return figure


def _frame(axes: Axes3D, points: NDArray[np.float64]) -> float:
    """Limits, equal scale, ticks and labels; returns the height of the ground in [m]."""
    low, high = np.nanmin(points, axis=0), np.nanmax(points, axis=0)
    margin = 0.04 * np.max(high - low)
    ground = float(low[2])
    low[:2] -= margin
    high += margin
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(ground, high[2]))
    extent = np.array([high[0] - low[0], high[1] - low[1], high[2] - ground])
    axes.set_box_aspect(tuple(extent))
    # The nearer the flight is to a plane, the fewer ticks its height has room for.
    height_ticks = int(np.clip(np.ceil(14.0 * extent[2] / np.max(extent)), 1, 6))
    for axis, bins in ((axes.xaxis, 6), (axes.yaxis, 6), (axes.zaxis, height_ticks)):
        axis.set_pane_color((1.0, 1.0, 1.0, 1.0))
        axis.pane.set_edgecolor(LIGHT_GREY)
        begin, end = axis.get_view_interval()
        ticks = MaxNLocator(bins, steps=[1, 2, 2.5, 5, 10]).tick_values(begin, end)
        # Numbers at the ends of two axes would meet in their common corner.
        room = 0.0 if axis is axes.zaxis else 0.06 * (end - begin)
        axis.set_ticks(ticks[(ticks >= begin + room) & (ticks <= end - room)])
    axes.tick_params(pad=7)
    axes.set_xlabel("x, east [m]", labelpad=20)
    axes.set_ylabel("y, north [m]", labelpad=20)
    axes.set_zlabel("z, up [m]", labelpad=12)
    axes.view_init(elev=32.0, azim=-58.0)
    return ground


def _fit(figure: Figure, axes: Axes3D) -> None:
    """Zoom and move the scene, with its labels, into :data:`SCENE`; settles the projection."""
    left, bottom, right, top = SCENE
    extent = tuple(np.ptp([axes.get_xlim3d(), axes.get_ylim3d(), axes.get_zlim3d()], axis=1))
    zoom = 0.5
    for _ in range(4):  # labels keep their size while the scene grows: a few rounds
        axes.set_box_aspect(extent, zoom=zoom)
        box = _scene_box(figure, axes)
        x, y, width, height = axes.get_position(original=True).bounds
        x += 0.5 * (left + right - box.x0 - box.x1)
        y += 0.5 * (bottom + top - box.y0 - box.y1)
        axes.set_position((x, y, width, height))
        zoom *= min((right - left) / box.width, (top - bottom) / box.height)
    figure.draw_without_rendering()


def _scene_box(figure: Figure, axes: Axes3D) -> Bbox:
    """What the cube of the axes and its labels cover, in fractions of the figure."""
    figure.draw_without_rendering()
    limits = axes.get_xlim3d(), axes.get_ylim3d(), axes.get_zlim3d()
    corners = Bbox.null()
    corners.update_from_data_xy(on_screen(axes, np.array(list(product(*limits)))))
    renderer = figure.canvas.get_renderer()  # type: ignore[attr-defined]
    labels = [axis.get_tightbbox(renderer) for axis in (axes.xaxis, axes.yaxis, axes.zaxis)]
    boxes = [box for box in labels if box is not None]
    return Bbox.union([corners, *boxes]).transformed(figure.transFigure.inverted())


def _known(points: NDArray[np.float64], missing: float) -> NDArray[np.float64]:
    """Points that are finite; where there is none, one that stands for them."""
    finite = points[np.isfinite(points).all(axis=1)]
    return finite if len(finite) else np.full((1, 3), missing)
