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

"""The flight in space, as Figure 2 of the paper: path, ground track, target, desired orbit."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from matplotlib.transforms import Bbox
from mpl_toolkits.mplot3d.axes3d import Axes3D
from numpy.typing import NDArray

from uav_tracking_mpc.report.figure_style import BLACK, BLUE, GREY, LIGHT_GREY, VERMILLION, drawing
from uav_tracking_mpc.report.time_marks import mark_times, on_screen
from uav_tracking_mpc.simulation.flight_log import FlightLog

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
    orbit = _circle(log, _last_finite(target))
    with drawing(*SIZE) as figure:
        # Larger than the figure: mplot3d clips lines at the axes, and the scene is fitted below.
        axes: Axes3D = figure.add_axes((-0.5, -0.5, 2.0, 2.0), projection="3d")
        # Draw in the order of the calls: sorting whole curves by depth breaks their crossings.
        axes.computed_zorder = False
        ground = _frame(axes, np.vstack([path, target, orbit]))
        _fit(figure, axes)
        start, goal = _first_finite(path)[:, None], _last_finite(target)[:, None]
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


def _circle(log: FlightLog, centre: NDArray[np.float64]) -> NDArray[np.float64]:
    """Desired orbit about a place of the target, shape (181, 3)."""
    angle = np.linspace(0.0, 2.0 * np.pi, 181)
    radius = log.orbit.radius
    height = np.full_like(angle, log.orbit.altitude)
    return centre + np.column_stack([radius * np.cos(angle), radius * np.sin(angle), height])


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


def _first_finite(points: NDArray[np.float64]) -> NDArray[np.float64]:
    finite = points[np.isfinite(points).all(axis=1)]
    return finite[0] if len(finite) else np.full(3, np.nan)


def _last_finite(points: NDArray[np.float64]) -> NDArray[np.float64]:
    finite = points[np.isfinite(points).all(axis=1)]
    return finite[-1] if len(finite) else np.zeros(3)
