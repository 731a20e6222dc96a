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

"""Labelled dots along a path in space, placed so that no label hides another or the path."""

from __future__ import annotations

import numpy as np
from matplotlib.patheffects import withStroke
from mpl_toolkits.mplot3d import proj3d
from mpl_toolkits.mplot3d.axes3d import Axes3D
from numpy.typing import NDArray

from uav_tracking_mpc.report.figure_style import BLACK, BLUE, GREY

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
