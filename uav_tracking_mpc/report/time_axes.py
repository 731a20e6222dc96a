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

"""What panels over time share: their styles of lines, limits, titles and ticks."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator
from numpy.typing import ArrayLike

from uav_tracking_mpc.report.figure_style import BLACK, GREEN, VERMILLION
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
    axes.set_title(title, loc="left")
    axes.set_ylabel(label)
    axes.yaxis.set_label_coords(-0.1, 0.5)  # one line down the column, however long the numbers
    axes.set_ylim(low, high)
    if axes.get_yscale() == "linear":
        axes.yaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 2.5, 5, 10]))


def share_time(axes: Axes, log: FlightLog) -> None:
    """Limits and ticks of an axis of time.

    Args:
        axes: One of those that share it.
        log: Record of the flight.
    """
    axes.set_xlim(*time_limits(log))
    axes.xaxis.set_major_locator(MaxNLocator(8, steps=[1, 2, 2.5, 5, 10]))


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
