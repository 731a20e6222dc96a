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

"""Panels over time: states, inputs and cost as Figure 3 of the paper; limits, air and modes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import LogLocator, MaxNLocator, NullFormatter
from numpy.typing import ArrayLike, NDArray

from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.dynamics.frames import bank_from_turn_rate
from uav_tracking_mpc.report.figure_style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    MODES,
    PURPLE,
    VERMILLION,
    drawing,
)
from uav_tracking_mpc.report.metrics import COLUMNS, settling_bands, settling_time
from uav_tracking_mpc.settings.tracking import ARTIFICIAL_ORBIT
from uav_tracking_mpc.simulation.flight_log import FlightLog

REFERENCE: dict[str, Any] = {"color": BLACK, "lw": 1.0, "ls": (0, (5, 2.5)), "zorder": 3.0}
BOUND: dict[str, Any] = {"color": VERMILLION, "lw": 1.0, "ls": (0, (1, 1.2))}
BAND: dict[str, Any] = {"color": GREEN, "alpha": 0.22, "lw": 0.0}


def finish(axes: Axes, title: str, label: str, low: float, high: float) -> None:
    """Title, label and limits of a panel.

    Args:
        axes: Of the panel.
        title: Left above it.
        label: Of its values, with their unit.
        low: Least value that is shown, in the unit of ``label`` [-].
        high: Greatest value that is shown, in the unit of ``label`` [-].
    """
    axes.set(title=title, ylabel=label, ylim=(low, high))
    axes.yaxis.set_label_coords(-0.12, 0.5)  # one line down the column, however long the numbers
    if axes.get_yscale() == "linear":
        axes.yaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 2.5, 5, 10]))


def time_limits(log: FlightLog) -> tuple[float, float]:
    """From the first instant of the record to its last in [s], never an empty interval.

    Args:
        log: Record of the flight.
    """
    instants = np.concatenate([log.time, log.command_time])
    if not len(instants):
        return 0.0, max(log.duration, 1.0)
    begin, end = float(np.min(instants)), float(np.max(instants))
    return begin, end if end > begin else begin + 1.0


def value_limits(values: ArrayLike, *shown: float) -> tuple[float, float]:
    """Limits that hold the values and the lines drawn with them, with a margin.

    Args:
        values: Of any shape; what is not finite does not count.
        shown: Further values, in the same unit [-].
    """
    everything = np.concatenate([np.ravel(values), shown])
    everything = everything[np.isfinite(everything)]
    if not len(everything):
        return -1.0, 1.0
    low, high = float(np.min(everything)), float(np.max(everything))
    margin = max(0.08 * (high - low), 0.02)  # at rest only rounding is left: do not magnify that
    return low - margin, high + margin


SIZE = (9.5, 8.6)  # [inch]
DECADES = 12  # most that a cost is followed down: below is rounding

STATE_PANELS = (
    ("range", "Range", "$r$ [m]"),
    ("altitude", "Altitude above target", "$z$ [m]"),
    ("speed", "Speed", "$v$ [m/s]"),
    ("bearing", "Bearing", r"$\theta$ [rad]"),
    ("pitch", "Path angle (pitch)", r"$\chi$ [rad]"),
)
INPUT_PANELS = (
    ("Turn rate", r"$u_\psi$ [rad/s]"),
    ("Path angle rate", r"$u_\chi$ [rad/s]"),
    ("Acceleration", "$u_v$ [m/s²]"),
)


def states_figure(log: FlightLog) -> Figure:
    """Everything over time.

    Args:
        log: Record of the flight, of any length; without commands their panels stay empty.
    """
    with drawing(*SIZE) as figure:
        left, right = figure.subplots(5, 2, sharex=True).T
        errors = log.error
        for axes, (name, title, label) in zip(left, STATE_PANELS, strict=True):
            _state_panel(axes, log, errors[:, COLUMNS[name]], name, title, label)
        for column, (title, label) in enumerate(INPUT_PANELS):
            _input_panel(right[column], log, column, title, label)
        _logarithmic(right[3], log, log.cost, "Optimal cost", "$V_N$ [-]")
        _logarithmic(right[4], log, 1e6 * log.solve_time, "Solve time", "time [µs]", marker=".")
        figure.subplots_adjust(
            left=0.075, right=0.985, bottom=0.06, top=0.925, hspace=0.34, wspace=0.2
        )
        lowest = left[-1], right[-1]
        _assemble(log, [*left, *right], lowest, "reference, steady input", "bound")
    return figure


def _assemble(
    log: FlightLog, panels: Sequence[Axes], lowest: Sequence[Axes], reference: str, bound: str
) -> None:
    """Letter the panels, name the time that they share, and say above them what their lines are."""
    for letter, axes in zip("abcdefghij", panels, strict=False):
        axes.set_title(f"({letter}) {axes.get_title(loc='left')}", loc="left")
    for axes in lowest:
        axes.set_xlabel("time [s]")
    axes.set_xlim(*time_limits(log))
    axes.xaxis.set_major_locator(MaxNLocator(8, steps=[1, 2, 2.5, 5, 10]))
    axes.figure.legend(
        handles=[
            Line2D([], [], color=BLUE, label="flight"),
            Line2D([], [], label=reference, **REFERENCE),
            Patch(label="settled", **BAND),
            Line2D([], [], label=bound, **BOUND),
        ],
        loc="upper center",
        ncols=4,
        columnspacing=2.5,
    )


def _state_panel(
    axes: Axes, log: FlightLog, error: NDArray[np.float64], name: str, title: str, label: str
) -> None:
    """One state: its reference, the band around it, and when it settles."""
    reference = log.orbit.steady_state[COLUMNS[name]]
    asked = log.reference[:, COLUMNS[name]]  # in flight it may have been another
    values = asked + (_unwrapped(error) if name == "bearing" else error)
    band = settling_bands(log).get(name)
    # Room above and below the band, so that it reads as one where nothing else happens.
    room = 0.0 if band is None else 2.0 * band
    low, high = value_limits(values, reference - room, reference + room)
    if band is not None:
        axes.axhspan(reference - band, reference + band, **BAND)
        settled = settling_time(log.time, error, band)
        text = "not settled" if settled is None else f"settled from {settled:.1f} s"
        axes.set_title(text, loc="right", fontsize=8, color=VERMILLION if settled is None else GREY)
        if settled is not None:
            axes.axvline(settled, color=GREY, lw=0.8)
    if (asked != asked[:1]).any():
        axes.plot(log.time, asked, **REFERENCE)
    else:
        axes.axhline(reference, **REFERENCE)
    axes.plot(log.time, values, color=BLUE, marker="o" if len(values) == 1 else "", ms=4)
    finish(axes, title, label, low, high)


def _input_panel(axes: Axes, log: FlightLog, column: int, title: str, label: str) -> None:
    """One input, held from command to command, between its bounds."""
    bounds = [log.input_lower[column], log.input_upper[column]]
    for bound in bounds:
        if np.isfinite(bound):
            axes.axhline(bound, **BOUND)
    axes.axhline(log.steady_inputs[column], **REFERENCE)
    if len(log.command_time):
        # The vehicle holds the last command until the record ends.
        end = max(time_limits(log)[1], log.command_time[-1])
        time = np.append(log.command_time, end)
        held = np.append(log.inputs[:, column], log.inputs[-1, column])
        axes.plot(time, held, color=BLUE, lw=1.2, drawstyle="steps-post")
    low, high = value_limits(log.inputs[:, column], log.steady_inputs[column], *bounds)
    finish(axes, title, label, low, high)


def _logarithmic(
    axes: Axes,
    log: FlightLog,
    values: NDArray[np.float64],
    title: str,
    label: str,
    marker: str = "",
) -> None:
    """What is positive of the values of each command, over whole decades, down to rounding."""
    axes.set_yscale("log")
    values = np.where(np.isfinite(values) & (values > 0.0), values, np.nan)[: len(log.command_time)]
    known = values[np.isfinite(values)]
    if len(known):
        top = np.ceil(np.log10(np.max(known)) + 1e-9)
        bottom = min(max(np.floor(np.log10(np.min(known))), top - DECADES), top - 1.0)
        style: dict[str, Any] = {"ls": "none", "marker": marker, "ms": 3.5} if marker else {}
        axes.plot(log.command_time[: len(values)], values, color=BLUE, **style)
        low, high = 10.0**bottom, 10.0**top
    else:
        axes.text(0.5, 0.5, "not recorded", transform=axes.transAxes, ha="center", color=GREY)
        low, high = 0.1, 10.0
    finish(axes, title, label, low, high)
    axes.yaxis.set_major_locator(LogLocator(numticks=5))
    axes.yaxis.set_minor_formatter(NullFormatter())


def _unwrapped(error: NDArray[np.float64]) -> NDArray[np.float64]:
    """Bearing error without jumps across +-pi, in (-pi, pi] at its last known sample."""
    known = np.isfinite(error)
    smooth = error.copy()
    if np.any(known):
        smooth[known] = np.unwrap(error[known])
        last = np.flatnonzero(known)[-1]
        smooth[known] += error[last] - smooth[last]
    return smooth


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
    return log.tracking is not None and log.tracking.terminal_constraint == ARTIFICIAL_ORBIT


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
        lowest = left[-1], right[-1], below
        _assemble(log, [*left, *right, below], lowest, "orbit asked for", "limit")
    return figure


def _limits(log: FlightLog, *names: str) -> list[float]:
    """Limits by which the controller planned; none where it knew none."""
    if log.tracking is None or not has_limits(log):
        return []
    return [getattr(log.tracking.envelope, name) for name in names]


def _span(values: NDArray[np.float64], form: str) -> str:
    """From the least to the greatest value in words; none where there is none."""
    known = values[np.isfinite(values)]
    return form.format(known.min(), known.max()) if len(known) else ""


def _bank_panel(axes: Axes, log: FlightLog) -> None:
    """Right wing down is positive; asked for is what the orbit needs without a drift."""
    turn_rate, _, _ = log.steady_inputs.tolist()
    asked = np.full(len(log.time), math.degrees(bank_from_turn_rate(turn_rate, log.orbit.speed)))
    bank, most, words = np.degrees(log.bank), np.degrees(_limits(log, "bank_max")), ""
    if len(most) and len(bank):
        largest = np.nanmax(np.abs(bank), initial=0.0)
        words = f"at most {largest:.0f}° of {most[0]:.0f}°"
    title, label = "Bank, right wing down", "bank [deg]"
    _limited_panel(axes, log, bank, asked, [*-most, *most], words, title, label)


def _airspeed_panel(axes: Axes, log: FlightLog) -> None:
    values, limits = log.vehicle[:, 5], _limits(log, "airspeed_min", "airspeed_max")
    asked, words = log.reference[:, COLUMNS["speed"]], _span(values, "{:.1f} to {:.1f} m/s")
    _limited_panel(axes, log, values, asked, limits, words, "Airspeed", "$v$ [m/s]")


def _path_angle_panel(axes: Axes, log: FlightLog) -> None:
    values = np.degrees(log.vehicle[:, 4])
    limits = np.degrees(_limits(log, "path_angle_min", "path_angle_max")).tolist()
    words, title = _span(values, "{:.1f}° to {:.1f}°"), "Path angle through the air"
    _limited_panel(axes, log, values, np.zeros(len(values)), limits, words, title, r"$\chi$ [deg]")


def _limited_panel(
    axes: Axes,
    log: FlightLog,
    values: NDArray[np.float64],
    asked: NDArray[np.float64],
    limits: Sequence[float],
    words: str,
    title: str,
    label: str,
) -> None:
    """A quantity, what is asked of it, its limits, and how far it came in words."""
    for limit in limits:
        axes.axhline(limit, **BOUND)
    axes.plot(log.time, asked, **REFERENCE)
    axes.plot(log.time, values, color=BLUE)
    _aside(axes, words)
    finish(axes, title, label, *value_limits(np.append(values, asked), *limits))


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
    if not np.any(speed > CALM):
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
        bar, row = (first, max(last - first, least)), rows.index(flown.mode)
        axes.broken_barh([bar], (row - 0.38, 0.76), color=MODES[flown.mode], lw=0.0)
    if log.modes:
        changes = sum(not each.mode.nominal for each in log.modes)
        times = "once" if changes == 1 else f"{changes} times"
        _aside(axes, f"fell back {times}" if changes else "never fell back")
    else:
        style: dict[str, Any] = {"ha": "center", "va": "center", "color": GREY}
        axes.text(0.5, 0.5, "not recorded", transform=axes.transAxes, **style)
    axes.set(title="Mode that was flown", ylim=(len(rows) - 0.4, -0.6))
    axes.set_yticks(range(len(rows)), [mode.value for mode in rows])
    axes.tick_params(axis="y", length=0)
    axes.grid(visible=False, axis="y")


def _aside(axes: Axes, words: str) -> None:
    axes.set_title(words, loc="right", fontsize=8, color=GREY)


def _inner_legend(axes: Axes) -> None:
    axes.legend(loc="upper right", ncols=2, fontsize=8, handlelength=1.4, borderpad=0.1)
