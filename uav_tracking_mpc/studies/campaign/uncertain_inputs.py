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
    is_number,
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


def _share(names: tuple[str, ...], into: str, words: str) -> Derived:
    """A factor on what the aircraft has."""

    def write(sections: Sections, factor: float) -> None:
        for name in names:
            values = _present(sections, _SIMULATOR, name)
            sections[into][name] = [factor * value for value in values]

    return Derived(words, lambda sections: 1.0, write)


def _polar(name: str, part: int, words: str, about_target: bool = False) -> Derived:
    """One of the cylindrical coordinates of a vector of the simulator: length, angle, height."""

    def origin(sections: Sections) -> Any:
        if not about_target:
            return 0.0, 0.0, 0.0
        target = from_mapping(TargetParameters, sections[_TARGET])
        return motion_of(target).position(0.0).tolist()

    def coordinates(sections: Sections) -> list[float]:
        vector = _present(sections, _SIMULATOR, name)
        x, y, z = (end - begin for end, begin in zip(vector, origin(sections), strict=True))
        return [math.hypot(x, y), math.degrees(math.atan2(y, x)), z]

    def write(sections: Sections, value: float) -> None:
        length, angle, height = (
            value if index == part else known for index, known in enumerate(coordinates(sections))
        )
        x, y, z = origin(sections)
        east, north = math.cos(math.radians(angle)), math.sin(math.radians(angle))
        sections[_SIMULATOR][name] = [x + length * east, y + length * north, z + height]

    return Derived(words, lambda sections: coordinates(sections)[part], write)


_LAG, _DEAD_TIME = ("rate_lag",), ("dead_time",)
# In the order in which they are written: lengths before angles, the truth before what is told.
DERIVED = {
    "start.distance": _polar("initial_position", 0, "level, to the target [m]", True),
    "start.azimuth_deg": _polar("initial_position", 1, "seen from the target", True),
    "start.height": _polar("initial_position", 2, "above the target [m]", True),
    "wind.speed": _polar("wind", 0, "of the mean wind, level [m/s]"),
    "wind.direction_deg": _polar("wind", 1, "where it blows to, from East"),
    "velocity_bias.speed": _polar("velocity_bias", 0, "level [m/s]"),
    "velocity_bias.direction_deg": _polar("velocity_bias", 1, "where to, from East"),
    "true.lag": _share(_LAG, _SIMULATOR, "factor on the aircraft's lags"),
    "true.dead_time": _share(_DEAD_TIME, _SIMULATOR, "on its dead times"),
    "true.response": _share(_LAG + _DEAD_TIME, _SIMULATOR, "on both"),
    "told.lag": _share(_LAG, _CONTROLLER, "told lags over the true ones"),
    "told.dead_time": _share(_DEAD_TIME, _CONTROLLER, "told dead times over true"),
    "told.response": _share(_LAG + _DEAD_TIME, _CONTROLLER, "both"),
}


@dataclass(frozen=True)
class _Place:
    """Where the value of a key goes that is a parameter, or a component of one."""

    section: str
    specification: Specification
    degrees: bool
    index: int | None

    def read(self, sections: Sections) -> Any:
        value = _present(sections, self.section, self.specification.name)
        if isinstance(self.specification.default, tuple):
            value = value[self.index or 0]
        return math.degrees(value) if self.degrees else value

    def write(self, sections: Sections, value: Any) -> None:
        value = math.radians(value) if self.degrees else value
        name, vector = self.specification.name, isinstance(self.specification.default, tuple)
        if vector and not isinstance(value, (list, tuple)):
            present = list(_present(sections, self.section, name))
            where = range(len(present)) if self.index is None else [self.index]
            value = [value if i in where else known for i, known in enumerate(present)]
        sections[self.section][name] = value


def _input(sections: Sections, key: str) -> _Place | Derived:
    """What a key names."""
    if key in DERIVED:
        return DERIVED[key]
    match = _KEY.match(key)
    if match is None or match["section"] not in SECTIONS:
        near = difflib.get_close_matches(key, DERIVED, 3) or list(DERIVED)
        raise ParameterError(
            f"'{key}' must be SECTION.PARAMETER with SECTION one of {', '.join(SECTIONS)}, or "
            f"such as {', '.join(near)}"
        )
    section, name, index = match["section"], match["name"], match["index"]
    known = _specification(sections, section, name)
    if match["degrees"] and not known.unit.startswith("rad"):
        raise ParameterError(f"'{key}': '{name}' is no angle, its unit is not rad")
    vector = _present(sections, section, name) if isinstance(known.default, tuple) else ()
    if index is not None and int(index) >= len(vector):
        raise ParameterError(f"'{key}': '{name}' has no component {index}")
    return _Place(section, known, bool(match["degrees"]), None if index is None else int(index))


def check_value(sections: Sections, key: str, value: Any) -> None:
    """Whether a parameter takes a value; of what is derived only that it is a number.

    Args:
        sections: Of the configuration.
        key: As in the campaign's file.
        value: That may be drawn.

    Raises:
        ParameterError: There is no such parameter, or its range does not hold the value.
    """
    place = _input(sections, key)
    if isinstance(place, Derived):
        if not is_number(value):
            raise ParameterError(f"'{key}' is {value!r}, must be a number: {place.words}")
        return
    trial: Sections = {section: dict(values) for section, values in sections.items()}
    place.write(trial, value)
    try:
        place.specification.check(trial[place.section][place.specification.name])
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
    return _input(sections, key).read(sections)


def is_whole_list(sections: Sections, key: str) -> bool:
    """Whether a key names a list, all components of which take the value that is drawn.

    Args:
        sections: Of the configuration.
        key: As in the campaign's file.

    Raises:
        ParameterError: There is no such parameter.
    """
    place = _input(sections, key)
    return (
        isinstance(place, _Place)
        and place.index is None
        and isinstance(place.specification.default, tuple)
    )


def write(sections: Sections, values: Mapping[str, Any]) -> None:
    """Put values into a configuration, parameters first, then what is derived from them.

    Args:
        sections: Of the configuration, changed in place.
        values: By key.
    """
    order = [*(key for key in values if key not in DERIVED), *(k for k in DERIVED if k in values)]
    for key in order:
        _input(sections, key).write(sections, values[key])
