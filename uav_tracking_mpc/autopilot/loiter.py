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

"""A circle that the autopilot flies by itself, and the bank that leads onto it."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from uav_tracking_mpc.autopilot.airframe import FlightState
from uav_tracking_mpc.dynamics.gravity import GRAVITY
from uav_tracking_mpc.dynamics.orbit import CLOCKWISE, COUNTER_CLOCKWISE, Orbit
from uav_tracking_mpc.estimation.situation import Situation
from uav_tracking_mpc.laws.l1 import L1Loiter
from uav_tracking_mpc.limits._envelope import Envelope

LEAST_RADIUS, GREATEST_RADIUS = 1.0, 1e6  # m
LEAST_PERIOD = 1.0  # s


class Loiter(NamedTuple):
    """A horizontal circle.

    Attributes:
        east: Of its centre in ``map`` in [m].
        north: Of its centre in ``map`` in [m].
        up: Height in ``map`` in [m].
        radius: In [m], positive.
        clockwise: Its direction, seen from above.
    """

    east: float
    north: float
    up: float
    radius: float
    clockwise: bool


class LoiterLaw:
    """The L1 law of :mod:`uav_tracking_mpc.laws.l1` about a point that stands.

    ArduPilot: ``AP_L1_Control::update_loiter`` and ``nav_roll_cd``. PX4 flies NPFG about a loiter
    (``FixedWingModeManager``); the simulated one flies this law there too.
    """

    def __init__(self) -> None:
        self._envelope = Envelope()  # that of a law, which only its climb and its clipping use

    def bank(self, state: FlightState, loiter: Loiter, period: float, damping: float) -> float:
        """Bank to the right in [rad] that leads onto the circle.

        Args:
            state: Of the aircraft.
            loiter: The circle.
            period: NAVL1_PERIOD in [s].
            damping: NAVL1_DAMPING [-].
        """
        direction = CLOCKWISE if loiter.clockwise else COUNTER_CLOCKWISE
        radius = min(max(loiter.radius, LEAST_RADIUS), GREATEST_RADIUS)
        orbit = Orbit(radius, 0.0, max(state.airspeed, 1.0), direction)
        course = math.atan2(state.north_rate, state.east_rate)
        over_ground = [state.east, state.north, 0.0, course, 0.0, state.groundspeed]
        situation = Situation(
            vehicle=np.array(over_ground),
            target=np.array([loiter.east, loiter.north, 0.0]),
            drift=np.zeros(3),
            drift_rate=np.zeros(3),
            rates=np.zeros(3),
        )
        law = L1Loiter(orbit, self._envelope, max(period, LEAST_PERIOD), abs(damping))
        return -math.atan(law.lateral_acceleration(situation) / GRAVITY)
