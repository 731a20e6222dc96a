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
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from uav_tracking_mpc import __version__
from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.configuration import (
    Configuration,
    configuration_folder,
    found,
    load_configuration,
    read_value,
    read_yaml,
)
from uav_tracking_mpc.settings.tracking import PREDICTIVE
from uav_tracking_mpc.studies.campaign.criteria import CRITERIA, Criteria
from uav_tracking_mpc.studies.campaign.uncertain_inputs import check_value, read

CONSTANT, CHOICE, SWEPT = "constant", "choice", "values"
# Number of arguments; 0 for any but none.
KINDS = {"uniform": 2, "log_uniform": 2, "normal": 2, CHOICE: 0, SWEPT: 0, "grid": 3}


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
        if kind in (CHOICE, SWEPT):
            return cls(kind, tuple(arguments))
        return cls._of_numbers(key, kind, arguments)

    @classmethod
    def _of_numbers(cls, key: str, kind: str, arguments: list[Any]) -> Distribution:
        if not all(
            isinstance(x, (int, float)) and not isinstance(x, bool) and math.isfinite(x)
            for x in arguments
        ):
            raise ParameterError(f"'{key}': {kind} is {arguments!r}, must be finite numbers")
        first, second, *count = arguments
        wanted = {
            "uniform": (first <= second, "least and greatest in order"),
            "log_uniform": (0.0 < first <= second, "positive, least and greatest in order"),
            "normal": (second >= 0.0, "mean and a standard deviation of at least 0"),
            "grid": (bool(count) and isinstance(count[0], int) and count[0] > 0,
                     "first, last and how many"),
        }  # fmt: skip
        right, words = wanted[kind]
        if not right:
            raise ParameterError(f"'{key}': {kind} is {arguments!r}, must be {words}")
        if kind == "grid":
            return cls(SWEPT, tuple(np.linspace(first, second, count[0]).tolist()))
        return cls(kind, (float(first), float(second)))

    @property
    def swept(self) -> bool:
        """Whether each of its values is flown in turn."""
        return self.kind == SWEPT

    @property
    def varies(self) -> bool:
        """Whether flights may differ in it."""
        return self.kind != CONSTANT

    @property
    def ends(self) -> tuple[Any, ...]:
        """Values between which all lie that can be drawn; none where there are no such."""
        return () if self.kind == "normal" else self.arguments

    def draw(self, random: np.random.Generator) -> Any:
        """Draw a value; of one that is swept, the first.

        Args:
            random: Where the numbers come from.
        """
        if self.kind == CHOICE:
            return self.arguments[int(random.integers(len(self.arguments)))]
        if self.kind in (CONSTANT, SWEPT):
            return self.arguments[0]
        first, second = self.arguments
        if self.kind == "uniform":
            return first + (second - first) * float(random.random())
        if self.kind == "normal":
            return first + second * float(random.standard_normal())
        ratio = math.log(second / first)
        return min(first * math.exp(ratio * float(random.random())), second)

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
class Group:
    """A part of the flights.

    Attributes:
        name: What it is called.
        share: Of all flights [-].
        errors: ``one`` at a time, by turns; ``all`` together; or ``none``.
        range: Share of the errors' ranges that is drawn from [-].
    """

    name: str
    share: float = 1.0
    errors: str = ALL
    range: float = 1.0


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
    groups: tuple[Group, ...] = (Group("all"),)
    failure: Criteria = field(default_factory=Criteria)

    @property
    def swept(self) -> dict[str, tuple[Any, ...]]:
        """Values of what is swept, by key."""
        return {key: each.arguments for key, each in self.draw.items() if each.swept}

    @property
    def total(self) -> int:
        """Number of draws, for all combinations of swept values together."""
        return self.flights * math.prod(len(values) for values in self.swept.values())

    @property
    def inputs(self) -> list[str]:
        """Keys in which flights may differ, each once."""
        every = [self.draw, *self.errors.values()]
        return list(dict.fromkeys(k for draws in every for k, each in draws.items() if each.varies))

    @property
    def words(self) -> set[str]:
        """Inputs whose values are not all numbers."""
        every = [self.draw, *self.errors.values()]
        return {
            key
            for draws in every
            for key, each in draws.items()
            if any(isinstance(end, bool) or not isinstance(end, (int, float)) for end in each.ends)
        }

    @property
    def identity(self) -> str:
        """Digest of all that decides the outcome, of this package's version too."""
        content = dataclasses.asdict(dataclasses.replace(self, title="", description=""))
        content["base"] = self.base.sections
        text = json.dumps([__version__, content], sort_keys=True, default=repr)
        return hashlib.sha256(text.encode()).hexdigest()[:16]


