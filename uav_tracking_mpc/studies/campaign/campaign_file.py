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

"""The YAML that describes a campaign, checked: what is flown, what is drawn, what is a failure.

A value is drawn by

================  ================================================================
``3.0``           always this
``uniform``       [least, greatest]
``log_uniform``   [least, greatest], both positive, uniform in the logarithm
``normal``        [mean, standard deviation]
``choice``        one of the list, all alike
``values``        swept: each of the list in turn
``grid``          swept: [first, last, how many], evenly spaced
================  ================================================================

for a parameter, a component of it, or something handier:

===================================  ==========================================================
``uav_simulator.gust_intensity``     a parameter; a number fills all components of a list
``uav_simulator.rate_lag[0]``        a component
``uav_simulator.heading_bias_deg``   an angle or turn rate, in degrees
``wind.speed``                       what ``uncertain_inputs.DERIVED`` lists
===================================  ==========================================================

A flight has failed by conditions on its true trajectory, or by raising an error:

==================  =====================================================================
``orbit_lost``      settled, then further from the range than it may be
``never_settled``   never inside that range error for as long as it takes to count
``limit_passed``    a limit passed by more than a share of its bound
==================  =====================================================================
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc import __version__
from uav_tracking_mpc.limits import LIMIT
from uav_tracking_mpc.parameters.specification import (
    ParameterError,
    Parameters,
    Specification,
    from_mapping,
    is_number,
    parameter,
)
from uav_tracking_mpc.settings.configuration import (
    Configuration,
    configuration_folder,
    found,
    load_configuration,
    read_value,
    read_yaml,
)
from uav_tracking_mpc.settings.tracking import PREDICTIVE, TrackingParameters
from uav_tracking_mpc.simulation.flight_log import FlightLog
from uav_tracking_mpc.studies.campaign.uncertain_inputs import check_value, is_whole_list, read
from uav_tracking_mpc.studies.comparison.measures import violations

CONSTANT, CHOICE, SWEPT, GRID = "constant", "choice", "values", "grid"
# What distributions of numbers take: whether they are right, and how they must be.
NUMBERS: dict[str, tuple[Callable[..., bool], str]] = {
    "uniform": (lambda least, most: least <= most, "least and greatest in order"),
    "log_uniform": (
        lambda least, most: 0.0 < least <= most, "positive, least and greatest in order"
    ),
    "normal": (lambda mean, spread: spread >= 0.0, "mean and a standard deviation of at least 0"),
    GRID: (
        lambda first, last, count: isinstance(count, int) and count > 0, "first, last and how many"
    ),
}  # fmt: skip
KINDS = {"uniform": 2, "log_uniform": 2, "normal": 2, CHOICE: 0, SWEPT: 0, GRID: 3}  # arguments
# How a value is drawn from the arguments; of all other kinds it is the first of them.
DRAWING: dict[str, Callable[..., Any]] = {
    "uniform": lambda random, least, most: least + (most - least) * float(random.random()),
    "log_uniform": lambda random, least, most: min(
        least * math.exp(math.log(most / least) * float(random.random())), most
    ),
    "normal": lambda random, mean, spread: mean + spread * float(random.standard_normal()),
    CHOICE: lambda random, *values: values[int(random.integers(len(values)))],
}


@dataclass(frozen=True)
class Distribution:
    """One of the above.

    Attributes:
        kind: Name of the distribution; a grid is kept as its values.
        arguments: As in YAML.
    """

    kind: str
    arguments: tuple[Any, ...]

    @classmethod
    def of(cls, key: str, written: Any) -> Distribution:
        """The distribution that YAML holds.

        Args:
            key: Of what it is, for the message of an error.
            written: A value, or a mapping of one name to its arguments.

        Raises:
            ParameterError: Unknown, or with arguments that make no distribution.
        """
        if not isinstance(written, Mapping):
            return cls(CONSTANT, (written,))
        kind, arguments = next(iter(written.items()), ("", ()))
        if len(written) != 1 or kind not in KINDS or not isinstance(arguments, list):
            raise ParameterError(
                f"'{key}' is {written!r}, must be a value or one of {', '.join(KINDS)} with a "
                "list, such as {uniform: [0.0, 1.0]}"
            )
        if not arguments or (KINDS[kind] and len(arguments) != KINDS[kind]):
            count = KINDS[kind] or "at least one"
            raise ParameterError(f"'{key}': {kind} is {arguments!r}, must have {count} values")
        if kind in NUMBERS:
            right, words = NUMBERS[kind]
            if not all(is_number(x) and math.isfinite(x) for x in arguments):
                right, words = (lambda *_: False), "finite numbers"
            if not right(*arguments):
                raise ParameterError(f"'{key}': {kind} is {arguments!r}, must be {words}")
        if kind == GRID:
            return cls(SWEPT, tuple(np.linspace(*arguments).tolist()))
        return cls(kind, tuple(map(float, arguments) if kind in NUMBERS else arguments))

    @property
    def ends(self) -> tuple[Any, ...]:
        """Values between which all lie that can be drawn; none where there are no such."""
        return () if self.kind == "normal" else self.arguments

    def draw(self, random: np.random.Generator) -> Any:
        """Draw a value; of one that is swept, the first.

        Args:
            random: Where the numbers come from.
        """
        drawn = DRAWING.get(self.kind)
        return self.arguments[0] if drawn is None else drawn(random, *self.arguments)

    def draw_within(self, random: np.random.Generator, neutral: Any, share: float) -> Any:
        """Draw a value and keep to a share of the way to it from what is without error.

        Of a choice, the value that was drawn is kept with that probability.

        Args:
            random: Where the numbers come from.
            neutral: What is without error.
            share: Of the range [-]: 1 for all of it.
        """
        drawn = self.draw(random)
        if self.kind == CONSTANT or share == 1.0:
            return drawn
        if self.kind == CHOICE:
            return drawn if random.random() < share else neutral
        return neutral + share * (drawn - neutral)


ONE, ALL, NO = "one", "all", "none"
Draws = dict[str, Distribution]


@dataclass(frozen=True)
class Group(Parameters):
    """A part of the flights."""

    name: str = parameter("all", "What it is called")
    share: float = parameter(1.0, "Of all flights", lower=0.0, upper=1.0)
    errors: str = parameter(
        ALL, "One at a time, by turns; all together; or none", choices=(ONE, ALL, NO)
    )
    range: float = parameter(
        1.0, "Share of the errors' ranges that is drawn from", lower=0.0, upper=1.0
    )


RAISED = "raised"  # what a flight that raised an error failed by
HARD = ("bank", "airspeed", "path_angle")  # limits of the airframe
# Conditions of failure, and what each of them may be given beside the names of limits.
CRITERIA = {
    "orbit_lost": {
        "beyond": Specification("beyond", 30.0, "Range error of a lost orbit", "m", 0.0),
        "settled_for": Specification("settled_for", 20.0, "Inside it to be settled", "s", 0.0),
    },
    "never_settled": {},
    "limit_passed": {"by": Specification("by", 0.05, "Share of a limit's bound", "", 0.0)},
}


@dataclass(frozen=True)
class Criteria:
    """Conditions of failure, each on the true trajectory.

    Attributes:
        names: Of those that count.
        beyond: Range error in [m] beyond which an orbit is lost, and inside which it is settled.
        settled_for: How long in [s] it must be inside to count as settled.
        by: Share of a bound [-] by which a limit may be passed.
        limits: Names of the limits that count.
    """

    names: tuple[str, ...] = tuple(CRITERIA)
    beyond: float = 30.0
    settled_for: float = 20.0
    by: float = 0.05
    limits: tuple[str, ...] = HARD

    @classmethod
    def of(cls, written: Mapping[str, Any]) -> Criteria:
        """The conditions that YAML holds; all with their defaults where it names none.

        Args:
            written: Arguments by the name of the condition.

        Raises:
            ParameterError: An argument is unknown or not allowed.
        """
        values: dict[str, Any] = {}
        for name, known in CRITERIA.items():
            arguments = dict(_mapping(written.get(name, {}), f"failure: '{name}'"))
            if name == "limit_passed" and "limits" in arguments:
                values["limits"] = _limits(arguments.pop("limits"))
            for key, value in arguments.items():
                if key not in known:
                    raise ParameterError(f"failure: '{name}' has no '{key}'")
                values[key] = known[key].check(value)
        return cls(names=tuple(written) or tuple(CRITERIA), **values)

    def settled_at(self, time: NDArray[np.float64], error: NDArray[np.float64]) -> float | None:
        """When the flight has been inside long enough, in [s]; None if never.

        Args:
            time: Of the samples in [s], shape (n,).
            error: r - r_d in [m], shape (n,).
        """
        inside = np.abs(error) <= self.beyond
        outside = np.flatnonzero(~inside)
        first = np.minimum(np.append(0, outside + 1), len(time) - 1)
        ends = np.append(time[outside], time[-1])
        long = np.flatnonzero(inside[first] & (ends - time[first] >= self.settled_for))
        return float(time[first[long[0]]]) + self.settled_for if len(long) else None

    def failures(
        self, log: FlightLog, error: NDArray[np.float64], parameters: TrackingParameters
    ) -> list[str]:
        """Conditions that a flight meets, with the limits' names.

        Args:
            log: Record of the flight.
            error: r - r_d in [m], shape (n,).
            parameters: The limits.
        """
        settled, found = self.settled_at(log.time, error), []
        if settled is None:
            found.append("never_settled")
        elif not np.all(np.abs(error[log.time >= settled]) <= self.beyond):
            found.append("orbit_lost")
        if "limit_passed" in self.names:
            passed = violations(log, parameters, self.by)
            counted = [name.replace("_", " ") for name in self.limits]
            found += [f"limit_passed:{each}" for each in counted if np.any(passed.get(each, False))]
        return [each for each in found if each.partition(":")[0] in self.names]


def _limits(value: Any) -> tuple[str, ...]:
    if not isinstance(value, list) or not value or not all(name in LIMIT.names for name in value):
        raise ParameterError(
            f"failure: 'limits' is {value!r}, must be a list of some of {', '.join(LIMIT.names)}"
        )
    return tuple(value)


@dataclass(frozen=True)
class Campaign:
    """What a campaign's file says.

    Attributes:
        name: Of the file without its ending.
        base: The configuration that all flights share.
        title: For people.
        description: For people.
        scenario: Name or file of the scenario, None without one.
        laws: That fly the same draws.
        flights: How many draws, of each combination of swept values.
        seed: Of everything random.
        settled_after: Time in [s] from which on statistics count; None for half the flight.
        draw: What is drawn for every flight, by key.
        errors: What nobody tells the controller, in bundles by name.
        groups: Parts of the flights.
        failure: What counts as a failure.
    """

    name: str
    base: Configuration
    title: str = ""
    description: str = ""
    scenario: str | None = None
    laws: tuple[str, ...] = (PREDICTIVE,)
    flights: int = 100
    seed: int = 0
    settled_after: float | None = None
    draw: Draws = field(default_factory=dict)
    errors: dict[str, Draws] = field(default_factory=dict)
    groups: tuple[Group, ...] = (Group(),)
    failure: Criteria = field(default_factory=Criteria)

    @property
    def swept(self) -> dict[str, tuple[Any, ...]]:
        """Values of what is swept, by key."""
        return {key: each.arguments for key, each in self.draw.items() if each.kind == SWEPT}

    @property
    def total(self) -> int:
        """Number of draws, for all combinations of swept values together."""
        return self.flights * math.prod(len(values) for values in self.swept.values())

    @property
    def inputs(self) -> list[str]:
        """Keys in which flights may differ, each once."""
        return list(dict.fromkeys(key for key, each in self._draws if each.kind != CONSTANT))

    @property
    def words(self) -> set[str]:
        """Inputs whose values are not all numbers."""
        return {key for key, each in self._draws if not all(map(is_number, each.ends))}

    @property
    def _draws(self) -> list[tuple[str, Distribution]]:
        """All that is drawn, by key; a key may come again."""
        every = [self.draw, *self.errors.values()]
        return [found for draws in every for found in draws.items()]

    @property
    def identity(self) -> str:
        """Digest of all that decides the outcome, of this package's version too."""
        content = dataclasses.asdict(dataclasses.replace(self, title="", description=""))
        content["base"] = self.base.sections
        text = json.dumps([__version__, content], sort_keys=True, default=repr)
        return hashlib.sha256(text.encode()).hexdigest()[:16]


