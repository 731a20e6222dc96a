"""A flight as a moving picture: seen from above, with the range error beside it."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray
from PIL import Image

from uav_tracking_mpc.report.atomic_write import write_atomically
from uav_tracking_mpc.report.figure_style import (
    BLACK,
    BLUE,
    GREEN,
    LIGHT_GREY,
    VERMILLION,
    drawing,
)
from uav_tracking_mpc.report.metrics import COLUMNS, SETTLING_BANDS
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
        scene = _Scene(figure, log)
        shown = np.linspace(0, len(log.time) - 1, frames).round().astype(int)
        pictures = [scene.picture(index) for index in shown]
    # One palette for all, or colours would flicker.
    palette = pictures[-1].quantize(COLOURS, Image.Quantize.MAXCOVERAGE)
    first, *others = (each.quantize(palette=palette, dither=Image.Dither.NONE) for each in pictures)
    file = io.BytesIO()
    first.save(file, "GIF", save_all=True, append_images=others, duration=FRAME_TIME, loop=0)
    write_atomically(path, file.getvalue())


class _Scene:
    """The picture at one instant, drawn anew from one to the next.

    Args:
        figure: Empty.
        log: Record of the flight.
    """

    def __init__(self, figure: Figure, log: FlightLog) -> None:
        self._figure, self._log = figure, log
        angle = np.linspace(0.0, 2.0 * np.pi, 121)
        self._circle = log.orbit.radius * np.stack([np.cos(angle), np.sin(angle)])
        above, beside = figure.subplots(1, 2, width_ratios=(1.75, 1.0))
        self._draw_map(above)
        self._draw_error(beside)
        figure.subplots_adjust(left=0.08, right=0.985, bottom=0.145, top=0.92, wspace=0.2)

    def _draw_map(self, axes: Axes) -> None:
        log = self._log
        orbits = log.target[:, :2, None] + self._circle
        places = np.concatenate([log.vehicle[:, :2], orbits.transpose(0, 2, 1).reshape(-1, 2)])
        low, high = places.min(axis=0), places.max(axis=0)
        margin = 0.05 * (high - low).max()
        axes.set(xlim=(low[0] - margin, high[0] + margin), ylim=(low[1] - margin, high[1] + margin))
        axes.set_aspect("equal", anchor="W")
        axes.set(xlabel="east [m]", ylabel="north [m]")
        self._title = axes.set_title("")
        self._orbit = _line(axes, color=BLACK, lw=1.0, ls=(0, (5, 2.5)))
        self._past = _line(axes, color="#9DC3E0", lw=1.0)
        self._tail = _line(axes, color=BLUE, lw=2.2)
        self._track = _line(axes, color=VERMILLION, lw=1.0)
        self._target = _line(axes, color=VERMILLION, marker="*", ms=11, ls="none")
        (self._aircraft,) = axes.fill(*AIRCRAFT.T, color=BLACK, zorder=5)
        self._scale = 0.035 * (high - low).max()

    def _draw_error(self, axes: Axes) -> None:
        log = self._log
        self._error = np.maximum(np.abs(log.error[:, COLUMNS["range"]]), FINEST)
        axes.set_yscale("log")
        axes.set(xlim=(log.time[0], log.time[-1]), ylim=(FINEST, 1.5 * self._error.max()))
        axes.axhspan(FINEST, SETTLING_BANDS["range"], color=GREEN, alpha=0.15, lw=0.0)
        axes.set(xlabel="time [s]", ylabel="range error [m]")
        axes.set_title("shaded: settled")
        axes.plot(log.time, self._error, color=LIGHT_GREY, lw=0.8)
        self._error_line = _line(axes, color=BLUE, lw=1.4)

    def picture(self, index: int) -> Image.Image:
        """The picture at a sample of the record.

        Args:
            index: Of the sample.
        """
        log, now = self._log, self._log.time[index]
        x, y, _, heading, _, _ = log.vehicle[index]
        path, target = log.vehicle[: index + 1, :2], log.target[: index + 1, :2]
        recent = log.time[: index + 1] >= now - TAIL
        self._orbit.set_data(target[-1, :, None] + self._circle)
        self._past.set_data(*path.T)
        self._tail.set_data(*path[recent].T)
        self._track.set_data(*target.T)
        self._target.set_data(*target[-1:].T)
        turn = np.array([[np.cos(heading), -np.sin(heading)], [np.sin(heading), np.cos(heading)]])
        self._aircraft.set_xy(np.array([x, y]) + self._scale * AIRCRAFT @ turn.T)
        self._error_line.set_data(log.time[: index + 1], self._error[: index + 1])
        self._title.set_text(f"seen from above, {now:5.1f} s")
        canvas: Any = self._figure.canvas
        canvas.draw()
        pixels: NDArray[np.uint8] = np.asarray(canvas.buffer_rgba())
        return Image.fromarray(pixels).convert("RGB")


def _line(axes: Axes, **style: Any) -> Any:
    """An empty curve."""
    (line,) = axes.plot([], [], **style)
    return line
