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

"""What is looked at before a flight with any autopilot on MAVLink, in words."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any, Protocol

from uav_tracking_mpc.links import Inspection
from uav_tracking_mpc.links.mavlink.dialect import mavlink
from uav_tracking_mpc.links.mavlink.home_fence import HomeFence
from uav_tracking_mpc.links.mavlink.listener import Listener
from uav_tracking_mpc.links.mavlink.telemetry import LEAST_AIRSPEED, Telemetry

UNKNOWN_AIRSPEED = 15.0  # m/s, for limits that depend on it where neither cruise nor flight tells
FIRMWARE_TYPES = {0: "dev", 64: "alpha", 128: "beta", 192: "rc", 255: "official"}
AIRSPEED_SENSOR = mavlink.MAV_SYS_STATUS_SENSOR_DIFFERENTIAL_PRESSURE
# Attitude, velocity and absolute position, horizontal and vertical: EKF_STATUS_FLAGS of ArduPilot
# and ESTIMATOR_STATUS_FLAGS of the common messages are alike in these bits.
NEEDED = (
    mavlink.EKF_ATTITUDE
    | mavlink.EKF_VELOCITY_HORIZ
    | mavlink.EKF_VELOCITY_VERT
    | mavlink.EKF_POS_HORIZ_ABS
    | mavlink.EKF_POS_VERT_ABS
)


def firmware(version: Any) -> str:
    """Version of the firmware, such as ``4.5.7 official``; ``unknown`` where it was not told.

    Args:
        version: AUTOPILOT_VERSION, or None.
    """
    if version is None:
        return "unknown"
    number = version.flight_sw_version
    kind = FIRMWARE_TYPES.get(number & 0xFF, str(number & 0xFF))
    return f"{number >> 24}.{number >> 16 & 0xFF}.{number >> 8 & 0xFF} {kind}"


class VehicleEnvelope(Protocol):
    """What an autopilot's parameters allow."""

    @property
    def cruise(self) -> float | None:
        """Cruise airspeed, true, in [m/s]; None where it is not told."""

    def values(self, airspeed: float) -> dict[str, Any]:
        """Parameters of the controller, by name, in [SI].

        Args:
            airspeed: At which it is to fly, true, in [m/s].
        """

    def fence(self) -> HomeFence | None:
        """The autopilot's fence; None without one."""


def inspection(
    heard: Listener,
    told: Mapping[str, str],
    vehicle: Mapping[str, float],
    envelope: VehicleEnvelope,
    warnings: Iterable[str],
    refusals: Iterable[str],
) -> Inspection:
    """What was found at the other end, put together.

    Args:
        heard: Of the autopilot.
        told: Its firmware and its mode, in words.
        vehicle: Its parameters by name, in their own units [SI or deg].
        envelope: That they leave.
        warnings: What the pilot should know.
        refusals: Why this autopilot cannot be flown; empty ones count for nothing.
    """
    flown = heard.telemetry.airspeed if heard.in_air else None
    values = envelope.values(envelope.cruise or flown or UNKNOWN_AIRSPEED)
    if (fence := envelope.fence()) is not None:
        values.update(fence.values(heard.telemetry))
    found = {
        "system": str(heard.system),
        **told,
        "armed": "yes" if heard.armed else "no",
        "in the air": "yes" if heard.in_air else "no",
        **{name: f"{value:g}" for name, value in vehicle.items()},
    }
    if envelope.cruise is not None:
        found["cruise airspeed, true"] = f"{envelope.cruise:.1f} m/s"
    every = (
        position_refusal(heard.telemetry, heard.status),
        airspeed_refusal(heard.telemetry, heard.sensors, heard.in_air),
        *refusals,
    )
    return Inspection(found, values, tuple(warnings), tuple(filter(None, every)))


def position_refusal(telemetry: Telemetry, status: Any) -> str:
    """Why the position cannot be flown by, in words; empty if it can.

    Args:
        telemetry: What was heard.
        status: EKF_STATUS_REPORT or ESTIMATOR_STATUS, or None.
    """
    if status is not None and status.flags & NEEDED != NEEDED:
        return f"no position estimate: the filter's flags are {status.flags:#x}, lack {NEEDED:#x}"
    if telemetry.frame is None:
        return "no home position: it is the origin of map unless another is stated (--origin)"
    if telemetry.newest is None:
        missing = "attitude" if telemetry.attitude is None else "position"
        return f"no {missing}: GLOBAL_POSITION_INT and ATTITUDE must both come, close together"
    return ""


def state_refusal(heard: Listener, mode: str, handed_over: Iterable[str]) -> str:
    """Why command cannot be taken as the aircraft is, in words; empty if it can.

    Args:
        heard: Of the autopilot.
        mode: Name of its mode.
        handed_over: Modes from which command may be taken.
    """
    if not heard.armed:
        return "disarmed: arm and take off first, this program does neither"
    if not heard.in_air:
        return "on the ground: take off first, this program does not"
    allowed = tuple(handed_over)
    if mode not in allowed:
        return f"mode is {mode}, must be one of {', '.join(allowed)} to take command from"
    return ""


def airspeed_refusal(telemetry: Telemetry, sensors: Any, flying: bool) -> str:
    """Why the airspeed cannot be flown by, in words; empty if it can.

    Args:
        telemetry: What was heard.
        sensors: SYS_STATUS, or None.
        flying: Whether the aircraft is in the air.
    """
    if sensors is not None:
        for name in ("present", "enabled", "health"):
            if not getattr(sensors, f"onboard_control_sensors_{name}") & AIRSPEED_SENSOR:
                fault = "is not healthy" if name == "health" else f"is not {name}"
                return f"no airspeed: the sensor {fault}"
    if flying and (telemetry.airspeed or 0.0) < LEAST_AIRSPEED:
        return "no airspeed: VFR_HUD tells none"
    return ""


def first_of(parameters: Mapping[str, float], *names: str) -> float | None:
    """The first of some parameters that the autopilot has, in its own unit.

    Args:
        parameters: Of the autopilot, by name, in their own units [SI or deg].
        names: One meaning, as different versions call it.
    """
    return next((parameters[name] for name in names if name in parameters), None)


def climb_angle(climb: float, airspeed: float) -> float:
    """Path angle in [rad] of a climb rate.

    Args:
        climb: In [m/s].
        airspeed: In [m/s], positive.
    """
    return math.asin(max(-1.0, min(1.0, climb / airspeed)))