COUNTED = {
    "flights": Specification("flights", 100, "Draws of each combination", "", 1),
    "seed": Specification("seed", 0, "Of everything random", "", 0),
    "settled_after": Specification("settled_after", 0.0, "From when on statistics count", "s", 0.0),
}
KEYS = (
    "title", "description", "config", "scenario", "laws", *COUNTED, "draw", "errors", "groups",
    "failure",
)  # fmt: skip


def load_campaign(
    name_or_file: str,
    overrides: tuple[str, ...] = (),
    laws: tuple[str, ...] = (),
    flights: int | None = None,
) -> Campaign:
    """Load a campaign by name, or from a file.

    Args:
        name_or_file: Name of one that comes with the package, or path of a YAML file.
        overrides: ``KEY=VALUE`` each, VALUE a value or a distribution; they replace what the file
            draws for every flight.
        laws: Other laws than the file's.
        flights: Another number than the file's.

    Raises:
        ParameterError: No such campaign, or what it says is not known or not allowed.
    """
    path = found("campaign", name_or_file, configuration_folder() / "campaigns")
    content = _mapping(read_yaml(path, "campaign"), f"campaign {path}", KEYS)
    try:
        return _campaign(path.stem, dict(content), overrides, laws, flights)
    except ParameterError as error:
        raise ParameterError(f"campaign {path.stem}: {error}") from error


