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

"""The kinematics (3) seen from the target, as they are and as the paper prints them.

(11) is printed at theta = pi/2 + x_2 and stands here for any bearing.
"""

from __future__ import annotations

from typing import Any

import casadi as ca

from uav_tracking_mpc.dynamics.relative_models import RelativeModel, RelativeState
from uav_tracking_mpc.dynamics.vehicle import air_velocity


class Exact(RelativeModel):
    """The kinematics (3) seen from the target, no approximation."""

    name = "exact"

    def rates(self, state: RelativeState, inputs: Any) -> list[Any]:
        """See :meth:`RelativeModel.rates`."""
        r, theta, z, chi, v = state
        u_psi, u_chi, u_v = inputs
        d = ca.sqrt(r**2 - z**2)
        # theta is the heading counted from the direction that points at the target.
        inward, across, climb = air_velocity(theta, chi, v, ca)
        return [(climb * z - inward * d) / r, across / d + u_psi, climb, u_chi, u_v]


class Paper(RelativeModel):
    """(11) as printed, for any bearing; it is printed at theta = pi/2 + x_2."""

    name = "paper"

    def rates(self, state: RelativeState, inputs: Any) -> list[Any]:
        """See :meth:`RelativeModel.rates`."""
        r, theta, _, chi, v = state
        u_psi, u_chi, u_v = inputs
        level = ca.cos(chi) ** 2
        return [
            v * (ca.sin(chi) ** 2 - ca.cos(theta) * level),  # (9a), (11a)
            v * level * ca.sin(theta) / (r * (1.0 - ca.sin(chi) ** 2)) + u_psi,  # (11b)
            v * ca.sin(chi),  # (9c), (11c)
            u_chi,  # (9d), (11d)
            u_v,  # (9e), (11e)
        ]


class Paper9(Paper):
    """(9) as printed: (11) but for the bearing."""

    name = "paper9"

    def rates(self, state: RelativeState, inputs: Any) -> list[Any]:
        """See :meth:`RelativeModel.rates`."""
        r, theta, z, chi, v = state
        rates = super().rates(state, inputs)
        rates[1] = v * r * ca.cos(chi) ** 2 * ca.sin(theta) / (r**2 - z**2) + inputs[0]  # (9b)
        return rates
