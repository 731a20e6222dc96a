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

"""What is looked at before a flight with any autopilot on MAVLink, in words; and its fence."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar, NamedTuple

import numpy as np

from uav_tracking_mpc.dynamics.orbit import FlownOrbit
from uav_tracking_mpc.estimation.flight_path import LEAST_AIRSPEED
from uav_tracking_mpc.links import Inspection
from uav_tracking_mpc.links.mavlink.dialect import mavlink
from uav_tracking_mpc.links.mavlink.listener import Listener
from uav_tracking_mpc.links.mavlink.telemetry import AIRSPEED_SENSOR, FARTHEST, Telemetry


class HomeFence(NamedTuple):
    """A cylinder; what it does not bound is infinite.

    Attributes:
        lowest: Least height above home in [m].
        highest: Greatest height above home in [m].
        radius: About home in [m].
    """

    lowest: float
    highest: float
    radius: float

    @property
    def kept(self) -> HomeFence:
        """What is left inside of it with a margin."""
        lowest, highest, radius = self
        return HomeFence(lowest + FENCE_MARGIN, highest - FENCE_MARGIN, radius - FENCE_MARGIN)

    def values(self, telemetry: Telemetry) -> dict[str, Any]:
        """The fence as parameters of the controller, by name, in [m]; empty while home is unknown.

        Args:
            telemetry: Of the autopilot.
        """
        home, frame = telemetry.home, telemetry.frame
        if home is None or frame is None:
            return {}
        east, north, up = frame.position(home.latitude, home.longitude, home.altitude).tolist()
        values: dict[str, Any] = {}
        if math.isfinite(self.radius):
            values.update(fence_radius=self.radius, fence_centre=(east, north))
        if math.isfinite(self.lowest):
            values["height_min"] = up + self.lowest
        return values

    def refusal(self, orbit: FlownOrbit, telemetry: Telemetry) -> str:
        """Why an orbit is not inside, in words; empty if it is, or while home is unknown.

        Args:
            orbit: To be flown.
            telemetry: Of the autopilot.
        """
        home, frame = telemetry.home, telemetry.frame
        if home is None or frame is None:
            return ""
        centre = home.position(*frame.place(orbit.centre))
        up = float(centre[2])
        farthest = math.hypot(*centre[:2].tolist()) + abs(orbit.radius)
        if not self.lowest <= up <= self.highest:
            return (
                f"the orbit's height of {up:.0f} m above home is not inside the autopilot's fence, "
                f"{self.lowest:.0f} to {self.highest:.0f} m"
            )
        if farthest > self.radius:
            return (
                f"the orbit leaves the autopilot's fence: {farthest:.0f} m from home, "
                f"{self.radius:.0f}"
            )
        return ""


BANK_KEPT = math.radians(2.0)  # rad, of the autopilot's limit, so that it is never reached
LEAST_TURN_BANK = math.radians(25.0)  # rad, at any airspeed: load factor 1.1
RATE_SHARE = 0.9  # -, of a greatest rate
FENCE_MARGIN = 10.0  # m, to the autopilot's own fence
UNKNOWN_AIRSPEED = 15.0  # m/s, for limits that depend on it where neither cruise nor flight tells
FIRMWARE_TYPES = {0: "dev", 64: "alpha", 128: "beta", 192: "rc", 255: "official"}
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


class VehicleEnvelope(ABC):
    """Limits of an autopilot, as the controller is to know them.

    Args:
        vehicle: Its parameters by name, in their own units [SI or deg].
        true_over_equivalent: True over equivalent airspeed where it flies [-].

    Attributes:
        names: Parameters that are asked for.
        cruise_name: Of the parameter that is the cruise airspeed.
        defaults: What the autopilot does where a parameter is not told.
        vehicle: As above.
        assumed: The same, with the defaults of what was not told.
        ratio: True over equivalent airspeed [-].
    """

    names: ClassVar[tuple[str, ...]]
    cruise_name: ClassVar[str]
    defaults: ClassVar[Mapping[str, float]] = {}

    def __init__(self, vehicle: Mapping[str, float], true_over_equivalent: float) -> None:
        self.vehicle, self.ratio = vehicle, true_over_equivalent
        self.assumed = {**self.defaults, **vehicle}

    @property
    def cruise(self) -> float | None:
        """Cruise airspeed, true, in [m/s]; None where it is not told."""
        equivalent = self.vehicle.get(self.cruise_name)
        return None if equivalent is None else equivalent * self.ratio

    def told(self, *names: str) -> list[float]:
        """Parameters in their own units [SI or deg]; nan, with which no comparison holds, for none.

        Args:
            names: Of the parameters.
        """
        return [self.vehicle.get(name, math.nan) for name in names]

    @abstractmethod
    def values(self, airspeed: float) -> dict[str, Any]:
        """Parameters of the controller, by name, in [SI].

        Args:
            airspeed: At which it is to fly, true, in [m/s].
        """

    @abstractmethod
    def bank_max(self, airspeed: float) -> float | None:
        """Greatest bank in [rad]; None where it is not told.

        Args:
            airspeed: True, in [m/s].
        """

    @abstractmethod
    def fence(self) -> HomeFence | None:
        """The autopilot's fence, with a margin; None without one."""

    @abstractmethod
    def refusals(self) -> list[str]:
        """Why it is not flown, in words."""

    @abstractmethod
    def warnings(self, telemetry_rate: float) -> list[str]:
        """What the pilot should know.

        Args:
            telemetry_rate: Asked for, in [Hz].
        """

    def turning(self, limit: float, airspeed: float, slowest: float) -> float | None:
        """Bank in [rad] that a limit and the load factor leave; None without a limit.

        The least airspeed grows with the root of the load factor; a small bank is always left.

        Args:
            limit: In [deg]; nan for none.
            airspeed: True, in [m/s].
            slowest: Least equivalent airspeed of level flight in [m/s]; 0 or nan for none.
        """
        if math.isnan(limit):
            return None
        if not slowest or math.isnan(slowest):
            return math.radians(limit)
        load = max((airspeed / self.ratio / slowest) ** 2, 1.0)
        return min(math.radians(limit), max(math.acos(1.0 / load), LEAST_TURN_BANK))


