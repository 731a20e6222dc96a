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

"""The table of the comparison."""

from __future__ import annotations

from collections.abc import Sequence

from uav_tracking_mpc.report.table import Table
from uav_tracking_mpc.settings.tracking import PREDICTIVE
from uav_tracking_mpc.studies.comparison.measures import Measures
from uav_tracking_mpc.studies.comparison.results import Scenario

COLUMNS = (
    "range RMS [m]", "within 10 m [s]", "altitude RMS [m]", "airspeed RMS [m/s]",
    "bank rate RMS [deg/s]", "violations",
)  # fmt: skip
CAPTION = (
    "RMS over the last third of the flight; within 10 m: of the range, from then on; "
    "violations: samples at which airspeed, path angle, bank, specific force, height or "
    "distance is beyond its limit by more than 1 %; asked: range RMS and settling of nmpc."
)


def comparison_table(scenarios: Sequence[Scenario]) -> Table:
    """One row for every flight.

    Args:
        scenarios: What was flown.
    """
    return Table(
        headings=("scenario", "law", *COLUMNS, "asked", "verdict"),
        rows=comparison_rows(scenarios),
        numeric=(*COLUMNS, "asked"),
        caption=CAPTION,
    )


def comparison_rows(scenarios: Sequence[Scenario]) -> list[list[str]]:
    """Scenario (once), law, the numbers, what is asked and verdict (where set) of every flight.

    Args:
        scenarios: What was flown.
    """
    return [
        [
            scenario.name if index == 0 else "",
            law,
            *_numbers(flight),
            *(_verdict(scenario) if law == PREDICTIVE else ("", "")),
        ]
        for scenario in scenarios
        for index, (law, flight) in enumerate(scenario.measures.items())
    ]


def misses(scenarios: Sequence[Scenario]) -> list[str]:
    """What the predictive controller missed, one line each.

    Args:
        scenarios: What was flown.
    """
    return [f"{scenario.name}: {words}" for scenario in scenarios for words in scenario.missed]


def _numbers(flight: Measures) -> list[str]:
    return [
        f"{flight.range_rms_m:.3f}",
        "never" if flight.settling_s is None else f"{flight.settling_s:.1f}",
        f"{flight.altitude_rms_m:.3f}",
        f"{flight.airspeed_rms_mps:.3f}",
        f"{flight.bank_rate_rms_dps:.2f}",
        str(flight.envelope_violations),
    ]


def _verdict(scenario: Scenario) -> tuple[str, str]:
    if scenario.target is None:
        return "", ""
    asked = f"{scenario.target.range_rms:g} m, {scenario.target.settling:g} s"
    return asked, "missed" if scenario.missed else "reached"
