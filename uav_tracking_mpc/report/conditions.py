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

"""Limits, air, target and fallback modes over time: what a real aircraft adds to Figure 3.

Left bank, airspeed and path angle between the limits of the aircraft; right how far the flight is
from its orbit, the wind and the drift, and the target's speed; below which mode was flown when.
All panels share the time axis.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import LogLocator, NullFormatter
from numpy.typing import NDArray

from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.dynamics.frames import bank_from_turn_rate
from uav_tracking_mpc.limits import COMPILED
from uav_tracking_mpc.report.figure_style import BLUE, GREY, MODES, PURPLE, VERMILLION, drawing
from uav_tracking_mpc.report.metrics import COLUMNS, settling_bands
from uav_tracking_mpc.report.time_axes import (
    BAND,
    BOUND,
    REFERENCE,
    finish,
    share_time,
    time_limits,
    value_limits,
)
from uav_tracking_mpc.simulation.flight_log import FlightLog

WIDTH, ABOVE, BELOW, ROW = 9.5, 6.0, 1.15, 0.22  # [inch]; the last for each mode that was flown
ROOM = {"left": 0.075, "right": 0.985, "hspace": 0.3, "wspace": 0.2}
CALM = 0.1  # m/s; less wind or target motion than this is rounding or noise
FINEST = 0.01  # least error that is drawn [m]


def has_conditions(log: FlightLog) -> bool:
    """Whether there is more to show than the paper's point mass in still air.

    Args:
        log: Record of the flight: of a controller that knows limits, lag and drift, in wind, or
            about a target that moves.
    """
    return has_limits(log) or _moves(log.wind) or _moves(log.target_velocity)


def has_limits(log: FlightLog) -> bool:
    """Whether the controller planned with the limits of the aircraft.

    Args:
        log: Record of the flight.
    """
    name, value = COMPILED
    return log.tracking is not None and getattr(log.tracking, name) == value


def _moves(velocity: NDArray[np.float64] | None) -> bool:
    """Whether most of the time there is motion."""
    if velocity is None or not len(velocity):
        return False
    return bool(np.median(np.linalg.norm(velocity, axis=1)) > CALM)


def conditions_figure(log: FlightLog) -> Figure:
    """All of it over time.

    Args:
        log: Record of the flight, of any length.
    """
    rows = _rows(log)
    strip = ROW * len(rows)
    with drawing(WIDTH, ABOVE + BELOW + strip) as figure:
        height = figure.get_figheight()
        foot = (strip + BELOW) / height
        left, right = figure.subplots(
            3, 2, sharex=True, gridspec_kw={"bottom": foot, "top": 1.0 - 0.5 / height, **ROOM}
        ).T
        # Starts further right: names of modes are longer than numbers.
        below = figure.add_axes((0.19, 0.45 / height, 0.795, strip / height), sharex=left[0])
        _bank_panel(left[0], log)
        _airspeed_panel(left[1], log)
        _path_angle_panel(left[2], log)
        _error_panel(right[0], log)
        _air_panel(right[1], log)
        _target_panel(right[2], log)
        _mode_panel(below, log, rows)
        panels = [*left, *right, below]
        for letter, axes in zip("abcdefg", panels, strict=True):
            axes.set_title(f"({letter}) {axes.get_title(loc='left')}", loc="left")
        for axes in (left[-1], right[-1], below):
            axes.set_xlabel("time [s]")
        share_time(below, log)
        figure.legend(
            handles=[
                Line2D([], [], color=BLUE, label="flight"),
                Line2D([], [], label="orbit asked for", **REFERENCE),
                Line2D([], [], label="limit", **BOUND),
                Patch(label="settled", **BAND),
            ],
            loc="upper center",
            ncols=4,
            columnspacing=2.5,
        )
    return figure


def _bank_panel(axes: Axes, log: FlightLog) -> None:
    """Right wing down is positive; asked for is what the orbit needs without a drift."""
    turn_rate, _, _ = log.steady_inputs.tolist()
    steady = math.degrees(bank_from_turn_rate(turn_rate, log.orbit.speed))
    limits = []
    if log.tracking is not None and has_limits(log):
        most = math.degrees(log.tracking.envelope.bank_max)
        limits = [-most, most]
    asked = np.full(len(log.time), steady)
    _limited_panel(axes, log, np.degrees(log.bank), asked, limits)
    if limits and len(log.time):
        largest = np.nanmax(np.abs(np.degrees(log.bank)), initial=0.0)
        _aside(axes, f"at most {largest:.0f}° of {limits[1]:.0f}°")
    finish(axes, "Bank, right wing down", r"$\phi$ [deg]", *axes.get_ylim())


def _airspeed_panel(axes: Axes, log: FlightLog) -> None:
    values, limits = log.vehicle[:, 5], []
    if log.tracking is not None and has_limits(log):
        limits = [log.tracking.envelope.airspeed_min, log.tracking.envelope.airspeed_max]
    _limited_panel(axes, log, values, log.reference[:, COLUMNS["speed"]], limits)
    if len(values):
        _aside(axes, f"{np.nanmin(values):.1f} to {np.nanmax(values):.1f} m/s")
    finish(axes, "Airspeed", "$v$ [m/s]", *axes.get_ylim())


def _path_angle_panel(axes: Axes, log: FlightLog) -> None:
    values, limits = np.degrees(log.vehicle[:, 4]), []
    if log.tracking is not None and has_limits(log):
        envelope = log.tracking.envelope
        limits = np.degrees([envelope.path_angle_min, envelope.path_angle_max]).tolist()
    _limited_panel(axes, log, values, np.zeros(len(log.time)), limits)
    if len(values):
        _aside(axes, f"{np.nanmin(values):.1f}° to {np.nanmax(values):.1f}°")
    finish(axes, "Path angle through the air", r"$\chi$ [deg]", *axes.get_ylim())


def _limited_panel(
    axes: Axes,
    log: FlightLog,
    values: NDArray[np.float64],
    asked: NDArray[np.float64],
    limits: list[float],
) -> None:
    """A quantity, what is asked of it, and its limits."""
    for limit in limits:
        axes.axhline(limit, **BOUND)
    axes.plot(log.time, asked, **REFERENCE)
    axes.plot(log.time, values, color=BLUE)
    axes.set_ylim(*value_limits(np.append(values, asked), *limits))


def _error_panel(axes: Axes, log: FlightLog) -> None:
    """Sizes of the errors in range and altitude, over whole decades."""
    axes.set_yscale("log")
    top = FINEST
    for name, colour in (("range", BLUE), ("altitude", PURPLE)):
        error = np.maximum(np.abs(log.error[:, COLUMNS[name]]), FINEST)
        axes.plot(log.time, error, color=colour, label=name, lw=1.2)
        top = max(top, np.nanmax(error, initial=FINEST))
    axes.axhspan(FINEST, settling_bands(log)["range"], **BAND)
    _inner_legend(axes)
    high = 10.0 ** math.ceil(math.log10(top) + 1e-9)
    finish(axes, "Off the orbit", "error [m]", FINEST, max(high, 10.0))
    axes.yaxis.set_major_locator(LogLocator(numticks=6))
    axes.yaxis.set_minor_formatter(NullFormatter())


def _air_panel(axes: Axes, log: FlightLog) -> None:
    """Wind over ground, and drift: the air as the target sees it."""
    wind = np.linalg.norm(log.wind, axis=1)
    drift = np.linalg.norm(log.drift, axis=1)
    axes.plot(log.time, drift, color=VERMILLION, label="drift: wind less target's motion", lw=1.2)
    axes.plot(log.time, wind, color=BLUE, label="wind", lw=1.2)
    _inner_legend(axes)
    if len(wind) and _moves(log.wind):
        east, north, _ = np.nanmean(log.wind, axis=0)
        towards = math.degrees(math.atan2(east, north)) % 360.0
        _aside(axes, f"blows towards {towards:03.0f}° on average")
    _, high = value_limits(np.append(wind, drift), 1.0)
    finish(axes, "Wind and drift", "speed [m/s]", 0.0, 1.25 * high)  # room for the legend


def _target_panel(axes: Axes, log: FlightLog) -> None:
    velocity = log.target_velocity
    speed = np.zeros(len(log.time)) if velocity is None else np.linalg.norm(velocity, axis=1)
    axes.plot(log.time, speed, color=BLUE)
    if not _moves(velocity):
        _aside(axes, "it stands")
    finish(axes, "Target's speed", "speed [m/s]", 0.0, value_limits(speed, 0.0, 1.0)[1])


def _rows(log: FlightLog) -> list[FallbackMode]:
    """Modes that were flown, best first."""
    flown = {each.mode for each in log.modes}
    return [mode for mode in FallbackMode if mode in flown] or [FallbackMode.OPTIMAL]


def _mode_panel(axes: Axes, log: FlightLog, rows: list[FallbackMode]) -> None:
    """A row for each mode that was flown, and a bar for each time that it was."""
    begin, end = time_limits(log)
    least = 0.004 * (end - begin)  # as wide as can be seen
    for first, last, flown in log.mode_spans:
        bar = (first, max(last - first, least))
        row = rows.index(flown.mode)
        axes.broken_barh([bar], (row - 0.38, 0.76), color=MODES[flown.mode], lw=0.0)
    if not log.modes:
        style: dict[str, Any] = {"ha": "center", "va": "center", "color": GREY}
        axes.text(0.5, 0.5, "not recorded", transform=axes.transAxes, **style)
    axes.set_title("Mode that was flown", loc="left")
    changes = sum(not each.mode.nominal for each in log.modes)
    if log.modes:
        times = "once" if changes == 1 else f"{changes} times"
        _aside(axes, f"fell back {times}" if changes else "never fell back")
    axes.set_ylim(len(rows) - 0.4, -0.6)
    axes.set_yticks(range(len(rows)), [mode.value for mode in rows])
    axes.tick_params(axis="y", length=0)
    axes.grid(visible=False, axis="y")


def _aside(axes: Axes, words: str) -> None:
    axes.set_title(words, loc="right", fontsize=8, color=GREY)


def _inner_legend(axes: Axes) -> None:
    axes.legend(loc="upper right", ncols=2, fontsize=8, handlelength=1.4, borderpad=0.1)
