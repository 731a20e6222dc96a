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

"""A flight as a moving picture: seen from above, with the range error beside it."""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from PIL import Image

from uav_tracking_mpc.report.atomic_write import write_atomically
from uav_tracking_mpc.report.figure_style import BLACK, BLUE, GREEN, LIGHT_GREY, VERMILLION, drawing
from uav_tracking_mpc.report.metrics import COLUMNS, settling_bands
from uav_tracking_mpc.simulation.flight_log import FlightLog

SIZE, DPI = (7.6, 3.3), 100  # [inch], dots per inch
FRAMES, FRAME_TIME = 150, 80  # -, ms
COLOURS = 64  # of the file: it stays small
FINEST = 0.01  # least range error that is drawn [m]
TAIL = 15.0  # time that the bold part of the path covers [s]
# Silhouette of the aircraft seen from above, its left half from nose to tail, 2 long.
HALF = np.array(
    [(1.0, 0.0), (0.85, 0.12), (0.35, 0.14), (0.2, 1.2), (-0.1, 1.2), (-0.25, 0.13), (-0.7, 0.1),
     (-0.8, 0.5), (-1.0, 0.5), (-0.95, 0.0)]
)  # fmt: skip
AIRCRAFT = np.vstack([HALF, HALF[::-1] * (1.0, -1.0)])


def save_animation(log: FlightLog, path: Path, frames: int = FRAMES) -> None:
    """Write the flight as an animated GIF.

    Args:
        log: Record of the flight, at least two samples, all finite.
        path: File to write; its folder exists.
        frames: Pictures in it.
    """
    with drawing(*SIZE) as figure:
        figure.set_dpi(DPI)
        draw = _scene(figure, log)
        pictures = []
        for index in np.linspace(0, len(log.time) - 1, frames).round().astype(int):
            draw(index)
            canvas: Any = figure.canvas
            canvas.draw()
            pictures.append(Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB"))
    # One palette for all, or colours would flicker.
    palette = pictures[-1].quantize(COLOURS, Image.Quantize.MAXCOVERAGE)
    first, *others = (each.quantize(palette=palette, dither=Image.Dither.NONE) for each in pictures)
    file = io.BytesIO()
    first.save(file, "GIF", save_all=True, append_images=others, duration=FRAME_TIME, loop=0)
    write_atomically(path, file.getvalue())


def _scene(figure: Figure, log: FlightLog) -> Callable[[int], None]:
    """What all pictures share; returns what draws the rest at a sample of the record."""
    angle = np.linspace(0.0, 2.0 * np.pi, 121)
    circle = log.orbit.radius * np.stack([np.cos(angle), np.sin(angle)])
    places = np.hstack([log.vehicle[:, :2].T, *(log.target[:, :2, None] + circle)])
    low, high = places.min(axis=1), places.max(axis=1)
    size = float((high - low).max())
    above, beside = figure.subplots(1, 2, width_ratios=(1.75, 1.0))
    figure.subplots_adjust(left=0.08, right=0.985, bottom=0.145, top=0.92, wspace=0.2)
    (west, south), (east, north) = low - 0.05 * size, high + 0.05 * size
    above.set(xlim=(west, east), ylim=(south, north), xlabel="east [m]", ylabel="north [m]")
    above.set_aspect("equal", anchor="W")
    orbit = _line(above, color=BLACK, lw=1.0, ls=(0, (5, 2.5)))
    past = _line(above, color="#9DC3E0", lw=1.0)
    tail = _line(above, color=BLUE, lw=2.2)
    track = _line(above, color=VERMILLION, lw=1.0)
    star = _line(above, color=VERMILLION, marker="*", ms=11, ls="none")
    (aircraft,) = above.fill(*AIRCRAFT.T, color=BLACK, zorder=5)
    error = np.maximum(np.abs(log.error[:, COLUMNS["range"]]), FINEST)
    beside.set(
        yscale="log", xlim=log.time[[0, -1]], ylim=(FINEST, 1.5 * error.max()),
        xlabel="time [s]", ylabel="range error [m]", title="shaded: settled",
    )  # fmt: skip
    beside.axhspan(FINEST, settling_bands(log)["range"], color=GREEN, alpha=0.15, lw=0.0)
    beside.plot(log.time, error, color=LIGHT_GREY, lw=0.8)
    flown = _line(beside, color=BLUE, lw=1.4)

    def draw(index: int) -> None:
        time, vehicle = log.time[: index + 1], log.vehicle[: index + 1]
        x, y, _, heading, _, _ = vehicle[-1]
        path, target = vehicle[:, :2].T, log.target[: index + 1, :2].T
        cos, sin = np.cos(heading), np.sin(heading)
        orbit.set_data(target[:, -1:] + circle)
        past.set_data(path)
        tail.set_data(path[:, time >= time[-1] - TAIL])
        track.set_data(target)
        star.set_data(target[:, -1:])
        aircraft.set_xy(np.array([x, y]) + 0.035 * size * AIRCRAFT @ [[cos, sin], [-sin, cos]])
        flown.set_data(time, error[: index + 1])
        above.set_title(f"seen from above, {time[-1]:5.1f} s")

    return draw


def _line(axes: Axes, **style: Any) -> Any:
    (line,) = axes.plot([], [], **style)
    return line
