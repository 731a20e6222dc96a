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

"""Models of the motion relative to the target, state (r, theta, z, chi, v).

``kinematics`` holds them by their names: ``exact``, the kinematics (3) in these coordinates without
approximation; ``paper``, (11) as printed, which is (9) with r^2 - z_p^2 replaced by r^2 cos^2(chi);
and ``paper9``, (9) itself.

theta = psi - phi - pi with phi = atan2(y, x), the azimuth of the UAV seen from the target; the
inputs are (u_psi, u_chi, u_v). (6), (7) and hence (9) replace d/r by cos(chi) and z/r by sin(chi),
d = sqrt(r^2 - z^2): true only when the path angle equals the target's elevation. Their steady turns
differ from the true one, so a controller that predicts with them holds a constant range offset on
the true vehicle.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, ClassVar, NamedTuple

from uav_tracking_mpc.parameters.registry import ExtensionPoint


class RelativeState(NamedTuple):
    """State (r, theta, z, chi, v) by name; an array of shape (5,) in this order is the same.

    Attributes:
        range: r, distance to the target [m].
        bearing: theta = psi - phi - pi, wrapped to (-pi, pi] [rad].
        altitude: z, height above the target [m].
        path_angle: chi, positive when climbing [rad].
        speed: v [m/s].
    """

    range: Any
    bearing: Any
    altitude: Any
    path_angle: Any
    speed: Any


class RelativeModel(ABC):
    """Base of the models; derivatives are made from :meth:`rates` by machine.

    Attributes:
        name: By which it is found.
    """

    name: ClassVar[str]

    @abstractmethod
    def rates(self, state: RelativeState, inputs: Any) -> list[Any]:
        """Time derivative of the state, as CasADi symbols.

        Args:
            state: Symbols.
            inputs: (u_psi, u_chi, u_v), three symbols.

        Returns:
            Five expressions, in the order of the state.
        """


RELATIVE_MODEL = ExtensionPoint("prediction model", RelativeModel)
