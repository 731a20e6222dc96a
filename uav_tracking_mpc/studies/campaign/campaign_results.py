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

r"""How often flights fail, how sure that is, and what those that fail have in common.

The bounds are those of C. J. Clopper, E. S. Pearson, "The use of confidence or fiducial limits
illustrated in the case of the binomial", Biometrika 26 (1934): with k failures of n flights, each
bound is passed with a probability of at most 1 - 95 %, whatever the true probability is,

.. math:: p_{upper} = B^{-1}(0.95;\, k + 1,\, n - k),\qquad
          p_{lower} = B^{-1}(0.05;\, k,\, n - k + 1)

where :math:`B^{-1}` is the quantile of the beta distribution.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from uav_tracking_mpc.report.pages import Table
from uav_tracking_mpc.studies.campaign.campaign_run import CampaignResults, Row
from uav_tracking_mpc.studies.campaign.criteria import RAISED
from uav_tracking_mpc.studies.campaign.flight_plan import flight_name

CONFIDENCE = 0.95  # -, confidence of each bound
FEWEST = 3  # flights of either kind; with fewer everything looks telling
TELLING = (
    0.05  # -, p-value below which a difference counts, times the number of inputs that were tried
)


@dataclass(frozen=True)
class Failures:
    """How often flights failed.

    Attributes:
        flights: How many there were.
        failures: How many of them failed.
    """

    flights: int
    failures: int

    @classmethod
    def of(cls, rows: Sequence[Row]) -> Failures:
        """Count.

        Args:
            rows: Of flights.
        """
        return cls(len(rows), sum(row["failed"] for row in rows))

    @property
    def probability(self) -> float:
        """Share that failed [-]."""
        return self.failures / self.flights

    @property
    def lower(self) -> float:
        """Lower bound of the probability at 95 % [-]."""
        if self.failures == 0:
            return 0.0
        good = self.flights - self.failures
        return float(stats.beta.ppf(1.0 - CONFIDENCE, self.failures, good + 1))

    @property
    def upper(self) -> float:
        """Upper bound of the probability at 95 % [-]."""
        good = self.flights - self.failures
        if good == 0:
            return 1.0
        return float(stats.beta.ppf(CONFIDENCE, self.failures + 1, good))


def by(rows: Sequence[Row], column: str) -> dict[Any, list[Row]]:
    """Rows by the value of a column, in the order of their first.

    Args:
        rows: Of flights.
        column: Name of the column.
    """
    parts: dict[Any, list[Row]] = {}
    for row in rows:
        parts.setdefault(row[column], []).append(row)
    return parts


@dataclass(frozen=True)
class Trait:
    """What some flights have more often than others: a rule, and how well it tells them apart.

    Attributes:
        input: Key of the input.
        rule: Such as ``> 7.1``, or ``= zigzag``.
        share: Of the flights in question that it holds for [-].
        others: Of the others [-].
        p_value: Probability of such a difference by chance, times the inputs tried, at most 1 [-].
    """

    input: str
    rule: str
    share: float
    others: float
    p_value: float


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
        trait = _of_words if words else _of_numbers
        traits.append(trait(key, np.array(values, dtype=object if words else float), picked))
    tried = len(traits)
    corrected = [
        Trait(t.input, t.rule, t.share, t.others, min(1.0, tried * t.p_value)) for t in traits
    ]
    telling = [trait for trait in corrected if trait.p_value < TELLING]
    return sorted(telling, key=lambda trait: trait.others - trait.share)


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
    return max(traits, key=lambda trait: trait.share - trait.others)


def _trait(
    key: str, rule: str, has: NDArray[np.bool_], picked: NDArray[np.bool_], p_value: float
) -> Trait:
    return Trait(key, rule, float(has[picked].mean()), float(has[~picked].mean()), p_value)


QUANTILES = (0.5, 0.9, 0.99, 1.0)  # -, quantiles


def quantiles(rows: Sequence[Row], column: str) -> list[float | None]:
    """Values that shares of :data:`QUANTILES` of the flights do not exceed.

    A flight without a value, such as one that never settled, is worse than all others: None.

    Args:
        rows: Of flights.
        column: Name of the column.
    """
    values = [np.inf if row.get(column) is None else row[column] for row in rows]
    # The smallest value that enough flights do not exceed: it is one that was flown.
    found = np.quantile(values, QUANTILES, method="inverted_cdf")
    return [float(value) if np.isfinite(value) else None for value in found]


def worst_first(rows: Sequence[Row]) -> list[Row]:
    """Flights by how bad they are: those that failed, then by range error.

    Args:
        rows: Of flights.
    """

    def badness(row: Row) -> tuple[bool, bool, float, int]:
        worst = row.get("worst_settled_m")
        return row["failed"], worst is None, worst or 0.0, -row["flight"]

    return sorted(rows, key=badness, reverse=True)


# Heading, column, decimals.
FIGURES = (
    ("settled [s]", "settled_s", 1),
    ("range RMS [m]", "range_rms_m", 3),
    ("worst once settled [m]", "worst_settled_m", 2),
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
    """The worst ten of the first law.

    Args:
        results: Of the flights.
    """
    return worst_first([row for row in results.rows if row["law"] == results.laws[0]])[:WORST]


def replay_file(results: CampaignResults, row: Row) -> Path:
    """Configuration with which ``simulate`` flies a flight again.

    Args:
        results: Of the flights.
        row: Of the flight.
    """
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
        "failed_have_in_common": [dataclasses.asdict(t) for t in failed_traits(results, rows)],
        "worst_have_in_common": [dataclasses.asdict(t) for t in worst_traits(results, rows)],
    }


def failures(rows: Sequence[Row]) -> dict[str, Any]:
    """How often flights failed, as plain values.

    Args:
        rows: Of flights, at least one.
    """
    counts = Failures.of(rows)
    return {
        **dataclasses.asdict(counts),
        **{name: getattr(counts, name) for name in ("probability", "lower", "upper")},
    }


def reasons(rows: Sequence[Row]) -> dict[str, int]:
    """How many flights failed by each condition; some by several.

    Args:
        rows: Of flights.
    """
    found = [each for row in rows for each in row["reasons"].split(",") if each]
    return {name: found.count(name) for name in sorted(set(found))}


def single_mistakes(rows: Sequence[Row]) -> dict[str, list[Row]]:
    """Flights with one error at a time, by the error.

    Args:
        rows: Of flights.
    """
    alone = [row for row in rows if row["mistake"] and "+" not in row["mistake"]]
    return by(alone, "mistake")


def swept_parts(results: CampaignResults, rows: Sequence[Row]) -> list[list[Row]]:
    """Flights by combination of swept values; none where nothing is swept.

    Args:
        results: Of the flights.
        rows: Of one law.
    """
    if not results.campaign.swept:
        return []
    size = results.campaign.flights
    return [list(rows[begin : begin + size]) for begin in range(0, len(rows), size)]


def failed_traits(results: CampaignResults, rows: Sequence[Row]) -> list[Trait]:
    """What the flights that failed have in common.

    Args:
        results: Of the flights.
        rows: Of one law.
    """
    return common_traits(rows, _telling(results), lambda row: row["failed"])


def worst_traits(results: CampaignResults, rows: Sequence[Row]) -> list[Trait]:
    """What the tenth with the greatest range RMS has in common.

    Args:
        results: Of the flights.
        rows: Of one law.
    """
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
            replay_file(results, row).name,
        ]
        for row in worst_flights(results)
    ]
    headings = ("flight", "errors", "worst once settled [m]", "failed by", "configuration")
    return Table(headings, rows, numeric=(headings[0], headings[2]))


def _short(value: float | str) -> str:
    return value if isinstance(value, str) else f"{value:.4g}"
