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

"""Least and greatest airspeed."""

from __future__ import annotations

from dataclasses import dataclass
from types import ModuleType
from typing import Any

from numpy.typing import ArrayLike

from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.limits import Bound, Motion, OrbitShape
from uav_tracking_mpc.limits._airspeed_span import AirspeedSpan


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
