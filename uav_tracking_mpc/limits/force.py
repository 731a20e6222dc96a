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

r"""Specific force along the path, thrust less drag over mass: a climb and an acceleration share it.

.. math:: f_{min}(v) \le g \sin\chi + u_v \le f_{max}(v)

Both bounds are linear in the airspeed, given at its limits.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.gravity import GRAVITY
from uav_tracking_mpc.limits import Bound, Motion
from uav_tracking_mpc.limits._airspeed_span import AirspeedSpan
from uav_tracking_mpc.parameters.specification import ParameterError, parameter

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
        lines = []
        for (slow, fast), kept in (
            (self.force_min, PLANNED_MARGIN),
            (self.force_max, -PLANNED_MARGIN),
        ):
            slope = (fast - slow) / (self.airspeed_max - self.airspeed_min)
            lines += [slow - slope * self.airspeed_min + kept, slope]
        return np.tile(lines, (len(targets), 1))

    def force_limits(self, airspeed: float) -> tuple[float, float]:
        """Least and greatest specific force in [m/s^2].

        Args:
            airspeed: v in [m/s]; outside of its span the limits are those at its ends.
        """
        span = self.airspeed_max - self.airspeed_min
        share = min(1.0, max(0.0, (airspeed - self.airspeed_min) / span))
        lower, upper = (
            slow + share * (fast - slow) for slow, fast in (self.force_min, self.force_max)
        )
        return lower, upper

    def path_angles(self, airspeed: float) -> tuple[float, float]:
        """Least and greatest path angle in [rad] at which an airspeed can be held.

        Args:
            airspeed: v in [m/s].
        """
        lower, upper = self.force_limits(airspeed)
        return arcsine(lower / GRAVITY), arcsine(upper / GRAVITY)

    def inputs(self, motion: Motion, numbers: Any, xp: ModuleType) -> dict[str, tuple[Any, Any]]:
        """See :meth:`Limit.inputs`."""
        weight = GRAVITY * xp.sin(motion.path_angle)
        least, least_slope, most, most_slope = (numbers[k] for k in range(4))
        v = motion.airspeed
        return {"acceleration": (least + least_slope * v - weight, most + most_slope * v - weight)}

    def flown(self, motion: Motion, numbers: Any) -> Bound:
        """See :meth:`Limit.flown`: thrust less drag, over mass."""
        span = (self.airspeed_min, self.airspeed_max)
        return Bound(
            GRAVITY * np.sin(motion.path_angle) + motion.acceleration,
            np.interp(motion.airspeed, span, self.force_min),
            np.interp(motion.airspeed, span, self.force_max),
        )


def arcsine(sine: float) -> float:
    """Arc sine in [rad], a right angle beyond its domain.

    Args:
        sine: In [-].
    """
    return math.asin(min(1.0, max(-1.0, sine)))
