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

"""Laws through scenarios or under mismatches: their flights as one object, as JSON, as a table."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import islice
from typing import Any

import numpy as np

from uav_tracking_mpc.control.guidance import nearest_direction
from uav_tracking_mpc.estimation.situation import Situation
from uav_tracking_mpc.report.metrics import microseconds
from uav_tracking_mpc.report.pages import Table
from uav_tracking_mpc.settings.configuration import Configuration
from uav_tracking_mpc.settings.tracking import NEAREST, PREDICTIVE
from uav_tracking_mpc.simulation.closed_loop import simulate
from uav_tracking_mpc.simulation.flight_log import FlightLog
from uav_tracking_mpc.simulation.motions import motion_of
from uav_tracking_mpc.simulation.plants.vehicle import VehiclePlant
from uav_tracking_mpc.studies.comparison.asked import Asked, Demand, asked_of
from uav_tracking_mpc.studies.comparison.measures import Measures, measures, worst
from uav_tracking_mpc.studies.comparison.scenarios import SETTLED_AFTER, law_labels, variants
from uav_tracking_mpc.studies.executors import parallel_map
from uav_tracking_mpc.studies.study import plain


@dataclass(frozen=True)
class Kind:
    """Whether laws fly through scenarios or under mismatches, and what is shown of the flights.

    Attributes:
        name: Of the files, without their ending.
        title: Of the page.
        flown: What each one is called.
        key: Of the flights in the JSON.
        asked: Of what is asked in the JSON.
        columns: Heading, name of the measure and number format of each column of the table.
        panels: Measures that the figure of all of them shows.
        caption: Of the table.
        demand: Words that are added where something is asked.
    """

    name: str
    title: str
    flown: str
    key: str
    asked: str
    columns: tuple[tuple[str, str, str], ...]
    panels: tuple[str, ...]
    caption: str
    demand: str

    def on(self, plant: str) -> Kind:
        """The same on a plant that is asked for: files and keys are named by it.

        Args:
            plant: Its name, or ``path.py:Class``.
        """
        label = plant.rpartition(":")[2]
        name, key = f"{self.name}_{label}", f"{self.key}_{label}"
        return replace(self, name=name, key=key, title=f"{self.title}, plant {label}")


RANGE_RMS = ("range RMS [m]", "range_rms_m", ".3f")
BANK_RATE_RMS = ("bank rate RMS [deg/s]", "bank_rate_rms_dps", ".2f")
VIOLATIONS = ("violations", "envelope_violations", "d")
SCENARIOS = Kind(
    name="compare",
    title="Guidance laws compared",
    flown="scenario",
    key="scenarios",
    asked="targets",
    columns=(
        RANGE_RMS,
        ("settling [s]", "settling_s", ".1f"),
        ("altitude RMS [m]", "altitude_rms_m", ".3f"),
        ("airspeed RMS [m/s]", "airspeed_rms_mps", ".3f"),
        BANK_RATE_RMS,
        VIOLATIONS,
    ),
    panels=("range_rms_m", "settling_s", "bank_rate_rms_dps"),
    caption="RMS over the last third of the flight; settling: time after which the range error "
    "stays below 10 m; violations: samples at which airspeed, path angle, bank, specific force, "
    "height or distance exceeds its limit by more than 1 %.",
    demand="asked: range RMS and settling time of nmpc, at most.",
)
MISTOLD = Kind(
    name="mismatches",
    title="Guidance laws under mismatch",
    flown="mismatch",
    key="mismatches",
    asked="asked",
    columns=(
        RANGE_RMS,
        ("mean [m]", "range_mean_m", ".3f"),
        ("worst [m]", "worst_m", ".2f"),
        BANK_RATE_RMS,
        ("swing [deg]", "swing_deg", ".1f"),
        VIOLATIONS,
        ("off plan", "off_plan", "d"),
    ),
    panels=("range_rms_m", "bank_rate_rms_dps"),
    caption="mean, worst: of the range error; swing: greatest difference of the bank from that of "
    "the orbit; off plan: commands that are neither an optimal plan nor the answer of the law; all "
    "but violations count from 90 s to the end. violations: samples of the whole flight at which "
    "airspeed, path angle, bank, specific force, height or distance exceeds its limit by more than "
    "1 %.",
    demand="asked: range RMS and bank rate RMS of nmpc, at most, in parentheses as shares of those "
    "of another flight.",
)
MOST_NEWS = 6  # of the sensors of one flight, that are shown
MISSING = {"settling_s": "never"}  # words for what a flight has no number for


@dataclass(frozen=True)
class Scenario:
    """All flights through one scenario, or under one mismatch.

    Attributes:
        name: Of the scenario's file, or of the mismatch.
        configuration: What was flown.
        flights: Of each law, by its label: one, or one of each variant.
        settled_after: Time in [s] from which on flights count; their last third by default.
        beside: Measures of the predictive controller under other mismatches, by their names.
    """

    name: str
    configuration: Configuration
    flights: Mapping[str, Sequence[FlightLog]]
    settled_after: float | None = None
    beside: Mapping[str, Measures] = field(default_factory=dict)

    @property
    def logs(self) -> dict[str, FlightLog]:
        """The first flight of each law, by its label."""
        return {law: logs[0] for law, logs in self.flights.items()}

    @cached_property
    def measures(self) -> dict[str, Measures]:
        """Of the flights, by the law's label: each figure of the flight in which it is worst."""
        limits, asked, after = self.configuration.controller, self.asked, self.settled_after
        shaken = isinstance(asked, Asked) and asked.shaken
        if after is not None and isinstance(asked, Asked) and asked.after is not None:
            after *= asked.after / SETTLED_AFTER
        return {
            law: worst([measures(log, limits, after, shaken) for log in logs])
            for law, logs in self.flights.items()
        }

    @property
    def not_flown(self) -> dict[str, str]:
        """Why, in words, of each law that answered no command: what flew was not the law."""
        words = {
            law: next(filter(None, (log.not_by_law for log in logs)), "")
            for law, logs in self.flights.items()
        }
        return {law: why for law, why in words.items() if why}

    @property
    def about(self) -> tuple[str, str]:
        """What people call it, and what happens in it."""
        about = self.configuration.scenario
        return (self.name, "") if about is None else (about.title or self.name, about.description)

    @property
    def asked(self) -> Demand | None:
        """What the predictive controller is to reach, if that is set."""
        return asked_of(self.configuration, self.name)

    @property
    def bounds(self) -> dict[str, Any]:
        """The figures that are asked, by the names of the measures; none without its flight."""
        asked = self.asked
        return asked.as_json(self.known) if asked and PREDICTIVE in self.flights else {}

    @property
    def missed(self) -> list[str]:
        """What it missed of that, in words."""
        return self.asked.missed(self.configuration, self.known) if self.asked else []

    @property
    def known(self) -> dict[str, Measures]:
        """The measures, and under a mismatch the predictive controller's under the others."""
        beside = self.beside if isinstance(self.asked, Asked) else {}
        return {**beside, **self.measures}


