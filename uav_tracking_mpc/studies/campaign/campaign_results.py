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

r"""How often flights fail, how sure that is, what those that fail have in common: as a study.

The bounds are those of C. J. Clopper, E. S. Pearson, "The use of confidence or fiducial limits
illustrated in the case of the binomial", Biometrika 26 (1934): with k failures of n flights, each
bound is passed with a probability of at most 1 - 95 %, whatever the true probability is,

.. math:: p_{upper} = B^{-1}(0.95;\, k + 1,\, n - k),\qquad
          p_{lower} = B^{-1}(0.05;\, k,\, n - k + 1)

where :math:`B^{-1}` is the quantile of the beta distribution.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy import stats

from uav_tracking_mpc.report.figure_style import BLACK, colours, drawing
from uav_tracking_mpc.report.pages import Table, render
from uav_tracking_mpc.studies.campaign.campaign_file import RAISED
from uav_tracking_mpc.studies.campaign.campaign_run import (
    CampaignResults,
    Row,
    flight_name,
    planned,
)
from uav_tracking_mpc.studies.study import Study

CONFIDENCE = 0.95  # -, confidence of each bound
FEWEST = 3  # flights of either kind; with fewer everything looks telling
TELLING = (
    0.05  # -, p-value below which a difference counts, times the number of inputs that were tried
)


def failures(rows: Sequence[Row]) -> dict[str, Any]:
    """How often flights failed: counts, their probability and its bounds at 95 % [-]."""
    return bounds(len(rows), sum(row["failed"] for row in rows))


def bounds(flights: int, failed: int) -> dict[str, Any]:
    """The probability of a failure with so many of so many flights, and its bounds [-]."""
    good, beta = flights - failed, stats.beta
    return {
        "flights": flights,
        "failures": failed,
        "probability": failed / flights,
        "lower": float(beta.ppf(1.0 - CONFIDENCE, failed, good + 1)) if failed else 0.0,
        "upper": float(beta.ppf(CONFIDENCE, failed + 1, good)) if good else 1.0,
    }


def by(rows: Sequence[Row], column: str) -> dict[Any, list[Row]]:
    """Rows by the value of a column, in the order of their first."""
    parts: dict[Any, list[Row]] = {}
    for row in rows:
        parts.setdefault(row[column], []).append(row)
    return parts


# What some flights have more often than others: key of the ``input``; the ``rule``, such as
# ``> 7.1`` or ``= zigzag``; the ``share`` that it holds for [-], also of the ``others``;
# ``p_value``, the probability of such a difference by chance, times the inputs tried [-].
Trait = dict[str, Any]


def common_traits(
    rows: Sequence[Row], inputs: Sequence[str], chosen: Callable[[Row], bool]
) -> list[Trait]:
    """What the chosen flights have in common, the most telling first.

    For numbers, the rule is where the two distributions differ most, which is what the two-sample
    test of Kolmogorov and Smirnov looks at; for words, the value whose share differs most, with
    Fisher's exact test.

    Args:
        rows: Of flights.
        inputs: Columns that may tell.
        chosen: Whether a flight is one of those in question.
    """
    picked = np.array([chosen(row) for row in rows], dtype=bool)
    if min(picked.sum(), (~picked).sum()) < FEWEST:
        return []
    traits = []
    for key in inputs:
        values = [row[key] for row in rows]
        if len(set(values)) < 2:
            continue
        words = isinstance(values[0], str)
        rule_of = _of_words if words else _of_numbers
        traits.append(rule_of(key, np.array(values, dtype=object if words else float), picked))
    for trait in traits:
        trait["p_value"] = min(1.0, len(traits) * trait["p_value"])
    telling = [trait for trait in traits if trait["p_value"] < TELLING]
    return sorted(telling, key=lambda trait: trait["others"] - trait["share"])


def _of_numbers(key: str, values: NDArray[Any], picked: NDArray[np.bool_]) -> Trait:
    test = stats.ks_2samp(values[picked], values[~picked])
    place = float(test.statistic_location)
    above = values > place
    # Where fewer of them lie below the place, more lie above it.
    if test.statistic_sign < 0:
        return _trait(key, f"> {place:.4g}", above, picked, float(test.pvalue))
    return _trait(key, f"<= {place:.4g}", ~above, picked, float(test.pvalue))


def _of_words(key: str, values: NDArray[Any], picked: NDArray[np.bool_]) -> Trait:
    traits = []
    for value in dict.fromkeys(values.tolist()):
        has = values == value
        counts = [[np.sum(has & side), np.sum(~has & side)] for side in (picked, ~picked)]
        p_value = float(stats.fisher_exact(counts).pvalue)
        traits.append(_trait(key, f"= {value}", has, picked, p_value))
    return max(traits, key=lambda trait: trait["share"] - trait["others"])


def _trait(
    key: str, rule: str, has: NDArray[np.bool_], picked: NDArray[np.bool_], p_value: float
) -> Trait:
    share, others = float(has[picked].mean()), float(has[~picked].mean())
    return {"input": key, "rule": rule, "share": share, "others": others, "p_value": p_value}


QUANTILES = (0.5, 0.9, 0.99, 1.0)  # -, quantiles


def quantiles(rows: Sequence[Row], column: str) -> list[float | None]:
    """Values of a column that shares of :data:`QUANTILES` of the flights do not exceed.

    A flight without a value, such as one that never settled, is worse than all others: None.
    """
    values = [np.inf if row.get(column) is None else row[column] for row in rows]
    # The smallest value that enough flights do not exceed: it is one that was flown.
    found = np.quantile(values, QUANTILES, method="inverted_cdf")
    return [float(value) if np.isfinite(value) else None for value in found]


def worst_first(rows: Sequence[Row]) -> list[Row]:
    """Flights by how bad they are: those that failed, then by range error."""

    def badness(row: Row) -> tuple[bool, bool, float, int]:
        worst = row.get("worst_settled_m")
        return row["failed"], worst is None, worst or 0.0, -row["flight"]

    return sorted(rows, key=badness, reverse=True)


# Heading, column, decimals.
FIGURES = (
    ("settled [s]", "settled_s", 1),
    ("range RMS [m]", "range_rms_m", 3),
    ("worst settled error [m]", "worst_settled_m", 2),
    ("airspeed RMS [m/s]", "airspeed_rms_mps", 2),
    ("bank rate RMS [deg/s]", "bank_rate_rms_dps", 2),
)
WORST = 10  # flights that can be looked at again
WORST_SHARE = 0.1  # -, of the flights, whose inputs are set beside those of the others


def as_json(results: CampaignResults) -> dict[str, Any]:
    """The campaign as plain values, never NaN.

    Args:
        results: Of the flights.

    Returns:
        - ``campaign``, ``config``, ``file``, ``flights``, ``flown``, ``seconds``, ``workers``
        - ``laws.<law>``: ``flights``, ``failures``, ``probability``, ``lower``, ``upper`` (each
          bound at 95 %), ``reasons``, ``errors``, ``quantiles``, ``groups.<group>``,
          ``mistakes.<mistake>``, ``swept``, ``failed_have_in_common``, ``worst_have_in_common``
        - ``worst``: ``flight``, ``law``, ``reasons``, ``error``, ``worst_settled_m``, ``replay``
    """
    campaign = results.campaign
    return {
        "campaign": campaign.name,
        "config": campaign.base.name,
        "file": str(results.file),
        "flights": len(results.rows),
        "flown": results.flown,
        "seconds": round(results.seconds, 3),
        "workers": results.workers,
        "laws": {law: _law(results, rows) for law, rows in by(results.rows, "law").items()},
        "worst": [
            {
                **{key: row.get(key) for key in WORST_KEYS},
                "replay": f"uav_tracking simulate --config {replay_file(results, row)}",
            }
            for row in worst_flights(results)
        ],
    }


WORST_KEYS = ("flight", "law", "group", "mistake", "reasons", "error", "worst_settled_m")


def worst_flights(results: CampaignResults) -> list[Row]:
    """The worst ten of the first law."""
    return worst_first([row for row in results.rows if row["law"] == results.laws[0]])[:WORST]


def replay_file(results: CampaignResults, row: Row) -> Path:
    """Configuration with which ``simulate`` flies a flight again."""
    return results.file.parent / "worst" / f"{flight_name(row['flight'], row['law'])}.yaml"


def _law(results: CampaignResults, rows: Sequence[Row]) -> dict[str, Any]:
    sweeps = results.campaign.swept
    return {
        **failures(rows),
        "reasons": reasons(rows),
        "errors": sorted({row["error"] for row in rows if row["error"]}),
        "quantiles": {
            column: dict(zip(map(str, QUANTILES), quantiles(rows, column), strict=True))
            for _, column, _ in FIGURES
        },
        "groups": {group: failures(part) for group, part in by(rows, "group").items()},
        "mistakes": {name: failures(part) for name, part in single_mistakes(rows).items()},
        "swept": [
            {**{key: part[0][key] for key in sweeps}, **failures(part)}
            for part in swept_parts(results, rows)
        ],
        "failed_have_in_common": failed_traits(results, rows),
        "worst_have_in_common": worst_traits(results, rows),
    }


def reasons(rows: Sequence[Row]) -> dict[str, int]:
    """How many flights failed by each condition; some by several."""
    found = [each for row in rows for each in row["reasons"].split(",") if each]
    return {name: found.count(name) for name in sorted(set(found))}


def single_mistakes(rows: Sequence[Row]) -> dict[str, list[Row]]:
    """Flights with one error at a time, by the error."""
    alone = [row for row in rows if row["mistake"] and "+" not in row["mistake"]]
    return by(alone, "mistake")


def swept_parts(results: CampaignResults, rows: Sequence[Row]) -> list[list[Row]]:
    """Flights by combination of swept values; none where nothing is swept."""
    if not results.campaign.swept:
        return []
    size = results.campaign.flights
    return [list(rows[begin : begin + size]) for begin in range(0, len(rows), size)]


def failed_traits(results: CampaignResults, rows: Sequence[Row]) -> list[Trait]:
    """What the flights that failed have in common."""
    return common_traits(rows, _telling(results), lambda row: row["failed"])


def worst_traits(results: CampaignResults, rows: Sequence[Row]) -> list[Trait]:
    """What the tenth with the greatest range RMS has in common."""
    flown = [row for row in rows if row["reasons"] != RAISED and row["range_rms_m"] is not None]
    ranked = sorted((row["range_rms_m"] for row in flown), reverse=True)
    if not ranked:
        return []
    bound = ranked[int(WORST_SHARE * (len(ranked) - 1))]
    return common_traits(flown, _telling(results), lambda row: row["range_rms_m"] >= bound)


def _telling(results: CampaignResults) -> list[str]:
    return ["group", "mistake", *results.campaign.inputs]


BOUNDS = "95 % bounds [%]"
CAPTION = (
    "Bounds: Clopper and Pearson; each is passed in at most 5 % of campaigns, whatever the true "
    "probability is."
)


def failure_table(results: CampaignResults) -> Table:
    """How often flights failed: all of a law, then its parts."""
    rows = []
    for law, flown in by(results.rows, "law").items():
        rows.append([law, "all", *_failure_cells(flown)])
        parts = _parts(results, flown, "- ", lambda key, value: f"{key} = {value}")
        rows += [["", name, *_failure_cells(part)] for name, part in parts.items()]
    headings = ("law", "group", "flights", "failed", "failed [%]", BOUNDS, "reasons")
    return Table(headings, rows, numeric=headings[2:6], caption=CAPTION)


def _parts(
    results: CampaignResults, rows: Sequence[Row], mark: str, name: Callable[[str, str], str]
) -> dict[str, list[Row]]:
    """Flights of a law by group, where there are some; by single error; by swept values."""
    groups = by(rows, "group")
    parts: dict[str, list[Row]] = dict(groups) if len(groups) > 1 else {}
    parts |= {f"{mark}{error}": part for error, part in single_mistakes(rows).items()}
    for part in swept_parts(results, rows):
        values = (name(key, _short(part[0][key])) for key in results.campaign.swept)
        parts[", ".join(values)] = part
    return parts


def _failure_cells(rows: Sequence[Row]) -> list[str]:
    counts = failures(rows)
    lower, share, upper = (f"{100.0 * counts[p]:.2f}" for p in ("lower", "probability", "upper"))
    words = ", ".join(f"{name} {count}" for name, count in reasons(rows).items())
    return [str(counts["flights"]), str(counts["failures"]), share, f"{lower} to {upper}", words]


def quantile_table(results: CampaignResults) -> Table:
    """Quantiles of what counts, by law."""
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
    return Table(("figure", "law", *names), rows, numeric=names)


def trait_table(results: CampaignResults) -> Table:
    """What flights that failed have in common, and the tenth with the greatest range RMS."""
    rows = []
    for law, flown in by(results.rows, "law").items():
        for words, traits in (
            ("failed", failed_traits(results, flown)),
            ("worst tenth", worst_traits(results, flown)),
        ):
            rows += [
                [
                    law,
                    words,
                    f"{trait['input']} {trait['rule']}".replace("+", " + "),
                    *(f"{100.0 * trait[share]:.0f}" for share in ("share", "others")),
                    f"{trait['p_value']:.1g}",
                ]
                for trait in traits
            ]
    headings = ("law", "flights", "property", "share here [%]", "elsewhere [%]", "p")
    return Table(headings, rows, numeric=headings[3:])


def worst_table(results: CampaignResults) -> Table:
    """The worst flights of the first law."""
    rows = [
        [
            str(row["flight"]),
            row["mistake"] if "+" not in row["mistake"] else row["group"],
            "never" if row.get("worst_settled_m") is None else f"{row['worst_settled_m']:.1f}",
            row["error"] or row["reasons"] or "passed",
            replay_file(results, row).name,
        ]
        for row in worst_flights(results)
    ]
    headings = ("flight", "errors", "worst error [m]", "outcome", "configuration")
    return Table(headings, rows, numeric=(headings[0], headings[2]))


def _short(value: float | str) -> str:
    return value if isinstance(value, str) else f"{value:.4g}"


LINES = 16  # parts of the flights that panel (c) shows at most


def campaign_figure(results: CampaignResults) -> Figure:
    """Shares of flights beyond an error, and failure probabilities with their bounds."""
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
        rms.set(xlabel="range RMS [m]", ylabel="share of flights beyond it", title="(a) range RMS")
        rms.legend(loc="lower left")
        worst.axvline(results.campaign.failure.beyond, color=BLACK, lw=1.0, ls=(0, (5, 2.5)))
        worst.set(
            xlabel="greatest range error once settled [m]", title="(b) worst error; dashed: lost"
        )
        _draw_parts(parts, results, colour)
    return figure


def _draw_beyond(axes: Axes, rows: Sequence[Row], column: str, law: str, colour: str) -> None:
    """Share of the flights whose value is at least as large; those without one never end."""
    values = np.sort([row[column] for row in rows if row.get(column) is not None])
    shares = 1.0 - np.arange(len(values)) / len(rows)
    axes.step(np.maximum(values, 1e-4), shares, where="pre", color=colour, label=law)
    axes.set(xscale="log", yscale="log", ylim=(0.7 / len(rows), 1.3))


def _draw_parts(axes: Axes, results: CampaignResults, colour: dict[str, str]) -> None:
    """Failure probability of all flights of a law and of their parts, with 95 % bounds."""
    pitch = 0.7 / len(results.laws)
    for place, (law, rows) in enumerate(by(results.rows, "law").items()):
        parts = {"all": list(rows), **_parts(results, rows, "", lambda _, value: value)}
        parts = dict(islice(parts.items(), LINES))
        for line, part in enumerate(parts.values()):
            y = line + pitch * (place - 0.5 * (len(results.laws) - 1))
            counts = failures(part)
            lower, share, upper = (100.0 * counts[p] for p in ("lower", "probability", "upper"))
            axes.plot([lower, upper], [y] * 2, color=colour[law], lw=1.8)
            axes.plot(share, y, "o", color=colour[law], ms=3.5)
        axes.set_yticks(range(len(parts)), list(parts))
    axes.tick_params(axis="y", labelsize=7.0)
    axes.invert_yaxis()
    axes.set(xlabel="flights that fail [%]", title="(c) failures, 95 % bounds", xlim=(0.0, None))
    axes.grid(axis="y", visible=False)


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
        "traits": ("Common properties", trait_table(results)),
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
