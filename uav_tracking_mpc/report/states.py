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

"""States, inputs and cost over time, as Figure 3 of the paper and what it leaves out.

Left the five states with their references and the bands that count as settled, right the inputs
with their bounds and steady values, the optimal cost and the time that each solve took. All panels
share the time axis.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import LogLocator, NullFormatter
from numpy.typing import NDArray

from uav_tracking_mpc.report.figure_style import BLUE, GREY, VERMILLION, drawing
from uav_tracking_mpc.report.metrics import COLUMNS, settling_bands, settling_time
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
        _cost_panel(right[3], log)
        _solve_time_panel(right[4], log)
        for letter, axes in zip("abcdefghij", [*left, *right], strict=True):
            axes.set_title(f"({letter}) {axes.get_title(loc='left')}", loc="left")
        for axes in (left[-1], right[-1]):
            axes.set_xlabel("time [s]")
        share_time(axes, log)
        figure.subplots_adjust(
            left=0.075, right=0.985, bottom=0.06, top=0.925, hspace=0.34, wspace=0.2
        )
        figure.legend(
            handles=[
                Line2D([], [], color=BLUE, label="flight"),
                Line2D([], [], label="reference, steady input", **REFERENCE),
                Patch(label="settled", **BAND),
                Line2D([], [], label="bound", **BOUND),
            ],
            loc="upper center",
            ncols=4,
            columnspacing=2.5,
        )
    return figure


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
    axes.axhline(reference, **REFERENCE)
    if (asked != asked[:1]).any():
        axes.plot(log.time, asked, **REFERENCE)
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


def _cost_panel(axes: Axes, log: FlightLog) -> None:
    """Optimal cost, down to where rounding takes over."""
    cost = np.where(np.isfinite(log.cost) & (log.cost > 0.0), log.cost, np.nan)
    _logarithmic(axes, log.command_time, cost, "Optimal cost", "$V_N$ [-]", marker="")


def _solve_time_panel(axes: Axes, log: FlightLog) -> None:
    """Wall time of every solve."""
    time = 1e6 * np.where(log.solve_time > 0.0, log.solve_time, np.nan)
    count = min(len(time), len(log.command_time))
    _logarithmic(
        axes, log.command_time[:count], time[:count], "Solve time", "time [µs]", marker="."
    )


def _logarithmic(
    axes: Axes,
    time: NDArray[np.float64],
    values: NDArray[np.float64],
    title: str,
    label: str,
    marker: str,
) -> None:
    """Positive values, shape (m,), over whole decades."""
    axes.set_yscale("log")
    known = values[np.isfinite(values)]
    if len(known):
        top = np.ceil(np.log10(np.max(known)) + 1e-9)
        bottom = min(max(np.floor(np.log10(np.min(known))), top - DECADES), top - 1.0)
        style: dict[str, Any] = {"ls": "none", "marker": marker, "ms": 3.5} if marker else {}
        axes.plot(time, values, color=BLUE, **style)
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
