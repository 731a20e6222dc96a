"""The picture of a campaign: how large errors get, and how often flights fail."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from uav_tracking_mpc.report.figure_style import BLACK, colours, drawing
from uav_tracking_mpc.studies.campaign.campaign_results import single_mistakes, swept_parts
from uav_tracking_mpc.studies.campaign.campaign_run import CampaignResults
from uav_tracking_mpc.studies.campaign.failure_statistics import Failures, by
from uav_tracking_mpc.studies.campaign.one_flight import Row

LINES = 14  # parts of the flights that panel (c) shows at most


def campaign_figure(results: CampaignResults) -> Figure:
    """Shares of flights beyond an error, and failure probabilities with their bounds.

    Args:
        results: Of the flights.
    """
    colour = colours(results.laws)
    with drawing(9.5, 3.9) as figure:
        rms, worst, parts = figure.subplots(1, 3, width_ratios=(1.0, 1.0, 1.15))
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
        figure.subplots_adjust(left=0.065, right=0.985, bottom=0.13, top=0.92, wspace=0.32)
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
    names: list[str] = []
    for law, rows in by(results.rows, "law").items():
        lines = {"all": list(rows)} | (
            by(rows, "group") if len(results.campaign.groups) > 1 else {}
        )
        lines |= single_mistakes(rows)
        swept = list(results.campaign.swept)
        for part in swept_parts(results, rows):
            lines[", ".join(f"{part[0][key]:.3g}" for key in swept if key in part[0])] = part
        for name, part in list(lines.items())[:LINES]:
            counts = Failures.of(part)
            ends = [100.0 * counts.lower, 100.0 * counts.upper]
            axes.plot(ends, [len(names)] * 2, color=colour[law], lw=2.0)
            axes.plot(100.0 * counts.probability, len(names), "o", color=colour[law], ms=4.5)
            names.append(name if len(results.laws) == 1 else f"{law}: {name}")
    axes.set_yticks(range(len(names)), names)
    axes.tick_params(axis="y", labelsize=6.5)
    axes.set_ylim(len(names) - 0.5, -0.5)
    axes.set(xlabel="flights that fail [%]")
    axes.set_xlim(left=0.0)
    axes.grid(axis="y", visible=False)
    axes.set_title("(c) failures, 95 % bounds")
