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

"""(9) as printed: (11) but for the bearing."""

from __future__ import annotations

from typing import Any

import casadi as ca

from uav_tracking_mpc.dynamics.relative import RelativeState
from uav_tracking_mpc.dynamics.relative_models.paper import Paper


class Paper9(Paper):
    """(9) as printed: (11) but for the bearing."""

    name = "paper9"

    def rates(self, state: RelativeState, inputs: Any) -> list[Any]:
        """See :meth:`RelativeModel.rates`."""
        r, theta, z, chi, v = state
        rates = super().rates(state, inputs)
        rates[1] = v * r * ca.cos(chi) ** 2 * ca.sin(theta) / (r**2 - z**2) + inputs[0]  # (9b)
        return rates
