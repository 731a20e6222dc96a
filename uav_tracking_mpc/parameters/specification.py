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

"""Parameters described once: name, type, default, unit, meaning, allowed values.

A set of parameters is a frozen dataclass derived from :class:`Parameters`, whose fields are made by
:func:`parameter`. From the same description come the checks, the ROS declarations, the tables in
the README and ``--help``.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Mapping, Set
from dataclasses import dataclass
from typing import Any, TypeGuard, TypeVar, cast

from uav_tracking_mpc.parameters.registry import did_you_mean, names_of

Value = bool | int | float | str | tuple[float, ...]
T = TypeVar("T", bound="Parameters")


class ParameterError(ValueError):
    """A parameter has a value that is not allowed; the message names all three."""


@dataclass(frozen=True)
class Specification:
    """Description of one parameter.

    Attributes:
        name: As in YAML and on the ROS command line.
        default: Also gives the type: bool, int, float, str or a tuple of floats.
        description: What it does, for people.
        unit: SI unit, or "".
        lower: Least value allowed (of every element) in [unit], or None.
        upper: Greatest value allowed (of every element) in [unit], or None.
        choices: The only values allowed beside those of ``extension``, or () for any.
        size: Number of elements of a tuple; 0 for any multiple of ``multiple``.
        multiple: A tuple's length must be a multiple of this.
        extension: Room of what the value names: an installed one, or ``path.py:Class``.
        fixed: Whether it can only be set at the start, for a controller while not configured.
    """

    name: str
    default: Value
    description: str
    unit: str = ""
    lower: float | None = None
    upper: float | None = None
    choices: tuple[str, ...] = ()
    size: int = 0
    multiple: int = 1
    extension: str = ""
    fixed: bool = False

    @property
    def names(self) -> tuple[str, ...]:
        """What the value may be, where that is one of several names."""
        return (*self.choices, *(names_of(self.extension) if self.extension else ()))

    @property
    def allowed(self) -> str:
        """The allowed values in words."""
        kind = {bool: "true or false", int: "an integer", float: "a number", str: "text"}
        if self.names:
            return f"one of {', '.join(self.names)}{', or path.py:Class' if self.extension else ''}"
        if isinstance(self.default, tuple):
            count = str(self.size) if self.size else f"a multiple of {self.multiple}"
            words = f"a list of {count} numbers"
        else:
            words = kind[type(self.default)]
        unit = f" {self.unit}" if self.unit else ""
        if self.lower is not None and self.upper is not None:
            words += f" from {self.lower:g} to {self.upper:g}{unit}"
        elif self.lower is not None:
            words += f" of at least {self.lower:g}{unit}"
        elif self.upper is not None:
            words += f" of at most {self.upper:g}{unit}"
        return words

    def check(self, value: Any) -> Value:
        """The value in the parameter's own type.

        An integer is taken where a number is asked for; nothing else is converted.

        Args:
            value: As it came from YAML, ROS or Python.

        Raises:
            ParameterError: Wrong type, not finite, out of range, wrong length, not a choice.
        """
        checked = self._convert(value)
        least = -math.inf if self.lower is None else self.lower
        most = math.inf if self.upper is None else self.upper
        for number in checked if isinstance(checked, tuple) else (checked,):
            if is_number(number) and not (least <= number <= most and math.isfinite(number)):
                raise self._error(value)
        if self.choices or self.extension:
            named = checked in self.choices or (self.extension and ":" in str(checked))
            if not (named or checked in self.names):
                raise self._error(value)
        return checked

    def _convert(self, value: Any) -> Value:
        if isinstance(self.default, tuple):
            ordered = hasattr(value, "__iter__") and not isinstance(value, (Mapping, Set))
            if isinstance(value, (str, bytes)) or not ordered:
                raise self._error(value)
            elements = tuple(value)
            if not all(is_number(element) for element in elements):
                raise self._error(value)
            if len(elements) != self.size if self.size else len(elements) % self.multiple:
                raise self._error(value)
            return tuple(self._float(element) for element in elements)
        if isinstance(self.default, float) and is_number(value):
            return self._float(value)
        alike = isinstance(value, bool) is isinstance(self.default, bool)
        if alike and isinstance(value, type(self.default)):
            return value
        raise self._error(value)

    def _float(self, value: float) -> float:
        try:
            return float(value)
        except OverflowError:  # an integer beyond every float
            raise self._error(value) from None

    def _error(self, value: Any) -> ParameterError:
        meant = did_you_mean(value, self.names)
        return ParameterError(
            f"parameter '{self.name}' is {value!r}{meant}, must be {self.allowed}"
        )


def is_number(value: Any) -> TypeGuard[float]:
    """Whether a value is a number; true and false are none.

    Args:
        value: Of any type.
    """
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def parameter(
    default: Any,
    description: str,
    unit: str = "",
    lower: float | None = None,
    upper: float | None = None,
    **more: Any,
) -> Any:
    """Dataclass field of a parameter.

    Args:
        default: Its default; also gives its type.
        description: What it does, for people.
        unit: SI unit; empty for a pure number.
        lower: Least value allowed in [unit].
        upper: Greatest value allowed in [unit].
        more: The other attributes of a :class:`Specification`, but for its name.
    """
    metadata = {"description": description, "unit": unit, "lower": lower, "upper": upper, **more}
    return dataclasses.field(default=default, metadata=metadata)


@dataclass(frozen=True)
class Parameters:
    """Base of all sets of parameters: every value is checked, however the set is made.

    Raises:
        ParameterError: A value is not allowed.
    """

    @classmethod
    def extended(cls, values: Mapping[str, Any]) -> type[Any]:
        """The class that describes the values, some of which may bring parameters of their own.

        Args:
            values: By name, as far as they are known.
        """
        return cls

    def __post_init__(self) -> None:
        """Check every value by its description, and keep it in its parameter's own type."""
        for name, value in vars(type(self)).items():
            if isinstance(value, dataclasses.Field):  # a dataclass keeps its default instead
                raise ParameterError(
                    f"parameter '{name}' counts only if {type(self).__name__} is decorated with "
                    "@dataclass(frozen=True)"
                )
        for known in specifications(type(self)):
            object.__setattr__(self, known.name, known.check(getattr(self, known.name)))


