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

r"""Limits of the aircraft and of where it may fly.

===============  =================================================================
``airspeed``     least and greatest airspeed, acceleration, and thrust less drag
``turn``         greatest turn rate, bank, and change of the bank
``climb``        steepest descent and climb, greatest path-angle rate
``place``        least height, least distance to the target, a fence
``envelope``     all of them together
``conformance``  whether a limit keeps what the base asks for
===============  =================================================================

A limit is a subclass of :class:`Limit` with a name: a quantity q of the motion with its bounds,

.. math:: q_{min} \le q(x) \le q_{max}

said once, and from it everything else: the inequalities of the problem, how far a flown state is
beyond them, and the words of a refusal. It is found by its name, by an entry point in the group
``uav_tracking_mpc.limits``, or as ``path.py:Class`` in the controller's parameter ``limits``.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from types import ModuleType
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.parameters.registry import ExtensionPoint
from uav_tracking_mpc.parameters.specification import Parameters

TOLERANCE = 0.01  # -, tolerance: share of a bound by which a flown quantity may pass it


class Motion(NamedTuple):
    """What limits see of the aircraft: numbers, arrays of one shape, or symbols.

    Attributes:
        x: East of the target in [m], scalar or any shape; so are all others.
        y: North of the target in [m].
        z: Above the target in [m].
        path_angle: chi in [rad].
        airspeed: v in [m/s].
        turn_rate: psi' in [rad/s]; None where it does not matter.
        acceleration: v' in [m/s^2]; None where it does not matter.
        turn_acceleration: psi'' in [rad/s^2], in plans where a stage begins; None where unknown.
    """

    x: Any
    y: Any
    z: Any
    path_angle: Any
    airspeed: Any
    turn_rate: Any = None
    acceleration: Any = None
    turn_acceleration: Any = None


class OrbitShape(NamedTuple):
    """What limits see of an orbit: numbers or symbols.

    Attributes:
        radius: Horizontal distance to the target in [m].
        altitude: Above the target in [m].
        airspeed: In [m/s].
        range: Distance to the target in [m].
        drift: Horizontal strength of the drift in [m/s].
    """

    radius: Any
    altitude: Any
    airspeed: Any
    range: Any
    drift: Any


class Bound(NamedTuple):
    """A quantity between its bounds.

    Attributes:
        value: The quantity, scalar or any shape, in its unit [SI]; symbols in a problem.
        lower: Least value, or None, in [SI], any shape.
        upper: Greatest value, or None, in [SI], any shape.
        scale: By how much it is passed where that is as bad as 1 m/s of airspeed, in [SI].
    """

    value: Any
    lower: Any = None
    upper: Any = None
    scale: float = 1.0

    def inequalities(self) -> list[Any]:
        """What must not be positive, scaled."""
        sides = [] if self.lower is None else [(self.lower - self.value) / self.scale]
        return sides if self.upper is None else [*sides, (self.value - self.upper) / self.scale]

    def passed(self, tolerance: float = TOLERANCE) -> NDArray[np.bool_]:
        """Where a bound is passed by more than a tolerance, the value's shape.

        Args:
            tolerance: As a share of the bound [-].
        """
        value = np.asarray(self.value, dtype=float)
        beyond = np.isnan(value)
        if self.lower is not None:
            beyond |= value < self.lower - tolerance * np.abs(self.lower) - 1e-9
        if self.upper is not None:
            beyond |= value > self.upper + tolerance * np.abs(self.upper) + 1e-9
        return beyond


class Cylinder(NamedTuple):
    """An upright cylinder without end, fixed to the ground.

    Attributes:
        east: Of its axis in [m].
        north: Of its axis in [m].
        radius: In [m].
        outside: Whether flight is allowed outside of it, else inside.
    """

    east: float
    north: float
    radius: float
    outside: bool


class Floor(NamedTuple):
    """A horizontal plane that is not to be flown below.

    Attributes:
        height: z in [m].
    """

    height: float


class Ball(NamedTuple):
    """A sphere about the target that is not to be flown into.

    Attributes:
        radius: In [m].
    """

    radius: float


Shape = Cylinder | Floor | Ball


@dataclass(frozen=True)
class Limit(Parameters):
    """Base of all limits. The fields of a subclass are its parameters.

    Attributes:
        name: By which it is found.
        hard_on_orbit: Whether every plan must end on an orbit that keeps it; else that is
            penalised, as at the stages.
        by_squares: Whether passing it at a stage is paid for by squares, so that plans may pass it
            a little: much easier to solve than a bound that is exact.
        of_rates: Whether :meth:`flown` needs turn rate and acceleration.
        on_ground: Whether :meth:`numbers` changes with the target's forecast.

    Raises:
        ParameterError: A value is not allowed.
    """

    name: ClassVar[str]
    hard_on_orbit: ClassVar[bool] = False
    by_squares: ClassVar[bool] = False
    of_rates: ClassVar[bool] = False
    on_ground: ClassVar[bool] = False

    @property
    def label(self) -> str:
        """Name for people and in results."""
        return self.name.replace("_", " ")

    @property
    def shapes(self) -> tuple[Shape, ...]:
        """Where in space it stands, for people to see; empty where it has no place."""
        return ()

    def numbers(self, targets: NDArray[np.float64]) -> NDArray[np.float64]:
        """What the problem is told of this limit at each stage: its parameters by default.

        A limit that is fixed to the ground moves as seen from a target that moves.

        Args:
            targets: Forecast of the target's position in ``map``, shape (n, 3), in [m].

        Returns:
            Shape (n, k), finite; k must not depend on values.
        """
        values = [np.ravel(getattr(self, field.name)) for field in dataclasses.fields(self)]
        return np.tile(np.concatenate([np.zeros(0), *values]), (len(targets), 1))

    def stage(self, motion: Motion, numbers: Any, xp: ModuleType) -> Bound | None:
        """The bounded quantity along the flight; None where only inputs or orbits are limited.

        Args:
            motion: Of the aircraft.
            numbers: A row of :meth:`numbers`, shape (k,), or columns of it for arrays of motions.
            xp: ``casadi`` for symbols, ``numpy`` for numbers.
        """
        return None

    def inputs(self, motion: Motion, numbers: Any, xp: ModuleType) -> dict[str, tuple[Any, Any]]:
        """Least and greatest values of inputs in a motion; least None is minus the greatest.

        Args:
            motion: Of the aircraft.
            numbers: As of :meth:`stage`, shape (k,).
            xp: ``casadi`` or ``numpy``.

        Returns:
            Bounds of some of ``turn_rate``, ``path_angle_rate`` and ``acceleration``.
        """
        return {}

    def orbit(self, shape: OrbitShape, numbers: Any, xp: ModuleType) -> Bound | None:
        """The bounded quantity of an orbit flown for ever, seen from the target.

        Args:
            shape: Of the orbit.
            numbers: As of :meth:`stage`, shape (k,).
            xp: ``casadi`` or ``numpy``.
        """
        return None

    def flown(self, motion: Motion, numbers: Any) -> Bound | None:
        """The bounded quantity of a flight that was flown; that of the stages by default.

        Args:
            motion: Arrays of shape (n,).
            numbers: Transpose of :meth:`numbers`, shape (k, n).
        """
        return self.stage(motion, numbers, np)

    def refusal(self, orbit: Orbit, drift: ArrayLike) -> str:
        """Why an orbit cannot be flown by this limit, in words; empty if it can.

        Args:
            orbit: What is asked for.
            drift: c, shape (3,), in [m/s].
        """
        return ""


LIMIT = ExtensionPoint("limit", Limit)
