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

"""A campaign as a study: its picture, its page and the worst flights."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from uav_tracking_mpc.report.figure_style import BLACK, colours, drawing
from uav_tracking_mpc.report.pages import Table, render
from uav_tracking_mpc.studies.campaign.campaign_results import (
    Failures,
    as_json,
    by,
    failure_table,
    quantile_table,
    replay_file,
    single_mistakes,
    swept_parts,
    trait_table,
    worst_flights,
    worst_table,
)
from uav_tracking_mpc.studies.campaign.campaign_run import CampaignResults, Row
from uav_tracking_mpc.studies.campaign.flight_plan import planned
from uav_tracking_mpc.studies.study import Study

LINES = 16  # parts of the flights that panel (c) shows at most


def campaign_figure(results: CampaignResults) -> Figure:
    """Shares of flights beyond an error, and failure probabilities with their bounds.

    Args:
        results: Of the flights.
    """
    colour = colours(results.laws)
    with drawing(9.5, 3.9) as figure:
        grid = figure.add_gridspec(
            1, 4, width_ratios=(1.0, 1.0, 0.13, 1.0),
            left=0.065, right=0.985, bottom=0.13, top=0.92, wspace=0.25,
        )  # fmt: skip
        rms, worst, parts = (figure.add_subplot(grid[0, place]) for place in (0, 1, 3))
        for law, rows in by(results.rows, "law").items():
            _draw_beyond(rms, rows, "range_rms_m", law, colour[law])
            _draw_beyond(worst, rows, "worst_settled_m", law, colour[law])
        rms.set(xlabel="range RMS [m]", ylabel="share of flights beyond it")
        rms.set_title("(a) range RMS")
        rms.legend(loc="lower left")
        worst.axvline(results.campaign.failure.beyond, color=BLACK, lw=1.0, ls=(0, (5, 2.5)))
        worst.set(xlabel="greatest range error once settled [m]")
        worst.set_title("(b) worst error; dashed: lost")
        _draw_parts(parts, results, colour)
    return figure


def _draw_beyond(axes: Axes, rows: Sequence[Row], column: str, law: str, colour: str) -> None:
    """Share of the flights whose value is at least as large; those without one never end."""
    values = np.sort([row[column] for row in rows if row.get(column) is not None])
    shares = 1.0 - np.arange(len(values)) / len(rows)
    axes.step(np.maximum(values, 1e-4), shares, where="pre", color=colour, label=law)
    axes.set(xscale="log", yscale="log")
    axes.set_ylim(0.7 / len(rows), 1.3)


def _draw_parts(axes: Axes, results: CampaignResults, colour: dict[str, str]) -> None:
    """Failure probability of all flights of a law and of their parts, with 95 % bounds."""
    pitch = 0.7 / len(results.laws)
    for place, (law, rows) in enumerate(by(results.rows, "law").items()):
        parts = _parts(results, rows)
        for line, part in enumerate(parts.values()):
            counts, y = Failures.of(part), line + pitch * (place - 0.5 * (len(results.laws) - 1))
            ends = [100.0 * counts.lower, 100.0 * counts.upper]
            axes.plot(ends, [y] * 2, color=colour[law], lw=1.8)
            axes.plot(100.0 * counts.probability, y, "o", color=colour[law], ms=3.5)
        axes.set_yticks(range(len(parts)), list(parts))
    axes.tick_params(axis="y", labelsize=7.0)
    axes.invert_yaxis()
    axes.set(xlabel="flights that fail [%]")
    axes.set_xlim(left=0.0)
    axes.grid(axis="y", visible=False)
    axes.set_title("(c) failures, 95 % bounds")


def _parts(results: CampaignResults, rows: Sequence[Row]) -> dict[str, list[Row]]:
    """All flights of a law, groups, errors and swept values, as many as there is room for."""
    parts = {"all": list(rows)}
    if len(results.campaign.groups) > 1:
        parts |= by(rows, "group")
    parts |= single_mistakes(rows)
    for part in swept_parts(results, rows):
        values = (part[0][key] for key in results.campaign.swept)
        parts[", ".join(x if isinstance(x, str) else f"{x:.4g}" for x in values)] = part
    return dict(list(parts.items())[:LINES])


TEMPLATE = "campaign.html.j2"


def campaign_study(results: CampaignResults) -> Study:
    """The study: numbers, tables, picture, page, and the worst flights to be flown again.

    Args:
        results: Of the flights; the study belongs into the folder of their file.
    """
    campaign = results.campaign
    tables = {
        "failures": ("Failures", failure_table(results)),
        "quantiles": ("Quantiles", quantile_table(results)),
        "traits": ("What they have in common", trait_table(results)),
        "worst": ("The worst flights", worst_table(results)),
    }
    shown = {title: table for title, table in tables.values() if table.rows}
    words: list[str | Table] = list(shown.values())
    if results.flown:
        rate = 60.0 * results.flown / results.seconds / results.workers
        words.append(
            f"{results.flown} flights in {results.seconds:.0f} s: {rate:.0f} a minute and worker"
        )
    files = {}
    for row in worst_flights(results):
        configuration = planned(campaign, row["flight"]).configuration(campaign.laws[0])
        place = replay_file(results, row).relative_to(results.file.parent)
        files[str(place)] = configuration.yaml().encode()

    def page(pictures: Mapping[str, str]) -> str:
        return render(
            "uav_tracking_mpc.studies.campaign",
            TEMPLATE,
            {},
            title=campaign.title or campaign.name,
            description=campaign.description,
            picture=pictures["campaign"],
            tables=shown,
        )

    return Study(
        name="campaign",
        content=as_json(results),
        words=words,
        written="report: {}/campaign.html",
        figures={"campaign": partial(campaign_figure, results)},
        files=files,
        page=page,
        tables={name: table for name, (_, table) in tables.items()},
        left=f"{results.left} flights are left; the same command goes on with them"
        if results.left
        else "",
    )
