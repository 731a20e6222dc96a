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

"""PX4 over its own ROS 2 interface (uXRCE-DDS), as a link of the node ``autopilot_link``.

It needs px4_msgs in the workspace, of PX4 1.17 or later, and is asked for by its file::

    --link .../uav_tracking_mpc/nodes/px4_ros_link.py:Px4RosLink

Lateral acceleration, height rate and equivalent airspeed are PX4's to hold, and so are its limits.
It was read in PX4's sources, and never flown.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.flown_orbit import FlownOrbit
from uav_tracking_mpc.dynamics.geodesy import LocalFrame
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.links import Inspection, LinkError, VehicleLink
from uav_tracking_mpc.links.mavlink.engagement import Engagement, State
from uav_tracking_mpc.nodes.px4_messages import (
    PathDemand,
    fill_command,
    fill_lateral,
    fill_longitudinal,
    fill_offboard,
    measurement,
)
from uav_tracking_mpc.nodes.px4_topics import RosWire, Wire
from uav_tracking_mpc.settings.link import LinkParameters
from uav_tracking_mpc.simulation.plan_follower import PlanFollower

OFFBOARD, ARMED = 14, 2  # nav_state, arming_state of VehicleStatus
MODES = {0: "MANUAL", 1: "ALTITUDE", 2: "POSITION", 3: "MISSION", 4: "HOLD", 5: "RETURN",
         14: "OFFBOARD"}  # fmt: skip
HANDED_OVER = ("HOLD", "MISSION", "POSITION", "OFFBOARD")
DO_SET_MODE, CUSTOM_MODE = 176, 1.0
INERT_TIME, ASKING_PERIOD, STREAM_PERIOD, STALE = 1.2, 1.0, 0.02, 1.0  # s
AIRSPEED_AGE = 1.0  # s
BANK_MAX = math.radians(60.0)  # of what is asked for; PX4's own FW_R_LIM is kept by PX4


class Px4RosLink(VehicleLink):
    """PX4 with a fixed wing in OFFBOARD, by lateral and longitudinal set-points.

    Args:
        address: Has no meaning here.
        parameters: Of the link.
        wire: Makes what carries the messages.
    """

    name = "px4_ros_link"
    when_silent = (
        "flies its last set-points for COM_OF_LOSS_T, then goes to Hold or Return as "
        "COM_OBL_RC_ACT says"
    )

    def __init__(
        self,
        address: str = "",
        parameters: LinkParameters | None = None,
        wire: Callable[[], Wire] = RosWire,
    ) -> None:
        super().__init__(address)
        self._parameters, self._make = parameters or LinkParameters(), wire
        self._wire: Wire | None = None
        self._forget()

    def _forget(self) -> None:
        self.engagement = Engagement(self.events, self._parameters.engage_on_mode)
        self._heard: dict[str, Any] = {}
        self._airspeed_at = self._sent_at = self._asked_at = -math.inf
        self._inert_since: float | None = None
        self._frame: LocalFrame | None = None
        if self._parameters.origin:
            latitude, longitude, altitude = self._parameters.origin
            self._frame = LocalFrame(math.radians(latitude), math.radians(longitude), altitude)
        self._newest: Measurement | None = None
        self._plan, self._demand = PlanFollower(), PathDemand()

    @classmethod
    def of(cls, parameters: LinkParameters) -> VehicleLink:
        """See :meth:`VehicleLink.of`."""
        return cls(parameters=parameters)

    def connect(self, timeout: float) -> None:
        """See :meth:`VehicleLink.connect`."""
        self.close()
        self._forget()
        self._wire = self._make()
        end = self.now() + timeout
        while self._newest is None or "VehicleStatus" not in self._heard:
            if self.now() > end:
                self.close()
                raise LinkError(f"PX4 is not heard on /fmu/out within {timeout:g} s")
            self.measured(0.1)

    def close(self) -> None:
        """See :meth:`VehicleLink.close`."""
        if self._wire is not None:
            self.disengage()
            self._wire.close()
            self._wire = None

    def now(self) -> float:
        """See :meth:`VehicleLink.now`."""
        return time.monotonic()

    @property
    def _mode(self) -> str:
        number = int(self._heard["VehicleStatus"].nav_state)
        return MODES.get(number, f"number {number}")

    def inspect(self) -> Inspection:
        """See :meth:`VehicleLink.inspect`."""
        refusals = []
        if self._heard["VehicleStatus"].arming_state != ARMED:
            refusals.append("disarmed: arm and take off first, this program does neither")
        elif self._mode not in HANDED_OVER:
            allowed = ", ".join(HANDED_OVER)
            refusals.append(f"mode is {self._mode}, must be one of {allowed} to take command from")
        if self._newest is None or self._newest.airspeed is None:
            refusals.append("no airspeed: airspeed_validated tells none")
        warning = (
            "PX4's parameters are not told over ROS 2: the limits are the configuration's; see "
            "that COM_OBL_RC_ACT is 5 (Hold) or 3 (Return) and COM_OF_LOSS_T a second"
        )
        return Inspection({"mode": self._mode}, {}, (warning,), tuple(refusals))

    def measured(self, timeout: float) -> Measurement | None:
        """See :meth:`VehicleLink.measured`."""
        if self._wire is None:
            raise LinkError("PX4 is not connected")
        end, found = self.now() + timeout, None
        while found is None:
            for kind, message in self._wire.receive(min(max(end - self.now(), 0.0), STREAM_PERIOD)):
                found = self._see(kind, message) or found
            self._tend(self.now())
            if self.now() >= end:
                break
        return found

    def _see(self, kind: str, message: Any) -> Measurement | None:
        now = self.now()
        self._heard[kind] = message
        self.engagement.heard(now)
        if kind == "AirspeedValidated":
            self._airspeed_at = now
        elif kind == "HomePosition" and self._frame is None:
            latitude, longitude = math.radians(message.lat), math.radians(message.lon)
            self._frame = LocalFrame(latitude, longitude, float(message.alt))
        elif kind == "VehicleStatus":
            was = self.engagement.commanding
            ours, armed = message.nav_state == OFFBOARD, message.arming_state == ARMED
            self.engagement.see_mode(now, ours, self._mode, armed, bool(message.failsafe))
            if self.engagement.commanding and not was:
                self._demand = PathDemand()
        place = self._heard.get("VehicleGlobalPosition")
        if kind != "VehicleOdometry" or place is None or self._frame is None:
            return None
        fresh = now - self._airspeed_at <= AIRSPEED_AGE
        airspeed = self._heard["AirspeedValidated"] if fresh else None
        found = measurement(now, place, message, airspeed, self._frame)
        self._newest = found or self._newest
        return found

    def command(
        self,
        stamp: float,
        inputs: NDArray[np.float64],
        step: float,
        orbit: FlownOrbit | None = None,
    ) -> str:
        """See :meth:`VehicleLink.command`."""
        try:
            starts = stamp + step * np.arange(len(inputs))
            self._plan.accept(inputs, starts, self.now())
        except (ValueError, TypeError) as error:
            return str(error)
        return ""

    @property
    def engaged(self) -> bool:
        """See :meth:`VehicleLink.engaged`."""
        return self.engagement.commanding

    def engage(self) -> str:
        """See :meth:`VehicleLink.engage`."""
        if self._wire is None or "VehicleStatus" not in self._heard:
            return "there is no autopilot to engage"
        refusals = list(self.inspect().refusals)
        if not self._plan.commanded:
            refusals.append("there is nothing to fly yet: no command has come")
        if not refusals:
            self.engagement.ask(self.now())
        return "; ".join(refusals)

    def disengage(self) -> None:
        """See :meth:`VehicleLink.disengage`."""
        if self.engagement.state is not State.IDLE:
            flown = self.engagement.commanding
            self.engagement.give_up("disengaged")
            if flown:
                self._set_mode(4.0, 3.0)  # AUTO LOITER, which is Hold

    def _set_mode(self, main: float, sub: float) -> None:
        if self._wire is not None:
            self._wire.send(
                "VehicleCommand",
                lambda message: fill_command(message, DO_SET_MODE, CUSTOM_MODE, main, sub),
            )

    def _tend(self, now: float) -> None:
        state, measured = self.engagement.state, self._newest
        if state is State.IDLE:
            self._inert_since = None
            return
        if measured is None or measured.airspeed is None or now - measured.stamp > STALE:
            return
        if now - self._sent_at >= STREAM_PERIOD:
            inputs = self._plan.inputs(now)
            if state is not State.ENGAGED:
                self._inert_since = self._inert_since or now
                self._send(measured.turn_rate, measured, measured.airspeed, inert=True)
            elif inputs is not None:
                turn_rate, path_rate, gain = inputs.tolist()
                self._demand.step(path_rate, gain, measured, now)
                self._send(turn_rate, measured, measured.airspeed)
        waited = self._inert_since is not None and now - self._inert_since >= INERT_TIME
        if state is State.ASKING and waited and now - self._asked_at >= ASKING_PERIOD:
            self._asked_at = now
            self._set_mode(6.0, 0.0)

    def _send(
        self, turn_rate: float, measured: Measurement, airspeed: float, inert: bool = False
    ) -> None:
        assert self._wire is not None
        self._sent_at, demand = self.now(), self._demand
        if inert:
            demand = PathDemand()
            demand.airspeed = airspeed
        altitude = float(self._heard["VehicleGlobalPosition"].alt)
        self._wire.send("OffboardControlMode", fill_offboard)
        self._wire.send(
            "FixedWingLateralSetpoint",
            lambda message: fill_lateral(message, turn_rate, airspeed, BANK_MAX),
        )
        self._wire.send(
            "FixedWingLongitudinalSetpoint",
            lambda message: fill_longitudinal(message, demand, airspeed, altitude),
        )
