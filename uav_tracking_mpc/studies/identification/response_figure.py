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

"""Measured and fitted response of each channel, and what the fit leaves over."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from uav_tracking_mpc.report.atomic_write import write_atomically, write_json
from uav_tracking_mpc.report.figure_style import BLACK, BLUE, GREY, VERMILLION, drawing, save_figure
from uav_tracking_mpc.studies.identification.channel_record import PATH, SPEED, TURN
from uav_tracking_mpc.studies.identification.identification import ChannelIdentification

WIDTH, ROW_HEIGHT, ROOM = 9.5, 2.5, 0.8  # [inch]
SHOWN = 30.0  # s of the end of the flight
ANGLE = 180.0 / np.pi
# Title, unit of what was measured and of its rate, by what SI is multiplied for them.
PANELS = {
    TURN: ("Heading", "deg", "deg/s", ANGLE),
    PATH: ("Path angle", "deg", "deg/s", ANGLE),
    SPEED: ("Airspeed", "m/s", "m/s²", 1.0),
}


def response_figure(found: Sequence[ChannelIdentification]) -> Figure:
    """Left rates demanded and flown, right what was measured; both over the last 30 s.

    Args:
        found: Channels of a flight, at least one.
    """
    with drawing(WIDTH, ROW_HEIGHT * len(found) + ROOM) as figure:
        rows = figure.subplots(len(found), 2, sharex=True, squeeze=False)
        for (left, right), channel in zip(rows, found, strict=True):
            _rates(left, channel)
            _measured(right, channel)
        for axes in rows[-1]:
            axes.set_xlabel("time [s]")
        end = max(float(channel.fit.record.state.time[-1]) for channel in found)
        rows[0][0].set_xlim(end - SHOWN, end)
        handles, labels = rows[0][0].get_legend_handles_labels()
        more = rows[0][1].get_legend_handles_labels()
        figure.legend(handles + more[0], labels + more[1], loc="upper center", ncols=4)
        top = 1.0 - 0.6 * ROOM / (ROW_HEIGHT * len(found) + ROOM)
        figure.tight_layout(rect=(0.0, 0.0, 1.0, top))
    return figure


def write_identification(
    content: dict[str, Any], found: Sequence[ChannelIdentification], output: Path
) -> None:
    """Write ``identification.json``, ``identified.yaml`` and ``response.png``.

    Args:
        content: Plain values, with the YAML to paste.
        found: Channels of the flight.
        output: Folder, made if it is not there.
    """
    output.mkdir(parents=True, exist_ok=True)
    write_json(output / "identification.json", content)
    write_atomically(output / "identified.yaml", content["yaml"].encode())
    save_figure(response_figure(found), output / "response.png")


def _shown(channel: ChannelIdentification) -> NDArray[np.bool_]:
    time = channel.fit.record.state.time
    return time >= time[-1] - SHOWN


def _rates(axes: Axes, channel: ChannelIdentification) -> None:
    """Demand and fitted rate; the measured one where there is any."""
    title, _, unit, scale = PANELS[channel.name]
    record, shown = channel.fit.record, _shown(channel)
    begin = record.state.time[-1] - SHOWN
    demand = record.demand
    late = demand.time >= begin
    axes.step(
        demand.time[late], scale * demand.value[late], where="post", color=GREY, lw=0.8,
        label="commanded",
    )  # fmt: skip
    if record.rate is not None:
        late = record.rate.time >= begin
        rate = record.rate.time[late], scale * record.rate.value[late]
        axes.plot(*rate, ".", ms=2.5, color=BLUE, label="_measured")
    axes.plot(
        record.state.time[shown], scale * channel.fit.flown_rate()[shown], color=VERMILLION,
        label="fitted rate",
    )  # fmt: skip
    axes.set_title(f"{title}: its rate")
    axes.set_ylabel(f"[{unit}]")


def _measured(axes: Axes, channel: ChannelIdentification) -> None:
    """What was measured and what was fitted, less its mean slope."""
    title, unit, _, scale = PANELS[channel.name]
    record, shown = channel.fit.record, _shown(channel)
    time = record.state.time[shown]
    measured, fitted = record.state.value[shown], channel.fit.fitted()[shown]
    slope, level = np.polyfit(time - time[0], fitted, 1)
    trend = slope * (time - time[0]) + level
    axes.plot(time, scale * (measured - trend), ".", ms=2.5, color=BLUE, label="measured")
    axes.plot(time, scale * (fitted - trend), color=BLACK, lw=1.2, label="fitted")
    lag, dead_time, _, gain = channel.estimates
    axes.set_title(f"{title}, less its trend")
    axes.set_title(
        f"lag {lag.value:.2f} s, dead time {dead_time.value:.2f} s, gain {gain.value:.2f}",
        loc="right",
        fontsize=8,
        color=GREY,
    )
    axes.set_ylabel(f"[{unit}]")