def _campaign(
    name: str,
    content: dict[str, Any],
    overrides: tuple[str, ...],
    laws: tuple[str, ...],
    flights: int | None,
) -> Campaign:
    scenario = content.get("scenario")
    base = load_configuration(str(content.pop("config", None) or "small_uav"), (), scenario)
    draws = dict(_mapping(content.pop("draw", {}), "draw"))
    for assignment in overrides:
        key, equals, text = assignment.partition("=")
        if not equals:
            raise ParameterError(f"override is {assignment!r}, must be KEY=VALUE")
        draws[key.strip()] = read_value(text)
    errors = {
        str(error): _distributions(base, _mapping(each, f"error '{error}'"))
        for error, each in _mapping(content.pop("errors", {}), "errors").items()
    }
    swept = [k for each in errors.values() for k, draw in each.items() if draw.kind == SWEPT]
    if swept:
        raise ParameterError(f"'{swept[0]}' is swept, which only what is under 'draw' can be")
    groups = _groups(content.pop("groups", {}), bool(errors))
    if any(group.range < 1.0 for group in groups):
        drawn = [(k, draw) for each in errors.values() for k, draw in each.items()]
        for key, draw in drawn:
            if draw.kind not in (CONSTANT, CHOICE) and is_whole_list(base.sections, key):
                words = f"'{key}' is a list: a group with a 'range' draws its components alone"
                raise ParameterError(f"{words}, such as '{key}[0]'")
    failure = _mapping(content.pop("failure", {}), "failure", tuple(CRITERIA))
    content |= {"laws": list(laws)} if laws else {}
    content |= {} if flights is None else {"flights": flights}
    plain = {key: _plain(key, value) for key, value in content.items() if value is not None}
    return Campaign(
        name=name, base=base, draw=_distributions(base, draws), errors=errors, groups=groups,
        failure=Criteria.of(failure), **plain,
    )  # fmt: skip


