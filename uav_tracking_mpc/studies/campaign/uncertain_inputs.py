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

"""What can be uncertain: any parameter, a component of it, or something handier."""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from uav_tracking_mpc.parameters.specification import (
    ParameterError,
    Specification,
    from_mapping,
    specifications,
)
from uav_tracking_mpc.settings.configuration import SECTIONS, Sections
from uav_tracking_mpc.settings.simulator import TargetParameters
from uav_tracking_mpc.simulation.motions import motion_of

_SIMULATOR, _CONTROLLER, _TARGET = "uav_simulator", "nmpc_controller", "target_publisher"
_KEY = re.compile(r"(?P<section>\w+)\.(?P<name>\w+?)(?P<degrees>_deg)?(\[(?P<index>\d+)\])?$")


@dataclass(frozen=True)
class Derived:
    """Something handier than the parameters that it sets.

    Attributes:
        words: What it is, for people.
        read: Its value in a configuration.
        write: Puts a value into a configuration.
    """

    words: str
    read: Callable[[Sections], float]
    write: Callable[[Sections, float], None]


def _present(sections: Sections, section: str, name: str) -> Any:
    """Value of a parameter in a configuration, its default where the files say nothing."""
    return sections[section].get(name, _specification(sections, section, name).default)


def _specification(sections: Sections, section: str, name: str) -> Specification:
    parameters: Any = SECTIONS[section].extended(sections[section])
    known = _specifications(parameters)
    if name not in known:
        near = difflib.get_close_matches(name, known, 3, cutoff=0.4)
        words = f"; near are {', '.join(near)}" if near else ""
        raise ParameterError(f"'{section}.{name}': there is no such parameter{words}")
    return known[name]


@lru_cache
def _specifications(parameters: type) -> dict[str, Specification]:
    return {each.name: each for each in specifications(parameters)}


def _share(reading: str, names: tuple[str, ...], into: str, words: str) -> Derived:
    """A factor on what the aircraft has."""

    def write(sections: Sections, factor: float) -> None:
        for name in names:
            values = _present(sections, reading, name)
            sections[into][name] = [factor * value for value in values]

    return Derived(words, lambda sections: 1.0, write)


def _origin(sections: Sections, about: str) -> list[float]:
    """Where a vector begins: at zero, or for a start at the target's."""
    if not about:
        return [0.0, 0.0, 0.0]
    target = from_mapping(TargetParameters, sections[_TARGET])
    return [float(value) for value in motion_of(target).position(0.0)]


def _polar(name: str, part: str, words: str, about: str = "") -> Derived:
    """One of the cylindrical coordinates of a vector of the simulator."""

    def coordinates(sections: Sections) -> dict[str, float]:
        x_0, y_0, z_0 = _origin(sections, about)
        x, y, z = _present(sections, _SIMULATOR, name)
        angle = math.degrees(math.atan2(y - y_0, x - x_0))
        return {"length": math.hypot(x - x_0, y - y_0), "angle": angle, "height": z - z_0}

    def write(sections: Sections, value: float) -> None:
        length, angle, height = {**coordinates(sections), part: value}.values()
        x_0, y_0, z_0 = _origin(sections, about)
        east, north = math.cos(math.radians(angle)), math.sin(math.radians(angle))
        sections[_SIMULATOR][name] = [x_0 + length * east, y_0 + length * north, z_0 + height]

    return Derived(words, lambda sections: coordinates(sections)[part], write)


