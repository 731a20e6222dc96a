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

"""Greatest turn rate, whatever the airspeed."""

from __future__ import annotations

from dataclasses import dataclass
from types import ModuleType
from typing import Any

from uav_tracking_mpc.dynamics import paper_numbers as paper
from uav_tracking_mpc.dynamics.drift import sharpest_turn
from uav_tracking_mpc.limits import COMPILED, Bound, Limit, Motion, OrbitShape
from uav_tracking_mpc.limits._turn import TURN_RATE_SHARE
from uav_tracking_mpc.parameters.specification import parameter


@dataclass(frozen=True)
class YawRate(Limit):
    """abs(u_psi) <= yaw_rate_max."""

    name = "yaw_rate"
    hard_on_orbit = True

    yaw_rate_max: float = parameter(
        paper.TURN_RATE_BOUND,
        "Greatest yaw rate u_psi, either way.",
        "rad/s",
        1e-3,
        10.0,
        fixed_unless=COMPILED,
    )

    def inputs(self, motion: Motion, numbers: Any, xp: ModuleType) -> dict[str, tuple[Any, Any]]:
        """See :meth:`Limit.inputs`."""
        return {"turn_rate": (None, numbers[0])}

    def orbit(self, shape: OrbitShape, numbers: Any, xp: ModuleType) -> Bound:
        """See :meth:`Limit.orbit`."""
        turn = sharpest_turn(shape.radius, shape.airspeed, shape.drift)
        return Bound(turn / (TURN_RATE_SHARE * numbers[0]), upper=1.0)
