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

"""The kinematics (3) seen from the target, no approximation."""

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
