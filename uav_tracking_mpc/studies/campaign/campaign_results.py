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

"""The campaign as one object: what ``campaign.json`` holds."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

from uav_tracking_mpc.studies.campaign.campaign_run import CampaignResults
from uav_tracking_mpc.studies.campaign.criteria import RAISED
from uav_tracking_mpc.studies.campaign.failure_statistics import (
    QUANTILES,
    Failures,
    Trait,
    by,
    common_traits,
    quantiles,
    worst_first,
)
from uav_tracking_mpc.studies.campaign.flight_plan import flight_name
from uav_tracking_mpc.studies.campaign.one_flight import Row

# Heading, column, decimals.
FIGURES = (
    ("settled [s]", "settled_s", 1),
    ("range RMS [m]", "range_rms_m", 3),
    ("worst once settled [m]", "worst_settled_m", 2),
    ("airspeed RMS [m/s]", "airspeed_rms_mps", 2),
    ("bank rate RMS [deg/s]", "bank_rate_rms_dps", 2),
)
WORST = 10  # flights that can be looked at again
WORST_SHARE = 0.1  # of the flights, whose inputs are set beside those of the others


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


def replay_file(results: CampaignResults, row: Row) -> str:
    """Configuration with which ``simulate`` flies a flight again.

    Args:
        results: Of the flights.
        row: Of the flight.
    """
    return str(results.file.parent / "worst" / f"{flight_name(row['flight'], row['law'])}.yaml")


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
