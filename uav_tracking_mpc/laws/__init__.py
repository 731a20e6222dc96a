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

"""Guidance laws: where the aircraft is in, turn, climb and acceleration out.

==================  ===============================================================
``vector_field``    Lyapunov loiter vector field; also the controller's fallback
``l1``              L1 capture and circle tracking, as ArduPilot's
``npfg``            nonlinear path following with its handling of strong wind, as PX4's
``conformance``     whether a law keeps what the base asks for
==================  ===============================================================

A law is a subclass of :class:`GuidanceLaw` with a name. It is found by that name, by an entry point
in the group ``uav_tracking_mpc.laws``, or as ``path.py:Class``.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.parameters.registry import ExtensionPoint

if TYPE_CHECKING:
    from uav_tracking_mpc.estimation.situation import Situation
    from uav_tracking_mpc.limits.envelope import Envelope


CLIMB_GAIN = 0.45  # 1/s, climb rate asked for per height error
PATH_ANGLE_GAIN = 1.5  # 1/s
SPEED_GAIN = 0.8  # 1/s


class GuidanceLaw(ABC):
    """A law that circles the target.

    Args:
        orbit: What to fly.
        envelope: What can be flown.

    Attributes:
        name: By which it is found.
        sense: 1 counter-clockwise, -1 clockwise.
    """

    name: ClassVar[str]

    def __init__(self, orbit: Orbit, envelope: Envelope) -> None:
        self.orbit = orbit
        self.envelope = envelope
        self.sense = orbit.sense

    @abstractmethod
    def inputs(self, situation: Situation) -> NDArray[np.float64]:
        """Inputs for the present situation.

        Args:
            situation: Aircraft, target and drift now.

        Returns:
            (u_psi, u_chi, u_v), shape (3,), in [rad/s, rad/s, m/s^2], finite and inside the
            envelope.
        """


GUIDANCE_LAW = ExtensionPoint("guidance law", GuidanceLaw)


def altitude_hold(orbit: Orbit, envelope: Envelope, situation: Situation) -> tuple[float, float]:
    r"""Path-angle rate and acceleration that lead to the orbit's height and airspeed.

    The height error asks for a climb rate relative to the target, that for a path angle,

    .. math:: v \sin\chi_{des} + c_z = k_z (z_d - z)

    kept to those at which the airspeed can be held. The gains come from a grid of height steps of
    10 to 60 m at 22 m/s, with inner loops of 0.13 s lag and 0.2 s dead time: least integrated
    error without overshoot, and with about 5 % of it when the inner loops are twice as slow.

    Args:
        orbit: Height above the target and airspeed to hold.
        envelope: Limits of the path angle, and the least height, which comes before the orbit's.
        situation: Aircraft and target.

    Returns:
        (u_chi, u_v) in [rad/s, m/s^2], not yet clipped.
    """
    _, _, height, _, path_angle, speed = situation.vehicle.tolist()
    _, _, drift = situation.drift.tolist()
    _, _, ground = situation.target.tolist()
    wanted = ground + orbit.altitude
    # At the floor the target is not followed down, and of the vertical drift only that which may
    # be a sinking air counts.
    climb = max(
        CLIMB_GAIN * (wanted - height) - drift,
        CLIMB_GAIN * (envelope.height_min - height) - min(drift, 0.0),
    )
    lower, upper = envelope.path_angle_limits(speed)
    sine = climb / max(speed, 0.1 * orbit.speed)
    wanted_angle = math.asin(min(max(sine, math.sin(lower)), math.sin(upper)))
    return PATH_ANGLE_GAIN * (wanted_angle - path_angle), SPEED_GAIN * (orbit.speed - speed)
