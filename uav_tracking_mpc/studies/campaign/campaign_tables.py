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

"""The tables of a campaign, for the terminal and for pages."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from uav_tracking_mpc.report.table import Table
from uav_tracking_mpc.studies.campaign.campaign_results import (
    FIGURES,
    failed_traits,
    reasons,
    replay_file,
    single_mistakes,
    swept_parts,
    worst_flights,
    worst_traits,
)
from uav_tracking_mpc.studies.campaign.campaign_run import CampaignResults
from uav_tracking_mpc.studies.campaign.failure_statistics import (
    QUANTILES,
    Failures,
    Trait,
    by,
    quantiles,
)
from uav_tracking_mpc.studies.campaign.one_flight import Row

BOUNDS = "95 % bounds [%]"
CAPTION = (
    "Bounds: Clopper and Pearson, each passed with a probability of 5 % at most, whatever the true "
    "probability is."
)


def failure_table(results: CampaignResults) -> Table:
    """How often flights failed: all of a law, then its parts.

    Args:
        results: Of the flights.
    """
    rows = []
    for law, flown in by(results.rows, "law").items():
        rows.append([law, "all", *_failure_cells(flown)])
        parts: dict[str, list[Row]] = dict(by(flown, "group"))
        if len(parts) < 2:
            parts = {}
        parts |= {f"- {name}": part for name, part in single_mistakes(flown).items()}
        for part in swept_parts(results, flown):
            values = (f"{key} = {_short(part[0][key])}" for key in results.campaign.swept)
            parts[", ".join(values)] = part
        rows += [["", name, *_failure_cells(part)] for name, part in parts.items()]
    headings = ("law", "flights", "number", "failed", "share [%]", BOUNDS, "reasons")
    return Table(headings, rows, numeric=headings[2:6], caption=CAPTION)


def _failure_cells(rows: Sequence[Row]) -> list[str]:
    counts = Failures.of(rows)
    lower, share, upper = (
        f"{100.0 * p:.2f}" for p in (counts.lower, counts.probability, counts.upper)
    )
    words = ", ".join(f"{name} {count}" for name, count in reasons(rows).items())
    return [str(counts.flights), str(counts.failures), share, f"{lower} to {upper}", words]


def quantile_table(results: CampaignResults) -> Table:
    """Quantiles of what counts, by law.

    Args:
        results: Of the flights.
    """
    names = ["median" if q == 0.5 else "worst" if q == 1.0 else f"{100 * q:g} %" for q in QUANTILES]
    rows = []
    for heading, column, decimals in FIGURES:
        for place, (law, flown) in enumerate(by(results.rows, "law").items()):
            cells = [
                "never" if value is None else f"{value:.{decimals}f}"
                for value in quantiles(flown, column)
            ]
            first = heading if place == 0 else ""
            rows.append([first, law, *cells])
    return Table(("", "law", *names), rows, numeric=names)


def trait_table(results: CampaignResults) -> Table:
    """What flights that failed have in common, and the tenth with the greatest range RMS.

    Args:
        results: Of the flights.
    """
    rows = []
    for law, flown in by(results.rows, "law").items():
        for words, traits in (
            ("failed", failed_traits(results, flown)),
            ("worst tenth in range RMS", worst_traits(results, flown)),
        ):
            rows += [[law, words, *_trait_cells(trait)] for trait in traits]
    headings = ("law", "flights", "have in common", "of them [%]", "of the others [%]", "p")
    return Table(headings, rows, numeric=headings[3:])


def _trait_cells(trait: Trait) -> list[str]:
    shares = (f"{100.0 * share:.0f}" for share in (trait.share, trait.others))
    return [f"{trait.input} {trait.rule}", *shares, f"{trait.p_value:.1g}"]


def worst_table(results: CampaignResults) -> Table:
    """The worst flights of the first law.

    Args:
        results: Of the flights.
    """
    rows = [
        [
            str(row["flight"]),
            row["mistake"] if "+" not in row["mistake"] else row["group"],
            "never" if row.get("worst_settled_m") is None else f"{row['worst_settled_m']:.1f}",
            row["error"] or row["reasons"] or "good",
            Path(replay_file(results, row)).name,
        ]
        for row in worst_flights(results)
    ]
    headings = ("flight", "errors", "worst once settled [m]", "failed by", "configuration")
    return Table(headings, rows, numeric=(headings[0], headings[2]))


def _short(value: float | str) -> str:
    return value if isinstance(value, str) else f"{value:.4g}"
