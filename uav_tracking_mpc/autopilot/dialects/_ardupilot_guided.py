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

"""What ArduPlane is told in GUIDED and keeps until its mode changes."""

from __future__ import annotations

import math

from uav_tracking_mpc.autopilot.flight_loops import TICK
from uav_tracking_mpc.autopilot.numbers import AttitudeTarget

STALE_ALTITUDE = 0.1  # s for which a new guided point leaves TECS with the altitude of now
AT_ONCE = 1000.0  # m/s or m/s^2: what a rate of 0 stands for, P/GCS_MAVLink_Plane.cpp
TECS_PERIOD = 0.1  # s, of the 10 Hz at which guided altitudes are led on
ATTITUDE_BIT, THROTTLE_BIT = 0b10000000, 0b01000000  # of type_mask
AXIS_BITS = {"roll": 0b001, "pitch": 0b010, "yaw": 0b100}


class Guided:
    """P/Plane.h, ``guided_state``; a mode change begins a new one (P/mode.cpp, ``Mode::enter``).

    Attributes:
        radius: Of the loiter in [m]; 0 for WP_LOITER_RAD.
        moved: When the guided point was last set in [s].
        altitude: Height in ``map`` [m] and rate [m/s] that 43001 asks for; None without one.
        speed: Calibrated airspeed [m/s] and acceleration [m/s^2] of 43000; None without one.
        changed_speed: Calibrated airspeed of DO_CHANGE_SPEED in [m/s]; None without one.
    """

    def __init__(self) -> None:
        self.radius = 0.0
        self.moved = -math.inf
        self.altitude: tuple[float, float] | None = None
        self.speed: tuple[float, float] | None = None
        self.changed_speed: float | None = None
        self._forced: dict[str, tuple[float, float]] = {}  # value and since when, by axis

    def force(self, target: AttitudeTarget, now: float) -> None:
        """P/GCS_MAVLink_Plane.cpp, ``handle_set_attitude_target``.

        Where the attitude is not left out all three axes are forced, whatever the bits of the
        rates say.

        Args:
            target: The message.
            now: In [s].
        """
        taken = ~target.mask & 0xFF
        values = {"roll": target.roll, "pitch": target.pitch, "yaw": 0.0}
        for axis, bit in AXIS_BITS.items():
            if taken & (ATTITUDE_BIT | bit):
                self._forced[axis] = (values[axis], now)
        if taken & THROTTLE_BIT:
            self._forced["throttle"] = (target.thrust, now)

    def value(self, axis: str, now: float, memory: float) -> float | None:
        """What is forced on an axis, roll and pitch in [rad]; None where nothing is, or not now.

        Args:
            axis: ``roll``, ``pitch``, ``yaw`` or ``throttle``.
            now: In [s].
            memory: For how long it is forced in [s].
        """
        value, since = self._forced.get(axis, (0.0, -math.inf))
        return value if now - since < memory else None

    def altitude_now(self, up: float, point: float, now: float) -> float:
        """Height in ``map`` in [m] that TECS is told; ``ModeGuided::update_target_altitude``.

        Args:
            up: Of the aircraft in [m].
            point: Of the guided point in [m].
            now: In [s].
        """
        if now - self.moved < STALE_ALTITUDE:
            return up  # P/commands.cpp, set_guided_WP: until the next turn of 10 Hz
        if self.altitude is None:
            return point
        wanted, rate = self.altitude
        # The rate leads on from where it is now, not from the last target: it hardly climbs.
        step = (rate or AT_ONCE) * TECS_PERIOD
        return min(max(wanted, up - step), up + step)

    def speed_now(self, before: float, cruise: float) -> float:
        """Calibrated airspeed in [m/s] that is asked for; P/navigation.cpp, calc_airspeed_errors.

        Args:
            before: That of a tick ago in [m/s].
            cruise: AIRSPEED_CRUISE in [m/s].
        """
        if self.speed is None:
            return cruise if self.changed_speed is None else self.changed_speed
        wanted, rate = self.speed
        step = (rate or AT_ONCE) * TICK
        return min(max(wanted, before - step), before + step)
