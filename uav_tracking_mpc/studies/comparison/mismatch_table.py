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

"""The table of the mismatches."""

from __future__ import annotations

import math
from collections.abc import Sequence

from uav_tracking_mpc.report.table import Table
from uav_tracking_mpc.settings.tracking import PREDICTIVE
from uav_tracking_mpc.studies.comparison.measures import Measures
from uav_tracking_mpc.studies.comparison.mismatch_targets import Asked, asked_of, missed, resolved
from uav_tracking_mpc.studies.comparison.results import Scenario

COLUMNS = (
    "range RMS [m]", "range mean [m]", "worst [m]", "bank rate RMS [deg/s]", "violations",
    "off plan",
)  # fmt: skip
CAPTION = (
    "Range errors and bank rate from 90 s to the end; violations: samples of the whole flight at "
    "which airspeed, path angle, bank, specific force, height or distance is beyond its limit by "
    "more than 1 %; off plan: commands from 90 s on that are neither an optimal plan nor the "
    "answer of the law; asked: range RMS and bank rate RMS of nmpc, in parentheses as shares of "
    "those of the better classical law."
)


def mismatch_table(mismatches: Sequence[Scenario]) -> Table:
    """One row for every flight.

    Args:
        mismatches: What was flown.
    """
    return Table(
        headings=("mismatch", "law", *COLUMNS, "asked", "verdict"),
        rows=[
            [
                mismatch.name if index == 0 else "",
                law,
                *_numbers(flight),
                *(_verdict(mismatch) if law == PREDICTIVE else ("", "")),
            ]
            for mismatch in mismatches
            for index, (law, flight) in enumerate(mismatch.measures.items())
        ],
        numeric=COLUMNS,
        caption=CAPTION,
    )


def mismatch_misses(mismatches: Sequence[Scenario]) -> list[str]:
    """What the predictive controller missed, one line each.

    Args:
        mismatches: What was flown.
    """
    return [
        f"{each.name}: {words}"
        for each in mismatches
        if (asked := asked_of(each.configuration, each.name)) is not None
        for words in missed(asked, each.measures)
    ]


def _numbers(flight: Measures) -> list[str]:
    return [
        f"{flight.range_rms_m:.3f}",
        f"{flight.range_mean_m:.3f}",
        f"{flight.worst_m:.2f}",
        f"{flight.bank_rate_rms_dps:.2f}",
        str(flight.envelope_violations),
        "" if flight.off_plan is None else str(flight.off_plan),
    ]


def _verdict(mismatch: Scenario) -> tuple[str, str]:
    asked = asked_of(mismatch.configuration, mismatch.name)
    if asked is None:
        return "", ""
    verdict = "missed" if missed(asked, mismatch.measures) else "reached"
    return _words(asked, resolved(asked, mismatch.measures)), verdict


def _words(asked: Asked, bounds: Asked) -> str:
    """For instance ``0.5 m, 3 deg/s``."""
    shares = f"({asked.range_rms:g}, {asked.bank_rate_rms:g} x {bounds.law or 'the better law'})"
    if asked.relative and not bounds.law:
        return shares
    words = f"{bounds.range_rms:.3g} m, {bounds.bank_rate_rms:.3g} deg/s"
    if asked.relative:
        words += f" {shares}"
    if math.isfinite(asked.range_mean):
        words += f", mean {asked.range_mean:g} m"
    return words
