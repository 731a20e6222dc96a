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

"""The comparison as a study: a picture of each scenario, and one of all."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import partial
from itertools import cycle
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.markers import CARETLEFT, CARETRIGHT

from uav_tracking_mpc.report.figure_style import BLACK, GREEN, GREY, LIGHT_GREY, colours, drawing
from uav_tracking_mpc.report.metrics import COLUMNS, flown_bank
from uav_tracking_mpc.settings.tracking import PREDICTIVE
from uav_tracking_mpc.simulation.motions import motion_of
from uav_tracking_mpc.studies.comparison.measures import SETTLED
from uav_tracking_mpc.studies.comparison.results import (
    SCENARIOS,
    Kind,
    Scenario,
    as_json,
    comparison_table,
    misses,
    news_of_sensors,
    not_its_own,
    others_table,
    own_table,
)
from uav_tracking_mpc.studies.study import Study

SIZE = (9.5, 4.4)  # [inch]
FINEST = 1e-3  # m of range error, the least that is drawn


def scenario_figure(scenario: Scenario) -> Figure:
    """Path about the target, range error and bank of every law.

    Args:
        scenario: Flights of the same length.
    """
    colour = colours(scenario.logs)
    labels = {law: f"not by {law}" if law in scenario.not_flown else law for law in scenario.logs}
    with drawing(*SIZE) as figure:
        grid = figure.add_gridspec(2, 2, width_ratios=(1.0, 1.25))
        top_view = figure.add_subplot(grid[:, 0])
        error = figure.add_subplot(grid[0, 1])
        bank = figure.add_subplot(grid[1, 1], sharex=error)
        _draw_top_view(top_view, scenario, colour)
        _draw_error(error, scenario, colour)
        _draw_bank(bank, scenario, colour)
        figure.subplots_adjust(
            left=0.07, right=0.985, bottom=0.11, top=0.85, wspace=0.2, hspace=0.3
        )
        figure.suptitle(scenario.about[0], x=0.07, ha="left", fontsize=11)
        figure.legend(
            handles=[
                Line2D([], [], color=colour[law], label=words) for law, words in labels.items()
            ],
            loc="upper right",
            bbox_to_anchor=(0.99, 0.995),
            ncols=len(scenario.logs),
        )
    return figure


def _draw_top_view(axes: Axes, scenario: Scenario, colour: dict[str, str]) -> None:
    """North up, the target in the middle: paths are those relative to it."""
    log = next(iter(scenario.logs.values()))
    angle = np.linspace(0.0, 2.0 * np.pi, 181)
    radius = log.orbit.radius
    axes.plot(
        radius * np.cos(angle), radius * np.sin(angle),
        color=BLACK, lw=1.0, ls=(0, (5, 2.5)), zorder=3,
    )  # fmt: skip
    for law, flight in scenario.logs.items():
        x, y = (flight.vehicle[:, :2] - flight.target[:, :2]).T
        axes.plot(x, y, color=colour[law], lw=1.1)
        axes.plot(x[0], y[0], "s", color=BLACK, ms=4.5, zorder=4)
    axes.plot(0.0, 0.0, "*", color=BLACK, ms=9, zorder=4)
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.12)
    axes.set(
        xlabel="east of the target [m]",
        ylabel="north of the target [m]",
        title="(a) seen from the target",
    )
    moving = motion_of(scenario.configuration.target).velocity(0.0)
    wind = np.array(scenario.configuration.simulator.wind)
    gusts = " and gusts" if scenario.configuration.simulator.gust_intensity > 0.0 else ""
    turns = log.target_velocity is not None and np.ptp(log.target_velocity, axis=0).any()
    later = " at the start" if turns else ""
    for height, velocity, words, paint in (
        (0.94, wind, f"wind {np.hypot(*wind[:2]):g} m/s{gusts}", GREY),
        (0.86, moving, f"target {np.hypot(*moving[:2]):g} m/s{later}", BLACK),
    ):
        if not np.any(velocity[:2]):
            continue
        # In the upper left corner; length by speed, in axes that are nearly square.
        east, north = 0.005 * velocity[:2]
        axes.annotate(
            "", xy=(0.075 + east, height + north), xytext=(0.075 - east, height - north),
            xycoords="axes fraction", textcoords="axes fraction", zorder=5,
            arrowprops={"arrowstyle": "-|>", "color": paint, "lw": 1.8, "shrinkA": 0, "shrinkB": 0},
        )  # fmt: skip
        axes.text(
            0.14, height, words, transform=axes.transAxes, color=paint, fontsize=8, va="center",
            zorder=5, bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1.0},
        )  # fmt: skip


def _draw_error(axes: Axes, scenario: Scenario, colour: dict[str, str]) -> None:
    for law, log in scenario.logs.items():
        error = np.maximum(np.abs(log.error[:, COLUMNS["range"]]), FINEST)
        axes.semilogy(log.time, error, color=colour[law], lw=1.0)
    axes.axhspan(FINEST, SETTLED, color=GREEN, alpha=0.08, lw=0.0)
    end = log.time[-1]
    if "settling_s" in (asked := scenario.bounds):
        axes.plot([2.0 / 3.0 * end, end], [asked["range_rms_m"]] * 2, color=BLACK, lw=1.2)
        axes.plot(asked["settling_s"], SETTLED, "v", color=BLACK, ms=5)
    axes.set(
        ylabel="$|r - r_d|$ [m]",
        xlim=(0.0, end),
        ylim=(FINEST, None),
        title="(b) range error; shaded: settled, black: asked of nmpc (settling, RMS)",
    )


def _draw_bank(axes: Axes, scenario: Scenario, colour: dict[str, str]) -> None:
    limit = np.degrees(scenario.configuration.controller.bank_max)
    for law, log in scenario.logs.items():
        middle = 0.5 * (log.time[1:] + log.time[:-1])
        axes.plot(middle, np.degrees(flown_bank(log)), color=colour[law], lw=1.0)
    for bound in (-limit, limit):
        axes.axhline(bound, color=BLACK, lw=1.0, ls=(0, (1, 1.2)))
    axes.set(
        xlabel="time [s]",
        ylabel="bank [deg]",
        ylim=(-1.15 * limit, 1.15 * limit),
        title="(c) bank flown, right wing down; dotted: its limit",
    )


# Title of the panel of each measure, and the least that is drawn; 0 on a linear axis.
PANELS = {
    "range_rms_m": ("range RMS [m]", FINEST),
    "settling_s": ("settled within 10 m [s]", 0.0),
    "bank_rate_rms_dps": ("bank rate RMS [deg/s]", 0.1),
}
MARKERS = ("o", "s", "D", "^", "v", "P", "X")


def overview_figure(scenarios: Sequence[Scenario], kind: Kind = SCENARIOS) -> Figure:
    """A row for each scenario, a mark for each law, a bar where the predictive controller is asked.

    Args:
        scenarios: What was flown.
        kind: What they are.
    """
    height = 1.1 + 0.27 * max(len(scenarios), 2)  # [inch]
    colour = colours(law for each in scenarios for law in each.measures)
    marks: dict[str, dict[str, Any]] = {
        # The predictive controller's marks lie above the others.
        law: {"color": paint, "marker": marker, "zorder": 4 if law == PREDICTIVE else 3}
        for (law, paint), marker in zip(colour.items(), cycle(MARKERS), strict=False)
    }
    with drawing(SIZE[0], height) as figure:
        panels = figure.subplots(1, len(kind.panels), sharey=True)
        for axes, name in zip(panels, kind.panels, strict=True):
            title, least = PANELS[name]
            axes.set(title=title, xscale="log" if least else "linear")
            axes.grid(axis="y", color=LIGHT_GREY, lw=0.5)
            for index, each in enumerate(scenarios):
                for law, flight in each.measures.items():
                    if law in each.not_flown:
                        continue
                    _draw_mark(axes, index, getattr(flight, name), least, marks[law])
                bound = each.bounds.get(name)
                if bound is not None and math.isfinite(bound):
                    axes.plot([bound] * 2, [index - 0.36, index + 0.36], color=BLACK, lw=1.6)
            most = max(axes.get_xlim()[1], 12.0 * least)  # a decade at least: else labels overlap
            axes.set(xlim=(0.8 * least, most), ylim=(len(scenarios) - 0.5, -0.5))
        panels[0].set_yticks(range(len(scenarios)), [each.name for each in scenarios])
        marks["less than is drawn"] = {"color": BLACK, "marker": CARETLEFT}
        marks["never"] = {"color": BLACK, "marker": CARETRIGHT}
        marks["asked of nmpc"] = {"color": BLACK, "marker": "|", "ms": 9, "mew": 1.6}
        handles = [Line2D([], [], ls="", label=name, **mark) for name, mark in marks.items()]
        figure.subplots_adjust(
            left=0.15, right=0.985, bottom=0.4 / height, top=1.0 - 0.65 / height, wspace=0.06
        )
        figure.legend(handles=handles, loc="upper center", ncols=len(handles))
    return figure


def _draw_mark(
    axes: Axes, index: int, value: float | None, least: float, mark: Mapping[str, Any]
) -> None:
    """A measure of a flight; at the edge that it lies beyond where the axis does not show it."""
    edge = {"ls": "", "ms": 5.0, "mec": "white", "mew": 0.4, **mark}
    if value is None:
        edge |= {"marker": CARETRIGHT, "transform": axes.get_yaxis_transform()}
        axes.plot(0.985, index, **edge)
        return
    if value < least:
        edge["marker"] = CARETLEFT
    axes.plot(max(value, least), index, **edge)


def comparison(scenarios: Sequence[Scenario], kind: Kind = SCENARIOS, left: str = "") -> Study:
    """The study: numbers, table, pictures and a page that holds them.

    Args:
        scenarios: What was flown, at least one.
        kind: What they are.
        left: What was not flown, in words.
    """
    table, content = comparison_table(scenarios, kind), as_json(scenarios, kind)
    place = "comparison" if kind.name == SCENARIOS.name else kind.name  # in the documentation
    overview = kind.name
    figures, about, tables = {}, {}, {place: table}
    if kind.flown == SCENARIOS.flown:
        overview = "summary"
        figures = {each.name: partial(scenario_figure, each) for each in scenarios}
        about = {each.name: each.about for each in scenarios}
    else:
        tables = {place: own_table(scenarios, kind), f"{place}_laws": others_table(scenarios, kind)}
    return Study(
        name=kind.name,
        content=content,
        words=[
            table,
            *news_of_sensors(scenarios),
            *(f"missed, {line}" for line in misses(scenarios)),
            *not_its_own(scenarios),
        ],
        written=f"report: {{}}/{kind.name}.html",
        figures={overview: partial(overview_figure, scenarios, kind), **figures},
        title=f"{kind.title}: {content['config']}",
        about={overview: (f"Every law, every {kind.flown}", ""), **about},
        tables=tables,
        left=left,
    )
