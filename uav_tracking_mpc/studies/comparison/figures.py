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

"""The comparison as a study: pictures of the scenarios, summaries, and the page of them."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.markers import CARETLEFT
from numpy.typing import NDArray

from uav_tracking_mpc.report.figure_style import BLACK, GREEN, GREY, LIGHT_GREY, colours, drawing
from uav_tracking_mpc.report.metrics import COLUMNS, flown_bank
from uav_tracking_mpc.report.pages import render
from uav_tracking_mpc.settings.tracking import PREDICTIVE
from uav_tracking_mpc.simulation.motions import motion_of
from uav_tracking_mpc.studies.comparison.asked import Asked, Target
from uav_tracking_mpc.studies.comparison.measures import SETTLED, Measures
from uav_tracking_mpc.studies.comparison.results import (
    SCENARIOS,
    Kind,
    Scenario,
    as_json,
    comparison_table,
    misses,
    news_of_sensors,
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
        figure.suptitle(scenario.title, x=0.07, ha="left", fontsize=11)
        figure.legend(
            handles=[Line2D([], [], color=colour[law], label=law) for law in scenario.logs],
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
    _draw_arrow(axes, 0.94, wind, f"wind {np.hypot(*wind[:2]):g} m/s{gusts}", GREY)
    turns = log.target_velocity is not None and np.ptp(log.target_velocity, axis=0).any()
    words = f"target {np.hypot(*moving[:2]):g} m/s{' at the start' if turns else ''}"
    _draw_arrow(axes, 0.86, moving, words, BLACK)


def _draw_arrow(
    axes: Axes, height: float, velocity: NDArray[np.float64], words: str, colour: str
) -> None:
    """A velocity in the upper left corner, if there is one."""
    speed = float(np.hypot(*velocity[:2]))
    if speed == 0.0:
        return
    # Length by speed, in axes that are nearly square.
    east, north = 0.005 * velocity[:2]
    axes.annotate(
        "", xy=(0.075 + east, height + north), xytext=(0.075 - east, height - north),
        xycoords="axes fraction", textcoords="axes fraction", zorder=5,
        arrowprops={"arrowstyle": "-|>", "color": colour, "lw": 1.8, "shrinkA": 0, "shrinkB": 0},
    )  # fmt: skip
    axes.text(
        0.14, height, words, transform=axes.transAxes, color=colour, fontsize=8, va="center",
        zorder=5, bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1.0},
    )  # fmt: skip


def _draw_error(axes: Axes, scenario: Scenario, colour: dict[str, str]) -> None:
    for law, log in scenario.logs.items():
        error = np.maximum(np.abs(log.error[:, COLUMNS["range"]]), FINEST)
        axes.semilogy(log.time, error, color=colour[law], lw=1.0)
    axes.axhspan(FINEST, SETTLED, color=GREEN, alpha=0.08, lw=0.0)
    end = log.time[-1]
    if isinstance(scenario.asked, Target):
        axes.plot([2.0 / 3.0 * end, end], [scenario.asked.range_rms] * 2, color=BLACK, lw=1.2)
        axes.plot(scenario.asked.settling, SETTLED, "v", color=BLACK, ms=5)
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


def summary_figure(scenarios: Sequence[Scenario]) -> Figure:
    """Range RMS, settling and bank rate of every law in every scenario, and what is asked.

    Args:
        scenarios: What was flown.
    """
    height = 0.9 + 0.55 * max(len(scenarios), 2)  # [inch]
    colour = colours(law for scenario in scenarios for law in scenario.logs)
    with drawing(9.5, height) as figure:
        panels = figure.subplots(1, 3, sharey=True)
        panels[0].set_xscale("log")
        for axes, (title, value) in zip(panels, PANELS, strict=True):
            _draw_bars(axes, scenarios, value, colour)
            axes.set_title(title)
            axes.grid(axis="y", visible=False)
        panels[0].set_xlim(left=FINEST)
        panels[0].set_yticks(range(len(scenarios)), [scenario.name for scenario in scenarios])
        panels[0].invert_yaxis()
        for index, scenario in enumerate(scenarios):
            if isinstance(scenario.asked, Target):
                for axes, bound in zip(
                    panels, (scenario.asked.range_rms, scenario.asked.settling), strict=False
                ):
                    axes.plot([bound] * 2, [index - 0.42, index + 0.42], color=BLACK, lw=1.8)
        handles = [Line2D([], [], color=paint, lw=6, label=law) for law, paint in colour.items()]
        if any(isinstance(scenario.asked, Target) for scenario in scenarios):
            handles.append(Line2D([], [], color=BLACK, lw=1.8, label="asked of nmpc"))
        figure.subplots_adjust(
            left=0.13, right=0.985, bottom=0.35 / height, top=1.0 - 0.6 / height, wspace=0.08
        )
        figure.legend(handles=handles, loc="upper center", ncols=len(handles))
    return figure


PANELS: tuple[tuple[str, Callable[[Measures], float | None]], ...] = (
    ("range RMS, last third [m]", lambda flight: flight.range_rms_m),
    ("settled within 10 m [s]", lambda flight: flight.settling_s),
    ("bank rate RMS, last third [deg/s]", lambda flight: flight.bank_rate_rms_dps),
)


def _draw_bars(
    axes: Axes,
    scenarios: Sequence[Scenario],
    value: Callable[[Measures], float | None],
    colour: dict[str, str],
) -> None:
    for index, scenario in enumerate(scenarios):
        count = len(scenario.measures)
        pitch = 0.78 / max(count, 3)
        for place, (law, flight) in enumerate(scenario.measures.items()):
            y, length = index + pitch * (place - 0.5 * (count - 1)), value(flight)
            # A bar has no length where the logarithmic axis begins, and less before.
            clipped = length is not None and axes.get_xscale() == "log" and length < FINEST
            if length is None or clipped:
                words = f"< {FINEST:g}" if clipped else "never"
                axes.text(
                    0.01, y, words, transform=axes.get_yaxis_transform(), va="center",
                    color=colour[law], fontsize=7,
                )  # fmt: skip
            else:
                axes.barh(y, length, height=0.88 * pitch, color=colour[law])
        if index:
            axes.axhline(index - 0.5, color=LIGHT_GREY, lw=0.6)


LEAST = (1e-3, 0.1)  # m and deg/s, the least that is drawn
MARKERS = ("o", "s", "D", "^", "v", "P", "X")


def mismatch_figure(mismatches: Sequence[Scenario]) -> Figure:
    """A row for each mismatch, a mark for each law, a bar where the predictive controller is asked.

    Args:
        mismatches: What was flown.
    """
    height = 1.1 + 0.27 * max(len(mismatches), 2)  # [inch]
    laws = list(dict.fromkeys(law for mismatch in mismatches for law in mismatch.measures))
    colour = colours(laws)
    marker = {law: MARKERS[index % len(MARKERS)] for index, law in enumerate(laws)}
    # The predictive controller's marks lie above the others.
    order = {law: 4 if law == PREDICTIVE else 3 for law in laws}
    with drawing(9.5, height) as figure:
        panels = figure.subplots(1, 2, sharey=True)
        for index, mismatch in enumerate(mismatches):
            for law, flight in mismatch.measures.items():
                for axes, value, finest in zip(
                    panels, (flight.range_rms_m, flight.bank_rate_rms_dps), LEAST, strict=True
                ):
                    axes.plot(
                        max(value, finest), index, ls="", color=colour[law], ms=5.0,
                        marker=marker[law] if value >= finest else CARETLEFT,
                        mec="white", mew=0.4, zorder=order[law],
                    )  # fmt: skip
            asked = mismatch.asked
            if not isinstance(asked, Asked) or PREDICTIVE not in mismatch.measures:
                continue
            bounds = asked.resolved(mismatch.known)
            for axes, bound in zip(panels, (bounds.range_rms, bounds.bank_rate_rms), strict=True):
                if math.isfinite(bound):
                    axes.plot([bound] * 2, [index - 0.36, index + 0.36], color=BLACK, lw=1.6)
        for axes, title, finest in zip(
            panels, ("range RMS [m]", "bank rate RMS [deg/s]"), LEAST, strict=True
        ):
            axes.set(xscale="log", xlim=(0.8 * finest, None), title=title)
            axes.grid(axis="y", color=LIGHT_GREY, lw=0.5)
        panels[0].set_yticks(range(len(mismatches)), [mismatch.name for mismatch in mismatches])
        panels[0].set_ylim(len(mismatches) - 0.5, -0.5)
        handles = [
            Line2D([], [], color=colour[law], marker=marker[law], ls="", label=law) for law in laws
        ]
        less = f"below {LEAST[0]:g} m or {LEAST[1]:g} deg/s"
        handles.append(Line2D([], [], color=BLACK, marker=CARETLEFT, ls="", label=less))
        handles.append(
            Line2D([], [], color=BLACK, marker="|", ls="", ms=9, mew=1.6, label="asked of nmpc")
        )
        figure.subplots_adjust(
            left=0.15, right=0.985, bottom=0.4 / height, top=1.0 - 0.65 / height, wspace=0.06
        )
        figure.legend(handles=handles, loc="upper center", ncols=len(handles))
    return figure


TEMPLATE = "comparison.html.j2"
SEEN = "Paths about the target, range error and bank"
ALTERNATIVES = {
    "summary": "Range RMS, settling time and bank rate of every law in every scenario",
    "mismatches": "Range and bank rate RMS of every law under every mismatch",
}


def comparison(scenarios: Sequence[Scenario], kind: Kind = SCENARIOS, left: str = "") -> Study:
    """The study: numbers, table, pictures and a page that holds them.

    Args:
        scenarios: What was flown, at least one.
        kind: What they are.
        left: What was not flown, in words.
    """
    table, content = comparison_table(scenarios, kind), as_json(scenarios, kind)
    missed, news = misses(scenarios), news_of_sensors(scenarios)
    place = "comparison" if kind.name == SCENARIOS.name else kind.name  # in the documentation
    if kind.flown == SCENARIOS.flown:
        figures = {"summary": partial(summary_figure, scenarios)}
        figures |= {each.name: partial(scenario_figure, each) for each in scenarios}
        tables = {place: table}
    else:
        figures = {kind.name: partial(mismatch_figure, scenarios)}
        tables = {place: own_table(scenarios, kind), f"{place}_laws": others_table(scenarios, kind)}
    about = {
        each.name: {"title": each.title, "description": each.description} for each in scenarios
    }

    def page(pictures: Mapping[str, str]) -> str:
        sections = [
            {
                "picture": picture,
                "alternative": ALTERNATIVES.get(name.partition("_")[0], SEEN),
                **about.get(name, {"title": "", "description": ""}),
            }
            for name, picture in pictures.items()
        ]
        return render(
            "uav_tracking_mpc.studies.comparison",
            TEMPLATE,
            {},
            title=f"{kind.title}: {content['config']}",
            table=table,
            own=PREDICTIVE,
            misses=missed,
            news=news,
            sections=sections,
        )

    return Study(
        name=kind.name,
        content=content,
        words=[table, *news, *(f"missed, {line}" for line in missed)],
        written=f"report: {{}}/{kind.name}.html",
        figures=figures,
        page=page,
        tables=tables,
        left=left,
    )