_TIMES = ("rate_lag", "dead_time")
# In the order in which they are written: lengths before angles, the truth before what is told.
DERIVED = {
    "start.distance": _polar("initial_position", "length", "level, to the target [m]", _TARGET),
    "start.azimuth_deg": _polar("initial_position", "angle", "seen from the target", _TARGET),
    "start.height": _polar("initial_position", "height", "above the target [m]", _TARGET),
    "wind.speed": _polar("wind", "length", "of the mean wind, level [m/s]"),
    "wind.direction_deg": _polar("wind", "angle", "where it blows to, from East"),
    "velocity_bias.speed": _polar("velocity_bias", "length", "level [m/s]"),
    "velocity_bias.direction_deg": _polar("velocity_bias", "angle", "where to, from East"),
    "true.lag": _share(_SIMULATOR, _TIMES[:1], _SIMULATOR, "factor on the aircraft's lags"),
    "true.dead_time": _share(_SIMULATOR, _TIMES[1:], _SIMULATOR, "on its dead times"),
    "true.response": _share(_SIMULATOR, _TIMES, _SIMULATOR, "on both"),
    "told.lag": _share(_SIMULATOR, _TIMES[:1], _CONTROLLER, "told lags over the true ones"),
    "told.dead_time": _share(_SIMULATOR, _TIMES[1:], _CONTROLLER, "told dead times over true"),
    "told.response": _share(_SIMULATOR, _TIMES, _CONTROLLER, "both"),
}


@dataclass(frozen=True)
class _Place:
    """Where the value of a key goes."""

    section: str
    specification: Specification
    degrees: bool
    index: int | None

    @property
    def name(self) -> str:
        return self.specification.name

    @property
    def vector(self) -> bool:
        return isinstance(self.specification.default, tuple)


def _place_of(sections: Sections, key: str) -> _Place | None:
    """The parameter that a key names; None for what :data:`DERIVED` lists."""
    if key in DERIVED:
        return None
    match = _KEY.match(key)
    if match is None or match["section"] not in SECTIONS:
        near = difflib.get_close_matches(key, DERIVED, 3) or list(DERIVED)
        raise ParameterError(
            f"'{key}' must be SECTION.PARAMETER with SECTION one of {', '.join(SECTIONS)}, or "
            f"such as {', '.join(near)}"
        )
    specification = _specification(sections, match["section"], match["name"])
    index = None if match["index"] is None else int(match["index"])
    place = _Place(match["section"], specification, match["degrees"] is not None, index)
    if place.degrees and not specification.unit.startswith("rad"):
        raise ParameterError(f"'{key}': '{place.name}' is no angle, its unit is not rad")
    if index is not None:
        present = _present(sections, place.section, place.name)
        if not place.vector or index >= len(present):
            raise ParameterError(f"'{key}': '{place.name}' has no component {index}")
    return place


def check_value(sections: Sections, key: str, value: Any) -> None:
    """Whether a parameter takes a value; of what is derived only that it is a number.

    Args:
        sections: Of the configuration.
        key: As in the campaign's file.
        value: That may be drawn.

    Raises:
        ParameterError: There is no such parameter, or its range does not hold the value.
    """
    place = _place_of(sections, key)
    if place is None:
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise ParameterError(f"'{key}' is {value!r}, must be a number: {DERIVED[key].words}")
        return
    trial: Sections = {section: dict(values) for section, values in sections.items()}
    write(trial, {key: value})
    try:
        place.specification.check(trial[place.section][place.name])
    except ParameterError as error:
        raise ParameterError(f"'{key}' may become {value!r}: {error}") from error


def read(sections: Sections, key: str) -> Any:
    """Value of a key in a configuration; of all components of a list, the first.

    Args:
        sections: Of the configuration.
        key: As in the campaign's file.

    Raises:
        ParameterError: There is no such parameter.
    """
    place = _place_of(sections, key)
    if place is None:
        return DERIVED[key].read(sections)
    value = _present(sections, place.section, place.name)
    if place.vector:
        value = value[place.index or 0]
    return math.degrees(value) if place.degrees else value


def write(sections: Sections, values: Mapping[str, Any]) -> None:
    """Put values into a configuration, parameters first, then what is derived from them.

    Args:
        sections: Of the configuration, changed in place.
        values: By key.
    """
    for key, value in values.items():
        place = _place_of(sections, key)
        if place is None:
            continue
        if place.degrees:
            value = math.radians(value)
        if place.vector and not isinstance(value, (list, tuple)):
            present = list(_present(sections, place.section, place.name))
            where = range(len(present)) if place.index is None else [place.index]
            value = [value if i in where else known for i, known in enumerate(present)]
        sections[place.section][place.name] = value
    for key, derived in DERIVED.items():
        if key in values:
            derived.write(sections, values[key])
