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

"""Node ``autopilot_link``: a real aircraft in the simulator's place, through a vehicle link."""

from __future__ import annotations

import math
import sys
import time
from typing import Any

from rclpy.clock import Clock, ClockType
from std_srvs.srv import SetBool

from uav_tracking_mpc.control.event import Level
from uav_tracking_mpc.dynamics.orbit import FlownOrbit
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.links import VEHICLE_LINK, LinkError, VehicleLink
from uav_tracking_mpc.nodes.messages.message_checks import MessageError
from uav_tracking_mpc.nodes.ros import diagnostics
from uav_tracking_mpc.nodes.ros.endpoints import publish
from uav_tracking_mpc.nodes.ros.process import run
from uav_tracking_mpc.nodes.topics import ENGAGED
from uav_tracking_mpc.nodes.vehicle.link_reader import ClockOffset, LinkReader, SightingPublisher
from uav_tracking_mpc.nodes.vehicle.vehicle_node import VehicleNode
from uav_tracking_mpc.parameters.registry import ExtensionError
from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.link import LinkParameters

LOOK_PERIOD = 0.1  # s between looks at how the link is
TELL_PERIOD = 1.0  # s between messages that say whether the commands are flown
SILENCE = 1.0  # s without a state, after which it is missed
SWITCH_INTERVAL = 1e-4  # s that a thread may keep another, which has a set-point to send, waiting
ORBIT_AGE = 2.0  # s by which an orbit may be older than the command