def compare(
    configurations: Mapping[str, Configuration],
    laws: Sequence[str],
    workers: int | None = None,
    show: bool = True,
    settled_after: float | None = None,
) -> list[Scenario]:
    """Fly laws through scenarios; the outcome depends on nothing but the arguments.

    Args:
        configurations: One of each scenario, by the scenario's name.
        laws: Names of laws, or ``path.py:Class``.
        workers: Processes; all cores by default.
        show: Progress bar on stderr.
        settled_after: Time in [s] from which on flights count; their last third by default.

    Returns:
        Those that were flown: where the user interrupted, those alone that every law had flown.

    Raises:
        ExtensionError: There is no such law.
        KeyboardInterrupt: The user interrupted before anything was whole.
        ParameterError: Two laws have one name.
        SimulationError: The target of a scenario was never seen.
    """
    labels = law_labels(laws)
    several = {name: variants(each, name) for name, each in configurations.items()}
    tasks = [(prepared(each, law),) for all in several.values() for law in laws for each in all]
    least = len(laws) * len(next(iter(several.values())))
    logs = parallel_map(simulate, tasks, workers, "flights", show, least)
    left, found = iter(logs), list[Scenario]()
    beside: dict[str, Measures] = {}
    for name, configuration in configurations.items():
        count = len(several[name])
        flights = {law: list(islice(left, count)) for law in labels}
        if len(flights[labels[-1]]) < count:
            break
        flown = Scenario(name, configuration, flights, settled_after, beside)
        found.append(flown)
        if PREDICTIVE in labels:
            beside[name] = flown.measures[PREDICTIVE]
    return found


