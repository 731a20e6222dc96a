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

"""Guidance laws, one file each: where the aircraft is in, turn, climb and acceleration out.

==================  ===============================================================
``vector_field``    Lyapunov loiter vector field; also the controller's fallback
``l1``              L1 capture and circle tracking, as ArduPilot's
``npfg``            nonlinear path following with its handling of strong wind, as PX4's
==================  ===============================================================

A law is a subclass of :class:`GuidanceLaw` in a file of its own name. It is found by that name, by
an entry point in the group ``uav_tracking_mpc.laws``, or as ``path.py:Class``;
:func:`uav_tracking_mpc.laws._check.check_law` tells its author whether it keeps what the base asks
for.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.orbit import Orbit

if TYPE_CHECKING:
    from uav_tracking_mpc.estimation.situation import Situation
    from uav_tracking_mpc.limits._envelope import Envelope


class GuidanceLaw(ABC):
    """A law that circles the target.

    Args:
        orbit: What to fly.
        envelope: What can be flown.

    Attributes:
        name: By which it is found.
    """

    name: ClassVar[str]

    def __init__(self, orbit: Orbit, envelope: Envelope) -> None:
        self.orbit = orbit
        self.envelope = envelope

    @abstractmethod
    def inputs(self, situation: Situation) -> NDArray[np.float64]:
        """Inputs for the present situation.

        Args:
            situation: Aircraft, target and drift now.

        Returns:
            (u_psi, u_chi, u_v), shape (3,), in [rad/s, rad/s, m/s^2], finite and inside the
            envelope.
        """
