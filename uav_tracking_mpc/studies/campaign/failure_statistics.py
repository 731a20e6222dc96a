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

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from uav_tracking_mpc.studies.campaign.one_flight import Row

CONFIDENCE = 0.95  # of each bound
FEWEST = 3  # flights of either kind; with fewer everything looks telling
TELLING = (
    0.05  # p-value below which a difference counts, times the number of inputs that were tried
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


QUANTILES = (0.5, 0.9, 0.99, 1.0)


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