class AutopilotLink(VehicleNode):
    """Publishes what the aircraft measures and hands it the commands.

    It waits for an aircraft that is not there yet, and outlives one that is lost.

    Args:
        options: As those of rclpy's Node.

    Attributes:
        refusal: Why it ends though nobody stopped it, in words; empty while it goes on.

    Raises:
        ParameterError: A parameter is not allowed, or there is no such link.
    """

    def __init__(self, **options: Any) -> None:
        super().__init__("autopilot_link", LinkParameters, **options)
        self._link = _link(self.parameters)
        self._clocks = ClockOffset(lambda: self.get_clock().now().nanoseconds, self._link.now)
        self._wanted = self.parameters.engage
        self._engaged, self._told = False, -math.inf
        self._ready = False  # whether the link has something to fly
        self._orbit: tuple[FlownOrbit, int] | None = None
        self._states, self._state_time, self._refusal = 0, -math.inf, ""
        self._sightings = None
        if self.parameters.target_system:
            self._sightings = SightingPublisher(self, self._frames)
        self._engaged_publisher = publish(self, ENGAGED)
        self._reader = LinkReader(self._link, self._on_measured)
        self._open(self.parameters.telemetry_rate)
        self.create_service(SetBool, "~/engage", self._on_engage)
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(LOOK_PERIOD, self._look, clock=steady)
        self._reader.start()

    @property
    def refusal(self) -> str:
        """See the class."""
        return self._reader.refusal

    def _on_measured(self, seen: Measurement) -> None:
        """Publish a measurement at once, in the thread that received it."""
        # The first airspeed goes before the first state.
        state = bool(self._states) or seen.airspeed is None
        self._publish(self._clocks.ros(seen.stamp), seen, state)
        self._states += 1
        self._state_time = time.monotonic()
        sighting = None if self._sightings is None else self._link.sighting()
        if self._sightings is not None and sighting is not None:
            self._sightings.publish(self._clocks.ros(sighting.stamp), sighting)

    def _on_command(self, data: bytes) -> None:
        try:
            stamp, plan, step = self._wire.read(data)
            if not self._reader.connected:
                return
            begin, orbit = self._clocks.other(stamp), self._orbit_at(stamp)
            refusal = self._link.command(begin, plan, step, orbit)
            self._ready = not refusal and orbit is not None
        except MessageError as error:
            refusal = str(error)
        except Exception as error:  # whatever a user's link raises, the node goes on
            refusal = f"the link failed: {type(error).__name__}: {error}"
        self._received += 1
        self._refusal = refusal
        if refusal:
            self._refuse("command", refusal)

    def _refuse(self, what: str, words: str) -> None:
        self._rejected += 1
        super()._refuse(what, words)

    def _see_orbit(self, orbit: FlownOrbit, stamp: int) -> None:
        self._orbit = orbit, stamp

    def _orbit_at(self, stamp: int) -> FlownOrbit | None:
        """The newest orbit, its centre carried on to a ROS time; None without a new one."""
        if self._orbit is None:
            return None
        orbit, at = self._orbit
        age = (stamp - at) * 1e-9
        if abs(age) > ORBIT_AGE:
            return None
        return orbit._replace(centre=orbit.centre + age * orbit.velocity)

    def _on_engage(self, request: Any, response: Any) -> Any:
        self._wanted = False
        words = self._engage() if request.data else self._disengage()
        response.success, response.message = not words, words
        return response

    def _engage(self) -> str:
        """Take command; why not, in words."""
        if not self._reader.connected:
            return f"there is no aircraft: {self._reader.trouble}"
        try:
            return self._link.engage()
        except Exception as error:  # whatever a user's link raises, the node goes on
            return f"the link failed: {type(error).__name__}: {error}"

    def _disengage(self) -> str:
        """Give command back; why not, in words."""
        try:
            self._link.disengage()
        except Exception as error:  # whatever a user's link raises, the node goes on
            return f"the link failed: {type(error).__name__}: {error}"
        return ""

    def _look(self) -> None:
        """Report what has happened to the link, and how it is."""
        now = time.monotonic()
        logger = self.get_logger()
        for level, words in self._link.events.take():
            if level is Level.INFO:
                logger.info(words)
            else:
                logger.warning(words)
        self._tell(now)
        self._diagnostics.hardware_id = self._link.identity or self._diagnostics.hardware_id
        self._diagnostics.report(*self._status(now))
        if self._wanted and self._ready and now - self._state_time < SILENCE:
            words = self._engage()
            self._wanted = bool(words)  # asked for once: it does not argue with the pilot
            if words:
                self._warnings.warn("engaging", f"not engaged: {words}")

    def _tell(self, now: float) -> None:
        """Say whether the commands are flown, on change and once a second."""
        engaged = self._reader.connected and bool(self._link.engaged)
        if engaged != self._engaged or now - self._told >= TELL_PERIOD:
            self._engaged, self._told = engaged, now
            self._engaged_publisher.publish(ENGAGED.type(data=engaged))

    def _status(self, now: float) -> tuple[bytes, str]:
        """Level and words of how the link is."""
        name = self._link.name
        if not self._reader.connected:
            level = diagnostics.ERROR if self._states else diagnostics.WARN
            return level, f"{name}: no aircraft: {self._reader.trouble}"
        if now - self._state_time > SILENCE:
            return diagnostics.ERROR, f"{name}: connected, but no state comes"
        if not self._engaged:
            return diagnostics.OK, f"{name}: not engaged, nothing is commanded"
        if self._refusal:
            return diagnostics.ERROR, f"{name}: the commands are refused"
        return diagnostics.OK, f"{name}: the commands are flown"

    def _values(self) -> dict[str, object]:
        try:
            values = self._link.values()
        except Exception as error:  # whatever a user's link raises, the node goes on
            values = {"link": f"failed: {type(error).__name__}: {error}"}
        return {
            "dialect": self._link.name,
            "engaged": self._engaged,
            "when silent": self._link.when_silent,
            "states": self._states,
            "commands received": self._received,
            "plans refused": self._rejected,
            "last refusal": self._refusal,
            **values,
            **super()._values(),
        }

    def finish(self) -> None:
        """Give command back, let go of the aircraft and publish the last diagnostics."""
        self._wanted = False
        self._disengage()
        self._look()
        super().finish()
        self._reader.stop()


def _link(parameters: LinkParameters) -> VehicleLink:
    try:
        return VEHICLE_LINK.find(parameters.link).of(parameters)  # type: ignore[no-any-return]
    except (ExtensionError, LinkError) as error:
        raise ParameterError(f"parameters 'link', 'connection': {error}") from error


def main() -> int:
    """Entry point of the executable."""
    sys.setswitchinterval(SWITCH_INTERVAL)
    return run("autopilot_link", AutopilotLink)


if __name__ == "__main__":
    sys.exit(main())
