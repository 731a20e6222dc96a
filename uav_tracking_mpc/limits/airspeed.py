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

r"""Limits along the path: airspeed, acceleration, and the force that a climb shares with it.

The specific force along the path, thrust less drag over mass, is bounded by

.. math:: f_{min}(v) \le g \sin\chi + u_v \le f_{max}(v)

where both bounds are linear in the airspeed, given at its limits.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uav_tracking_mpc.dynamics import paper_numbers as paper
from uav_tracking_mpc.dynamics.air import GRAVITY
from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.limits import Bound, Limit, Motion, OrbitShape
from uav_tracking_mpc.parameters.specification import ParameterError, parameter


@dataclass(frozen=True)
class AirspeedSpan(Limit):
    """A limit that knows the least and the greatest airspeed."""

    airspeed_min: float = parameter(0.0, "Least airspeed.", "m/s", 0.0, 300.0)
    airspeed_max: float = parameter(20.0, "Greatest airspeed.", "m/s", 0.1, 400.0)

    def __post_init__(self) -> None:
        """Refuse a span that is empty."""
        super().__post_init__()
        if not self.airspeed_max > self.airspeed_min:
            raise ParameterError(
                f"parameter 'airspeed_max' is {self.airspeed_max:g}, must be above "
                f"'airspeed_min' = {self.airspeed_min:g} m/s"
            )


@dataclass(frozen=True)
class Airspeed(AirspeedSpan):
    """airspeed_min <= v <= airspeed_max, also on the orbit that a plan ends on."""

    name = "airspeed"
    hard_on_orbit = True

    def stage(self, motion: Motion, numbers: Any, xp: ModuleType) -> Bound:
        """See :meth:`Limit.stage`."""
        return Bound(motion.airspeed, numbers[0], numbers[1])

    def orbit(self, shape: OrbitShape, numbers: Any, xp: ModuleType) -> Bound:
        """See :meth:`Limit.orbit`."""
        return Bound(shape.airspeed, numbers[0], numbers[1])

    def refusal(self, orbit: Orbit, drift: ArrayLike) -> str:
        """See :meth:`Limit.refusal`."""
        if self.airspeed_min <= orbit.speed <= self.airspeed_max:
            return ""
        return (
            f"an airspeed of {orbit.speed:.3g} m/s is not between {self.airspeed_min:.3g} and "
            f"{self.airspeed_max:.3g} m/s"
        )


@dataclass(frozen=True)
class Acceleration(Limit):
    """acceleration_min <= u_v <= acceleration_max."""

    name = "acceleration"

    acceleration_min: float = parameter(
        -paper.ACCELERATION_BOUND, "Least acceleration u_v.", "m/s^2", -100.0, -1e-3
    )
    acceleration_max: float = parameter(
        paper.ACCELERATION_BOUND, "Greatest acceleration u_v.", "m/s^2", 1e-3, 100.0
    )

    def inputs(self, motion: Motion, numbers: Any, xp: ModuleType) -> dict[str, tuple[Any, Any]]:
        """See :meth:`Limit.inputs`."""
        return {"acceleration": (numbers[0], numbers[1])}


# Kept back in plans: within a stage, and while commands take effect, path angle and airspeed move
# on, and the limits of the acceleration with them.
PLANNED_MARGIN = 0.2  # m/s^2


@dataclass(frozen=True)
class Force(AirspeedSpan):
    """force_min(v) <= g sin(chi) + u_v <= force_max(v), linear between the ends of the airspeed.

    Beyond the ends, where the limit of the airspeed is passed already, commands are held to the
    values at the ends; plans continue the lines, so that their expressions stay smooth.
    """

    name = "force"
    of_rates = True

    force_min: tuple[float, ...] = parameter(
        (-20.0, -20.0),
        "Least thrust less drag, over mass, at airspeed_min and at airspeed_max.",
        "m/s^2",
        -100.0,
        100.0,
        size=2,
    )
    force_max: tuple[float, ...] = parameter(
        (20.0, 20.0),
        "Greatest thrust less drag, over mass, at airspeed_min and at airspeed_max.",
        "m/s^2",
        -100.0,
        100.0,
        size=2,
    )

    def __post_init__(self) -> None:
        """Refuse limits that contradict each other."""
        super().__post_init__()
        if not all(
            least < most for least, most in zip(self.force_min, self.force_max, strict=True)
        ):
            raise ParameterError(
                f"parameter 'force_max' is {list(self.force_max)}, must be above 'force_min' = "
                f"{list(self.force_min)} m/s^2 at both airspeeds"
            )

    def numbers(self, targets: NDArray[np.float64]) -> NDArray[np.float64]:
        """See :meth:`Limit.numbers`.

        Returns:
            Least and greatest planned force at rest, and their slopes over v, shape (n, 4).
        """
        span, (least, most) = self.airspeed_max - self.airspeed_min, self._lines(0.0)
        slopes = [(fast - slow) / span for slow, fast in (self.force_min, self.force_max)]
        lines = [least + PLANNED_MARGIN, slopes[0], most - PLANNED_MARGIN, slopes[1]]
        return np.tile(lines, (len(targets), 1))

    def _lines(self, airspeed: Any) -> tuple[Any, Any]:
        """Least and greatest specific force on the lines, beyond their ends too, in [m/s^2]."""
        share = (airspeed - self.airspeed_min) / (self.airspeed_max - self.airspeed_min)
        (least, least_fast), (most, most_fast) = self.force_min, self.force_max
        return least + share * (least_fast - least), most + share * (most_fast - most)

    def force_limits(self, airspeed: float) -> tuple[float, float]:
        """Least and greatest specific force in [m/s^2].

        Args:
            airspeed: v in [m/s]; outside of its span the limits are those at its ends.
        """
        return self._lines(min(self.airspeed_max, max(self.airspeed_min, airspeed)))

    def inputs(self, motion: Motion, numbers: Any, xp: ModuleType) -> dict[str, tuple[Any, Any]]:
        """See :meth:`Limit.inputs`."""
        weight = GRAVITY * xp.sin(motion.path_angle)
        least, least_slope, most, most_slope = (numbers[k] for k in range(4))
        v = motion.airspeed
        return {"acceleration": (least + least_slope * v - weight, most + most_slope * v - weight)}

    def flown(self, motion: Motion, numbers: Any) -> Bound:
        """See :meth:`Limit.flown`: thrust less drag, over mass."""
        within = np.clip(motion.airspeed, self.airspeed_min, self.airspeed_max)
        force = GRAVITY * np.sin(motion.path_angle) + motion.acceleration
        return Bound(force, *self._lines(within))


def arcsine(sine: float) -> float:
    """Arc sine in [rad], a right angle beyond its domain.

    Args:
        sine: In [-].
    """
    return math.asin(min(1.0, max(-1.0, sine)))
