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
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter
from numpy.typing import NDArray
from scipy import stats

from uav_tracking_mpc.report.figure_style import BLACK, colours, drawing
from uav_tracking_mpc.report.pages import Table
from uav_tracking_mpc.studies.campaign.campaign_file import RAISED
from uav_tracking_mpc.studies.campaign.campaign_run import (
    CampaignResults,
    Row,
    flight_name,
    planned,
)
from uav_tracking_mpc.studies.study import Study, plain

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
    return list(plain(np.quantile(values, QUANTILES, method="inverted_cdf").tolist()))


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
    campaign, parts = results.campaign, by(results.rows, "law")
    folder = results.file.parent / "worst"
    worst = worst_first(parts.get(results.laws[0], []))[:WORST]
    return {
        "campaign": campaign.name,
        "config": campaign.base.name,
        "file": str(results.file),
        "flights": len(results.rows),
        "flown": results.flown,
        "seconds": round(results.seconds, 3),
        "workers": results.workers,
        "laws": {law: _law(results, rows) for law, rows in parts.items()},
        # Of the first law, each with the configuration with which it flies again.
        "worst": [
            {
                **{key: row.get(key) for key in WORST_KEYS},
                "replay": "uav_tracking simulate --config "
                f"{folder / flight_name(row['flight'], row['law'])}.yaml",
            }
            for row in worst
        ],
    }


WORST_KEYS = ("flight", "law", "group", "mistake", "reasons", "error", "worst_settled_m")