def specifications(parameters: type) -> tuple[Specification, ...]:
    """Specifications of a dataclass of ``parameters``, in the order of its fields."""
    fields: tuple[dataclasses.Field[Any], ...] = dataclasses.fields(parameters)
    return tuple(
        Specification(field.name, cast(Value, field.default), **field.metadata) for field in fields
    )


def gathered(name: str, owners: Iterable[type]) -> type[Any]:
    """Frozen dataclass with the parameters of several others, such as all limits, and no methods.

    Args:
        name: Of the class.
        owners: Dataclasses of parameters. Two may share one if they describe it alike.

    Raises:
        ParameterError: Two describe a parameter of one name differently.
    """
    found: dict[str, dataclasses.Field[Any]] = {}
    for owner in owners:
        for field in dataclasses.fields(owner):
            known = found.setdefault(field.name, field)
            if (known.default, known.metadata) != (field.default, field.metadata):
                raise ParameterError(
                    f"parameter '{field.name}' of {owner.__name__} is described differently "
                    "elsewhere, must have a name of its own"
                )
    fields: list[tuple[str, Any, Any]] = [
        (name, field.type, dataclasses.field(default=field.default, metadata=field.metadata))
        for name, field in found.items()
    ]
    return dataclasses.make_dataclass(name, fields, bases=(Parameters,), frozen=True)


def taken(owner: type[T], values: object) -> T:
    """A dataclass of parameters made from the attributes of another.

    Args:
        owner: The dataclass.
        values: Has an attribute for each of its fields.
    """
    fields: tuple[dataclasses.Field[Any], ...] = dataclasses.fields(owner)  # type: ignore[arg-type]
    return owner(**{field.name: getattr(values, field.name) for field in fields})


def from_mapping(parameters: type[T], values: Mapping[str, Any]) -> T:
    """Build a parameter dataclass from names and values; what is missing takes its default.

    Args:
        parameters: The dataclass.
        values: By name of the parameter.

    Raises:
        ParameterError: An unknown name, or a value that is not allowed.
    """
    parameters = parameters.extended(values)
    known = [specification.name for specification in specifications(parameters)]
    for name in values:
        if name not in known:
            meant = did_you_mean(name, known)
            raise ParameterError(
                f"parameter '{name}' is unknown{meant}, known are: {', '.join(known)}"
            )
    return parameters(**values)


def changed(parameters: T, values: Mapping[str, Any]) -> T:
    """A parameter dataclass with some values replaced.

    Args:
        parameters: The present ones.
        values: New ones by name.

    Raises:
        ParameterError: An unknown name, or a value that is not allowed.
    """
    return from_mapping(type(parameters), {**dataclasses.asdict(parameters), **values})


def refuse_fixed(
    before: Parameters,
    after: Parameters,
    meanwhile: str = "while the controller is configured",
    names: Iterable[str] | None = None,
) -> None:
    """Refuse a change of what must stay as it is.

    Args:
        before: That are in use.
        after: Of the same kind, to take their place.
        meanwhile: How long it stays fixed, in words.
        names: What is fixed; None for what can only be set at the start.

    Raises:
        ParameterError: A fixed parameter differs.
    """
    if names is None:
        names = [known.name for known in specifications(type(before)) if known.fixed]
    for name in names:
        old, new = getattr(before, name), getattr(after, name)
        if old != new:
            raise ParameterError(f"parameter '{name}' is {new!r}, must stay {old!r} {meanwhile}")