def prepared(configuration: Configuration, law: str) -> Configuration:
    """The configuration with a law, and what all laws share: the direction.

    Args:
        configuration: Of a scenario.
        law: Name of a law, or ``path.py:Class``.
    """
    controller, direction = configuration.controller, configuration.controller.direction
    if direction == NEAREST:  # of the true start
        plant, still = VehiclePlant(configuration.simulator), np.zeros(3)
        motion = motion_of(configuration.target)
        drift, target = plant.wind - motion.velocity(0.0), motion.position(0.0)
        direction = nearest_direction(Situation(plant.state, target, drift, still, still))
    controller = dataclasses.replace(controller, law=law, direction=direction)
    # The aircraft, also where the mission is to fly the prediction model.
    mission = dataclasses.replace(configuration.mission, plant=configuration.simulator.plant)
    return dataclasses.replace(configuration, controller=controller, mission=mission)


def as_json(scenarios: Sequence[Scenario], kind: Kind = SCENARIOS) -> dict[str, Any]:
    """The comparison as plain values, never NaN.

    Args:
        scenarios: At least one, all of one configuration.
        kind: What they are.

    Returns:
        - ``config``
        - ``scenarios.<scenario>.<law>`` or ``mismatches.<mismatch>.<law>``: as :class:`Measures`;
          all but ``off_plan`` null where the law answered no command
        - ``targets.<scenario>``: ``range_rms_m``, ``settling_s`` and what was ``missed``, where
          targets are set and the predictive controller flew
        - ``asked.<mismatch>``: at most ``range_rms_m``, ``range_mean_m``, ``bank_rate_rms_dps``,
          ``envelope_violations`` and ``off_plan``, null where that is not asked; ``of_law``, the
          law whose figures range and bank rate are ``range_rms_share`` and ``bank_rate_rms_share``
          of, null where they are absolute; and what the predictive controller ``missed``
        - ``asked.<mismatch>`` where a sensor fails also: ``worst_m``, ``airspeed_worst_mps``,
          ``airspeed_min_mps``, ``airspeed_max_mps``, the sensor to be ``named`` and
          ``named_within_s``
        - ``solves.<scenario>`` or ``solves.<mismatch>``: of the predictive controller: ``count``,
          ``not_converged``, ``median_us``, ``p99_us``, ``max_us``
    """
    flown = [each for each in scenarios if PREDICTIVE in each.logs]
    numbers = {
        "config": scenarios[0].configuration.name,
        kind.key: {
            each.name: {law: _figures(each, law) for law in each.measures} for each in scenarios
        },
        kind.asked: {
            each.name: {**each.bounds, "missed": each.missed} for each in flown if each.bounds
        },
        "solves": {each.name: _solves(each.logs[PREDICTIVE]) for each in flown},
    }
    return dict(plain(numbers))


def _figures(scenario: Scenario, law: str) -> dict[str, Any]:
    """The measures of a law; those of another one, which flew in its place, are not its own."""
    figures = dataclasses.asdict(scenario.measures[law])
    if law in scenario.not_flown:
        return {**dict.fromkeys(figures), "off_plan": figures["off_plan"]}
    return figures


def _solves(log: FlightLog) -> dict[str, Any]:
    """How many solves a flight took, how many of them did not converge, and how long."""
    count = int(np.count_nonzero(np.isfinite(log.solve_time)))
    times = microseconds(log.solve_time) if count else {}
    return {"count": count, "not_converged": log.failures, **times}