def _law(results: CampaignResults, rows: Sequence[Row]) -> dict[str, Any]:
    sweeps, telling = results.campaign.swept, ["group", "mistake", *results.campaign.inputs]
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
        "failed_have_in_common": common_traits(rows, telling, lambda row: row["failed"]),
        "worst_have_in_common": worst_traits(rows, telling),
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
    parts: dict[int, list[Row]] = {}
    for row in rows:  # some are missing where the campaign was interrupted
        parts.setdefault(row["flight"] // size, []).append(row)
    return list(parts.values())


def worst_traits(rows: Sequence[Row], inputs: Sequence[str]) -> list[Trait]:
    """What the tenth with the greatest range RMS has in common."""
    flown = [row for row in rows if row["reasons"] != RAISED and row["range_rms_m"] is not None]
    if not flown:
        return []
    ranked = sorted((row["range_rms_m"] for row in flown), reverse=True)
    bound = ranked[int(WORST_SHARE * (len(ranked) - 1))]
    return common_traits(flown, inputs, lambda row: row["range_rms_m"] >= bound)


BOUNDS = "95 % bounds [%]"
CAPTION = (
    "Bounds: Clopper and Pearson; each is passed in at most 5 % of campaigns, whatever the true "
    "probability is."
)
REPLAY = (
    "The folder worst beside this page holds a configuration of each: uav_tracking simulate "
    "--config FOLDER/worst/flight_….yaml flies it again, bit for bit."
)


def failure_table(results: CampaignResults) -> Table:
    """How often flights failed: all of a law, then its parts."""
    rows = []
    for law, flown in by(results.rows, "law").items():
        parts = _parts(results, flown, "- ", lambda key, value: f"{key} = {value}")
        for name, part in {"all": flown, **parts}.items():
            counts = failures(part)
            lower, share, upper = (
                f"{100.0 * counts[p]:.2f}" for p in ("lower", "probability", "upper")
            )
            rows.append(
                [
                    law if name == "all" else "",
                    name,
                    str(counts["flights"]),
                    str(counts["failures"]),
                    share,
                    f"{lower} to {upper}",
                    ", ".join(f"{reason} {count}" for reason, count in reasons(part).items()),
                ]
            )
    headings = ("law", "group", "flights", "failed", "failed [%]", BOUNDS, "reasons")
    return Table(headings, rows, numeric=headings[2:6], title="Failures", caption=CAPTION)


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


def quantile_table(laws: Mapping[str, Any]) -> Table:
    """Quantiles of what counts, by law, from the JSON."""
    names = ["median" if q == 0.5 else "worst" if q == 1.0 else f"{100 * q:g} %" for q in QUANTILES]
    rows = [
        [
            heading if place == 0 else "",
            law,
            *(
                "never" if value is None else f"{value:.{decimals}f}"
                for value in found["quantiles"][column].values()
            ),
        ]
        for heading, column, decimals in FIGURES
        for place, (law, found) in enumerate(laws.items())
    ]
    return Table(("figure", "law", *names), rows, numeric=names, title="Quantiles")


def trait_table(laws: Mapping[str, Any]) -> Table:
    """What flights that failed have in common, and the tenth with the worst RMS, from the JSON."""
    rows = [
        [
            law,
            words,
            f"{trait['input']} {_told_apart(trait['rule'])}",
            *(f"{100.0 * trait[share]:.0f}" for share in ("share", "others")),
            f"{trait['p_value']:.1g}",
        ]
        for law, found in laws.items()
        for words, key in (("failed", "failed"), ("worst tenth", "worst"))
        for trait in found[f"{key}_have_in_common"]
    ]
    headings = ("law", "flights", "property", "share here [%]", "elsewhere [%]", "p")
    return Table(headings, rows, numeric=headings[3:], title="Common properties")


def _told_apart(rule: str) -> str:
    """A rule with room between the errors that came together; a number keeps its exponent."""
    return rule.replace("+", " + ") if rule.startswith("= ") else rule


def worst_table(worst: Sequence[Mapping[str, Any]]) -> Table:
    """The worst flights of the first law, from the JSON."""
    rows = [
        [
            str(row["flight"]),
            row["mistake"] if "+" not in row["mistake"] else row["group"],
            "never" if row["worst_settled_m"] is None else f"{row['worst_settled_m']:.1f}",
            row["error"] or row["reasons"] or "passed",
            Path(row["replay"]).name,
        ]
        for row in worst
    ]
    headings = ("flight", "errors", "worst error [m]", "outcome", "configuration")
    numeric = (headings[0], headings[2])
    return Table(headings, rows, numeric, title="The worst flights", caption=REPLAY)


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
    axes.yaxis.set_minor_formatter(NullFormatter())  # of few flights they push the label out


def _draw_parts(axes: Axes, results: CampaignResults, colour: dict[str, str]) -> None:
    """Failure probability of all flights of a law and of their parts, with 95 % bounds."""
    pitch = 0.7 / len(results.laws)
    for place, (law, rows) in enumerate(by(results.rows, "law").items()):
        parts = {"all": list(rows), **_parts(results, rows, "", lambda _, value: value)}
        names = list(parts)[:LINES]
        for line, part in enumerate(parts[name] for name in names):
            y = line + pitch * (place - 0.5 * (len(results.laws) - 1))
            counts = failures(part)
            lower, share, upper = (100.0 * counts[p] for p in ("lower", "probability", "upper"))
            axes.plot([lower, upper], [y] * 2, color=colour[law], lw=1.8)
            axes.plot(share, y, "o", color=colour[law], ms=3.5)
        axes.set_yticks(range(len(names)), names)
    axes.tick_params(axis="y", labelsize=7.0)
    axes.invert_yaxis()
    axes.set(xlabel="flights that fail [%]", title="(c) failures, 95 % bounds", xlim=(0.0, None))
    axes.grid(axis="y", visible=False)


def campaign_study(results: CampaignResults) -> Study:
    """The study: numbers, tables, picture, page, and the worst flights to be flown again.

    Args:
        results: Of the flights; the study belongs into the folder of their file.
    """
    campaign, content = results.campaign, as_json(results)
    tables = {
        "failures": failure_table(results),
        "quantiles": quantile_table(content["laws"]),
        "traits": trait_table(content["laws"]),
        "worst": worst_table(content["worst"]),
    }
    words: list[str | Table] = [table for table in tables.values() if table.rows]
    for law, rows in by(results.rows, "law").items():
        fallen = sum(bool(row.get("off_plan")) for row in rows)
        words += [f"{law}: in {fallen} flights a fallback mode flew at times"] if fallen else []
    if results.flown:
        rate = 60.0 * results.flown / results.seconds / results.workers
        words.append(
            f"{results.flown} flights in {results.seconds:.0f} s: {rate:.0f} a minute and worker"
        )
    files = {
        f"worst/{flight_name(row['flight'], row['law'])}.yaml": planned(campaign, row["flight"])
        .configuration(campaign.laws[0])
        .yaml()
        .encode()
        for row in content["worst"]
    }
    left = f"{results.left} flights are left; the same command goes on with them"
    return Study(
        name="campaign",
        content=content,
        words=words,
        written="report: {}/campaign.html",
        title=campaign.title or campaign.name,
        description=campaign.description,
        figures={"campaign": partial(campaign_figure, results)},
        about={"campaign": ("Shares of flights beyond an error, and failure probabilities", "")},
        files=files,
        tables=tables,
        left=left if results.left else "",
    )