def _plain(key: str, value: Any) -> Any:
    """A value without parts, in the type that it must have."""
    if key in COUNTED:
        return COUNTED[key].check(value)
    if key != "laws":
        return str(value).strip()
    if isinstance(value, list) and value and all(isinstance(law, str) for law in value):
        return tuple(dict.fromkeys(value))
    raise ParameterError(f"'laws' is {value!r}, must be a list of names")


def _distributions(base: Configuration, written: Mapping[str, Any]) -> Draws:
    """Distributions by key, each of a parameter that can take all that may be drawn."""
    draws = {str(key): Distribution.of(key, value) for key, value in written.items()}
    for key, draw in draws.items():
        read(base.sections, key)  # raises where there is no such parameter
        for value in draw.ends:
            check_value(base.sections, key, value)
    return draws


def _groups(written: Any, errors: bool) -> tuple[Group, ...]:
    if not written:
        return (Group(errors=ALL if errors else NO),)
    groups = [
        from_mapping(Group, {"name": str(name), **_mapping(content, f"group '{name}'")})
        for name, content in _mapping(written, "groups").items()
    ]
    for group in groups:
        if group.errors != NO and not errors:
            raise ParameterError(f"group '{group.name}': there are no errors to draw")
    total = sum(group.share for group in groups)
    if not math.isclose(total, 1.0, abs_tol=1e-6):
        raise ParameterError(f"the shares of the groups add up to {total:g}, must be 1")
    return tuple(groups)


def _mapping(value: Any, words: str, known: tuple[str, ...] = ()) -> Mapping[str, Any]:
    if not isinstance(value, Mapping):
        raise ParameterError(f"{words} is {value!r}, must hold names and values")
    for key in value:
        if known and key not in known:
            raise ParameterError(f"{words}: '{key}' is unknown, known are: {', '.join(known)}")
    return value