def comparison_table(scenarios: Sequence[Scenario], kind: Kind = SCENARIOS) -> Table:
    """One row for every flight, with the verdict on those of the predictive controller.

    Args:
        scenarios: What was flown.
        kind: What they are.
    """
    headings = [heading for heading, *_ in kind.columns]
    last = ["asked", "verdict"] if any(each.asked is not None for each in scenarios) else []
    rows = [
        [
            each.name if index == 0 else "",
            law,
            *(_cell(each, law, name, form) for _, name, form in kind.columns),
            *(_verdict(each) if law == PREDICTIVE else ("", ""))[: len(last)],
        ]
        for each in scenarios
        for index, law in enumerate(each.measures)
    ]
    caption = f"{kind.caption} {kind.demand}" if last else kind.caption
    return Table([kind.flown, "law", *headings, *last], rows, headings, caption=caption)


def own_table(scenarios: Sequence[Scenario], kind: Kind = MISTOLD) -> Table:
    """The predictive controller's flights alone, one row each.

    Args:
        scenarios: What was flown.
        kind: What they are.
    """
    table = comparison_table(scenarios, kind)
    names = [each.name for each in scenarios if PREDICTIVE in each.measures]
    own = [cells for _, law, *cells in table.rows if law == PREDICTIVE]
    rows = [[name, *cells] for name, cells in zip(names, own, strict=True)]
    return replace(table, headings=[kind.flown, *table.headings[2:]], rows=rows)


def others_table(scenarios: Sequence[Scenario], kind: Kind = MISTOLD) -> Table:
    """Range RMS and bank rate RMS of all other laws, one row for all their flights in a scenario.

    Args:
        scenarios: What was flown, by the same laws.
        kind: What they are.
    """
    shown = {
        f"{law} [{unit}]": (law, name, form)
        for unit, (_, name, form) in (("m", RANGE_RMS), ("deg/s", BANK_RATE_RMS))
        for law in scenarios[0].measures
        if law != PREDICTIVE
    }
    rows = [
        [each.name, *(_cell(each, law, *column) for law, *column in shown.values())]
        for each in scenarios
    ]
    return Table([kind.flown, *shown], rows, numeric=[*shown])


def _cell(scenario: Scenario, law: str, name: str, form: str) -> str:
    if law in scenario.not_flown:
        return "\u2013"
    value = getattr(scenario.measures[law], name)
    return MISSING.get(name, "") if value is None else f"{value:{form}}"


def _verdict(scenario: Scenario) -> tuple[str, str]:
    """What is asked, and whether it is reached."""
    asked, known = scenario.asked, scenario.known
    if asked is None:
        return "", ""
    verdict = "missed" if scenario.missed else "reached"
    alone = isinstance(asked, Asked) and asked.relative and not asked.resolved(known).law
    if alone and verdict == "reached":
        verdict = "not compared"  # the law whose shares are asked for was not flown
    return asked.words(known), verdict


def news_of_sensors(scenarios: Sequence[Scenario]) -> list[str]:
    """What the predictive controller said of the sensors and when, one line a flight that has some.

    Args:
        scenarios: What was flown.
    """
    lines = []
    for scenario in scenarios:
        logs = scenario.flights.get(PREDICTIVE, ())
        for number, log in enumerate(logs, 1):
            said = [f"{news.sensor} {news.state} after {news.time:.1f} s" for news in log.sensors]
            if len(said) > MOST_NEWS:
                said[MOST_NEWS:] = [f"{len(said) - MOST_NEWS} more"]
            which = f", flight {number}" if len(logs) > 1 else ""
            lines += [f"{scenario.name}{which}: {', '.join(said)}"] if said else []
    return lines


def misses(scenarios: Sequence[Scenario]) -> list[str]:
    """What the predictive controller missed, one line each.

    Args:
        scenarios: What was flown.
    """
    return [f"{scenario.name}: {words}" for scenario in scenarios for words in scenario.missed]


def not_its_own(scenarios: Sequence[Scenario]) -> list[str]:
    """Which laws did not fly by themselves, one line a flight that counts others' commands.

    Args:
        scenarios: What was flown.
    """
    return [
        f"{scenario.name}: {law}: {scenario.not_flown[law]}"
        if law in scenario.not_flown
        else f"{scenario.name}: {flight.off_plan} commands that count were not by {law}, "
        "but by a fallback mode"
        for scenario in scenarios
        for law, flight in scenario.measures.items()
        if law in scenario.not_flown or (law != PREDICTIVE and flight.off_plan)
    ]