def inspection(
    heard: Listener, title: str, mode: str, handed_over: Sequence[str], envelope: VehicleEnvelope
) -> Inspection:
    """What was found at the other end.

    Args:
        heard: Of the autopilot.
        title: What people call it.
        mode: Name of its mode.
        handed_over: Modes from which command may be taken.
        envelope: Its limits.
    """
    flown = heard.telemetry.airspeed if heard.in_air else None
    values = envelope.values(envelope.cruise or flown or UNKNOWN_AIRSPEED)
    if (fence := envelope.fence()) is not None:
        values.update(fence.values(heard.telemetry))
    found = {
        "system": str(heard.system),
        "firmware": f"{title} {firmware(heard.latest.get('AUTOPILOT_VERSION'))}",
        "mode": mode,
        "armed": "yes" if heard.armed else "no",
        "in the air": "yes" if heard.in_air else "no",
        **{name: f"{value:g}" for name, value in envelope.vehicle.items()},
    }
    if envelope.cruise is not None:
        found["cruise airspeed, true"] = f"{envelope.cruise:.1f} m/s"
    refusals = (
        position_refusal(heard),
        airspeed_refusal(heard),
        state_refusal(heard, mode, handed_over),
        *envelope.refusals(),
    )
    warnings = envelope.warnings(heard.telemetry_rate)
    return Inspection(found, values, tuple(warnings), tuple(filter(None, refusals)))


def position_refusal(heard: Listener) -> str:
    """Why the position cannot be flown by, in words; empty if it can.

    Args:
        heard: Of the autopilot.
    """
    telemetry, latest = heard.telemetry, heard.latest
    status = latest.get("EKF_STATUS_REPORT", latest.get("ESTIMATOR_STATUS"))
    if status is not None and status.flags & NEEDED != NEEDED:
        return f"no position estimate: the filter's flags are {status.flags:#x}, lack {NEEDED:#x}"
    if telemetry.frame is None:
        return "no home position: it is the origin of map unless another is stated (--origin)"
    if telemetry.distance > FARTHEST:
        return (
            f"the position is {1e-3 * telemetry.distance:.0f} km from the origin of map, must be "
            f"within {1e-3 * FARTHEST:.0f} km: home may be another aircraft's, or --origin wrong"
        )
    if telemetry.newest is None:
        missing = "attitude" if telemetry.attitude is None else "position"
        return f"no {missing}: GLOBAL_POSITION_INT and ATTITUDE must both come, close together"
    return ""


def state_refusal(heard: Listener, mode: str, handed_over: Sequence[str]) -> str:
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
    if mode not in handed_over:
        return f"mode is {mode}, must be one of {', '.join(handed_over)} to take command from"
    return ""


def airspeed_refusal(heard: Listener) -> str:
    """Why the airspeed cannot be flown by, in words; empty if it can.

    Args:
        heard: Of the autopilot.
    """
    if (sensors := heard.latest.get("SYS_STATUS")) is not None:
        for name in ("present", "enabled", "health"):
            if not getattr(sensors, f"onboard_control_sensors_{name}") & AIRSPEED_SENSOR:
                fault = "is not healthy" if name == "health" else f"is not {name}"
                return f"no airspeed: the sensor {fault}"
    if heard.in_air and (heard.telemetry.airspeed or 0.0) < LEAST_AIRSPEED:
        return "no airspeed: VFR_HUD tells none"
    return ""


def applying(*findings: tuple[bool, str]) -> list[str]:
    """Words of what applies.

    Args:
        findings: Whether each applies, and its words.
    """
    return [words for applies, words in findings if applies]


def known(values: Mapping[str, Any]) -> dict[str, Any]:
    """Values that are known as a whole.

    Args:
        values: Numbers, or several numbers, by name; nan for what is not known.
    """
    return {name: value for name, value in values.items() if not np.isnan(value).any()}


def climb_angle(climb: float, airspeed: float) -> float:
    """Path angle in [rad] of a climb rate.

    Args:
        climb: In [m/s].
        airspeed: In [m/s], positive.
    """
    return math.asin(max(min(climb / airspeed, 1.0), -1.0))  # in this order nan stays nan