KEYS = (
    "title", "description", "config", "scenario", "laws", "flights", "seed", "settled_after",
    "draw", "errors", "groups", "failure",
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
    base = load_configuration(str(content.pop("config", "small_uav")), (), scenario)
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
    swept = [k for each in errors.values() for k, draw in each.items() if draw.swept]
    if swept:
        raise ParameterError(f"'{swept[0]}' is swept, which only what is under 'draw' can be")
    groups = _groups(content.pop("groups", {}), bool(errors))
    failure = _mapping(content.pop("failure", {}), "failure", CRITERIA)
    if laws:
        content["laws"] = list(laws)
    if flights is not None:
        content["flights"] = flights
    plain = {key: _plain(key, value) for key, value in content.items() if value is not None}
    return Campaign(
        name=name, base=base, draw=_distributions(base, draws), errors=errors, groups=groups,
        failure=Criteria.of(failure), **plain,
    )  # fmt: skip


def _plain(key: str, value: Any) -> Any:
    """A value without parts, in the type that it must have."""
    if key == "laws":
        if isinstance(value, list) and value and all(isinstance(law, str) for law in value):
            return tuple(dict.fromkeys(value))
        raise ParameterError(f"'laws' is {value!r}, must be a list of names")
    if key in ("flights", "seed"):
        least = 1 if key == "flights" else 0
        if isinstance(value, int) and not isinstance(value, bool) and value >= least:
            return value
        raise ParameterError(f"'{key}' is {value!r}, must be an integer of at least {least}")
    if key == "settled_after":
        return number(value, "settled_after", 0.0)
    return str(value).strip()


def _distributions(base: Configuration, written: Mapping[str, Any]) -> Draws:
    """Distributions by key, each of a parameter that can take all that may be drawn."""
    draws = {key: Distribution.of(key, value) for key, value in written.items()}
    for key, draw in draws.items():
        read(base.sections, key)  # raises where there is no such parameter
        for value in draw.ends:
            check_value(base.sections, key, value)
    return draws


def _groups(written: Any, errors: bool) -> tuple[Group, ...]:
    if not written:
        return (Group("all", errors=ALL if errors else NO),)
    groups = []
    for name, content in _mapping(written, "groups").items():
        words = f"group '{name}'"
        values = _mapping(content, words, ("share", "errors", "range"))
        kind = values.get("errors", ALL)
        if kind not in (ONE, ALL, NO) or (kind != NO and not errors):
            raise ParameterError(
                f"{words}: 'errors' is {kind!r}, must be {ONE}, {ALL} or {NO}, and there must be "
                "errors to draw"
            )
        share, part = (
            number(values.get(key, 1.0), f"{words}: '{key}'", 0.0, 1.0)
            for key in ("share", "range")
        )
        groups.append(Group(str(name), share, kind, part))
    total = sum(group.share for group in groups)
    if not math.isclose(total, 1.0, abs_tol=1e-6):
        raise ParameterError(f"the shares of the groups add up to {total:g}, must be 1")
    return tuple(groups)


def number(value: Any, words: str, least: float, most: float = math.inf) -> float:
    """A number of a range.

    Args:
        value: That is to be one.
        words: What it is.
        least: In its unit, [-] or [s].
        most: In its unit, [-] or [s].

    Raises:
        ParameterError: It is none.
    """
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not least <= value <= most:
        span = f"of at least {least:g}" if most == math.inf else f"from {least:g} to {most:g}"
        raise ParameterError(f"{words} is {value!r}, must be a number {span}")
    return float(value)


def _mapping(value: Any, words: str, known: tuple[str, ...] = ()) -> Mapping[str, Any]:
    if not isinstance(value, Mapping):
        raise ParameterError(f"{words} is {value!r}, must hold names and values")
    for key in value:
        if known and key not in known:
            raise ParameterError(f"{words}: '{key}' is unknown, known are: {', '.join(known)}")
    return value
