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

"""The comparison as one object: what ``compare.json`` holds."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.configuration import Configuration
from uav_tracking_mpc.settings.tracking import PREDICTIVE
from uav_tracking_mpc.simulation.flight_log import FlightLog
from uav_tracking_mpc.studies.comparison.flights import fly_all
from uav_tracking_mpc.studies.comparison.law_names import law_label
from uav_tracking_mpc.studies.comparison.measures import Measures, measures
from uav_tracking_mpc.studies.comparison.targets import Target, missed, target_of


@dataclass(frozen=True)
class Scenario:
    """All flights through one scenario.

    Attributes:
        name: Of its file.
        configuration: What was flown.
        logs: Flight of each law, by its label.
        measures: Of these flights.
    """

    name: str
    configuration: Configuration
    logs: Mapping[str, FlightLog]
    measures: Mapping[str, Measures]

    @property
    def title(self) -> str:
        """What people call it."""
        about = self.configuration.scenario
        return about.title if about is not None and about.title else self.name

    @property
    def description(self) -> str:
        """What happens in it."""
        about = self.configuration.scenario
        return "" if about is None else about.description

    @property
    def target(self) -> Target | None:
        """What the predictive controller is to reach, if that is set."""
        return target_of(self.configuration, self.name)

    @property
    def missed(self) -> list[str]:
        """What it missed of that, in words."""
        target = self.target
        return [] if target is None else missed(target, self.configuration, self.measures)


def compare(
    configurations: Mapping[str, Configuration],
    laws: Sequence[str],
    workers: int | None = None,
    show: bool = True,
    settled_after: float | None = None,
) -> list[Scenario]:
    """Fly laws through scenarios and measure the flights.

    Args:
        configurations: One of each scenario, by the scenario's name.
        laws: Names of laws, or ``path.py:Class``.
        workers: Processes; all cores by default.
        show: Progress bar on stderr.
        settled_after: Time in [s] from which on flights count; their last third by default.

    Returns:
        Those that were flown: fewer where the user interrupted.

    Raises:
        ExtensionError: There is no such law.
        SimulationError: The target of a scenario was never seen.
    """
    labels = [law_label(law) for law in laws]
    if len(set(labels)) < len(labels):
        raise ParameterError(f"laws are {', '.join(labels)}, each must have a name of its own")
    flights = fly_all(list(configurations.values()), laws, workers, show)
    return [
        scenario_of(name, configuration, labels, logs, settled_after)
        for (name, configuration), logs in zip(configurations.items(), flights, strict=False)
    ]


def scenario_of(
    name: str,
    configuration: Configuration,
    laws: Sequence[str],
    logs: Sequence[FlightLog],
    settled_after: float | None = None,
) -> Scenario:
    """Flights of each law through a scenario, measured.

    Args:
        name: Of the scenario.
        configuration: What was flown.
        laws: Labels of the laws.
        logs: Flight of each law.
        settled_after: Time in [s] from which on flights count; their last third by default.
    """
    flights = dict(zip(laws, logs, strict=True))
    limits = configuration.controller
    return Scenario(
        name=name,
        configuration=configuration,
        logs=flights,
        measures={law: measures(log, limits, settled_after) for law, log in flights.items()},
    )


def as_json(scenarios: Sequence[Scenario]) -> dict[str, Any]:
    """The comparison as plain values, never NaN.

    Args:
        scenarios: At least one, all of one configuration.

    Returns:
        - ``config``
        - ``scenarios.<scenario>.<law>``: as :class:`Measures`
        - ``targets.<scenario>``: ``range_rms_m``, ``settling_s`` and what was ``missed``, where
          targets are set and the predictive controller flew
        - ``solves.<scenario>``: of the predictive controller: ``count``, ``not_converged``,
          ``median_us``, ``p99_us``, ``max_us``
    """
    flown = [each for each in scenarios if PREDICTIVE in each.logs]
    numbers = {
        "config": scenarios[0].configuration.name,
        "scenarios": {
            each.name: {law: dataclasses.asdict(flight) for law, flight in each.measures.items()}
            for each in scenarios
        },
        "targets": {
            each.name: {
                "range_rms_m": each.target.range_rms,
                "settling_s": each.target.settling,
                "missed": each.missed,
            }
            for each in flown
            if each.target is not None
        },
        "solves": {each.name: solves(each.logs[PREDICTIVE]) for each in flown},
    }
    return finite(numbers)


def finite(numbers: dict[str, Any]) -> Any:
    """Plain values for JSON, with None for what is not finite.

    Args:
        numbers: Of any depth.
    """
    return json.loads(json.dumps(numbers), parse_constant=lambda _: None)


def solves(log: FlightLog) -> dict[str, Any]:
    """How many solves a flight took, how many of them did not converge, and how long.

    Args:
        log: A flight of the predictive controller.
    """
    times = 1e6 * log.solve_time[np.isfinite(log.solve_time)]
    numbers: dict[str, Any] = {"count": len(times), "not_converged": log.failures}
    if len(times):
        numbers["median_us"] = float(np.median(times))
        numbers["p99_us"] = float(np.percentile(times, 99.0))
        numbers["max_us"] = float(np.max(times))
    return numbers
