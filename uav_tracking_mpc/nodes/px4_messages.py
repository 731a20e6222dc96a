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

r"""Messages of PX4's ROS 2 interface (px4_msgs) to measurements, and inputs to its set-points.

Fixed-wing set-points are there from PX4 1.17 on. In PX4's signs and frames (forward, right, down;
north, east, down):

.. math::

    a_{right} = -v\, u_\psi, \qquad \dot h = v \sin\chi_d, \qquad
    v_{equivalent} = v_d \sqrt{\rho / \rho_0},

where :math:`\chi_d` and :math:`v_d` integrate u_chi and u_v, not far from what is measured. Read in
msg/versioned/FixedWingLateralSetpoint.msg, FixedWingLongitudinalSetpoint.msg and
src/modules/fw_lateral_longitudinal_control of PX4.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from uav_tracking_mpc.dynamics.atmosphere import true_over_equivalent
from uav_tracking_mpc.dynamics.frames import course_rates_from_euler, heading_from_yaw
from uav_tracking_mpc.dynamics.geodesy import LocalFrame
from uav_tracking_mpc.dynamics.gravity import GRAVITY
from uav_tracking_mpc.estimation.measurement import Measurement, SensorNoise
from uav_tracking_mpc.estimation.told_noise import axes_noise

VELOCITY_FRAME_NED = 1  # of VehicleOdometry
LEAST_AIRSPEED = 3.0  # m/s
PATH_WINDOW, SPEED_WINDOW = 0.15, 3.0  # rad, m/s from what is measured
LONGEST_STEP = 0.2  # s
SOURCE_SYSTEM, SOURCE_COMPONENT = 1, 191  # an onboard computer


def topic(name: str, kind: Any) -> str:
    """Name of a topic, with the version that PX4 appends to those of versioned messages.

    Args:
        name: Such as ``/fmu/out/vehicle_status``.
        kind: Class of its messages.
    """
    version = getattr(kind, "MESSAGE_VERSION", 0)
    return f"{name}_v{version}" if version else name


def measurement(
    stamp: float, place: Any, odometry: Any, airspeed: Any, frame: LocalFrame
) -> Measurement | None:
    """State of the aircraft; None where a message does not tell what is needed.

    Args:
        stamp: Of the measurement in [s].
        place: VehicleGlobalPosition.
        odometry: VehicleOdometry.
        airspeed: AirspeedValidated, or None.
        frame: Axes of ``map``.
    """
    north, east, down = (float(value) for value in odometry.velocity)
    w, x, y, z = (float(value) for value in odometry.q)
    rates = [float(value) for value in odometry.angular_velocity]
    numbers = (place.lat, place.lon, place.alt, north, east, down, w, x, y, z, *rates)
    if odometry.velocity_frame != VELOCITY_FRAME_NED or not all(map(math.isfinite, numbers)):
        return None
    roll = math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    pitch = math.asin(max(-1.0, min(1.0, 2.0 * (w * y - z * x))))
    yaw = math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    turn_rate, nose_rate = course_rates_from_euler(roll, pitch, rates)
    speed = None if airspeed is None else float(airspeed.true_airspeed_m_s)
    if speed is None or not speed >= LEAST_AIRSPEED:  # also where it is not a number
        speed = None
        path_angle = math.atan2(-down, max(math.hypot(north, east), LEAST_AIRSPEED))
    else:
        path_angle = math.asin(max(-1.0, min(1.0, -down / speed)))
    return Measurement(
        stamp=stamp,
        position=frame.position(math.radians(place.lat), math.radians(place.lon), place.alt),
        ground_velocity=np.array([east, north, -down]),
        heading=heading_from_yaw(yaw),
        path_angle=path_angle,
        turn_rate=turn_rate,
        path_angle_rate=nose_rate,
        airspeed=speed,
        noise=SensorNoise(
            _axes_noise("position", odometry.position_variance),
            _axes_noise("velocity", odometry.velocity_variance),
        ),
    )


def _axes_noise(name: str, variances: Any) -> tuple[float, float, float]:
    """On the axes of ``map``, of variances to north, east and down."""
    north, east, down = (float(value) for value in variances)
    return axes_noise(name, (east, north, down))


class PathDemand:
    """Path angle and airspeed that the inputs lead to.

    Attributes:
        path_angle: chi_d in [rad].
        airspeed: v_d in [m/s].
    """

    def __init__(self) -> None:
        self.path_angle = self.airspeed = 0.0
        self._time = -math.inf

    def step(self, path_rate: float, gain: float, measured: Measurement, now: float) -> None:
        """Go on by the time since the last step; after a pause, from what is measured.

        Args:
            path_rate: u_chi in [rad/s].
            gain: u_v in [m/s^2].
            measured: With its airspeed.
            now: In [s].
        """
        duration, self._time = now - self._time, now
        airspeed = measured.airspeed or 0.0
        if duration > LONGEST_STEP:
            self.path_angle, self.airspeed, duration = measured.path_angle, airspeed, 0.0
        low, high = measured.path_angle - PATH_WINDOW, measured.path_angle + PATH_WINDOW
        self.path_angle = min(max(self.path_angle + path_rate * duration, low), high)
        low, high = airspeed - SPEED_WINDOW, airspeed + SPEED_WINDOW
        self.airspeed = min(max(self.airspeed + gain * duration, low), high)


def fill_lateral(message: Any, turn_rate: float, airspeed: float, bank_max: float) -> None:
    """Fill a FixedWingLateralSetpoint.

    Args:
        message: To be filled.
        turn_rate: u_psi in [rad/s].
        airspeed: v in [m/s].
        bank_max: Greatest bank in [rad], from which the greatest acceleration follows.
    """
    most = GRAVITY * math.tan(bank_max)
    message.course = message.airspeed_direction = math.nan
    message.lateral_acceleration = float(max(-most, min(most, -airspeed * turn_rate)))


def fill_longitudinal(message: Any, demand: PathDemand, airspeed: float, altitude: float) -> None:
    """Fill a FixedWingLongitudinalSetpoint.

    Args:
        message: To be filled.
        demand: Path angle and airspeed.
        airspeed: v in [m/s].
        altitude: Above sea level in [m].
    """
    message.altitude = message.pitch_direct = message.throttle_direct = math.nan
    message.height_rate = float(airspeed * math.sin(demand.path_angle))
    message.equivalent_airspeed = float(demand.airspeed / true_over_equivalent(altitude))


def fill_offboard(message: Any) -> None:
    """Fill an OffboardControlMode: of the flags the velocity alone.

    With it neither the mode manager nor an attitude set-point from outside is in charge
    (control_mode.cpp, ``getVehicleControlMode``), and the fixed-wing set-points are flown.

    Args:
        message: To be filled.
    """
    message.position = message.acceleration = message.attitude = message.body_rate = False
    message.velocity = True


def fill_command(message: Any, command: int, *parameters: float) -> None:
    """Fill a VehicleCommand, which has MAVLink's numbers.

    Args:
        message: To be filled.
        command: Of MAV_CMD.
        parameters: Up to seven, in the units of the command [SI]; the rest is 0.
    """
    values = (*parameters, *[0.0] * (7 - len(parameters)))
    for number, value in enumerate(values, start=1):
        setattr(message, f"param{number}", float(value))
    message.command = command
    message.target_system, message.target_component = 1, 1
    message.source_system, message.source_component = SOURCE_SYSTEM, SOURCE_COMPONENT
    message.from_external = True
