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

import contextlib
import math
import sys
import threading
import time
from collections.abc import Callable
from typing import Any

from std_srvs.srv import SetBool

from uav_tracking_mpc.control.event import Level
from uav_tracking_mpc.dynamics.orbit import FlownOrbit
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.links import VEHICLE_LINK, LinkError, LinkRefusedError, Sighting, VehicleLink
from uav_tracking_mpc.links.simulated import SimulatedLink
from uav_tracking_mpc.nodes.messages.conversions import nanoseconds, set_point, set_truth
from uav_tracking_mpc.nodes.messages.named_figures import tracking_figures
from uav_tracking_mpc.nodes.messages.wires import even_command
from uav_tracking_mpc.nodes.ros import diagnostics
from uav_tracking_mpc.nodes.ros.endpoints import listen, publish, steady_timer
from uav_tracking_mpc.nodes.ros.process import run
from uav_tracking_mpc.nodes.topics import (
    ENGAGED,
    RATE_LIMIT,
    SPEED_LIMIT,
    TARGET,
    TARGET_ODOMETRY,
    TRACKING_ERRORS,
    MessageError,
)
from uav_tracking_mpc.nodes.vehicle_node import VehicleNode
from uav_tracking_mpc.parameters.registry import ExtensionError
from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.link import LinkParameters

LOOK_PERIOD = 0.1  # s between looks at how the link is
TELL_PERIOD = 1.0  # s between messages that say whether the commands are flown
SILENCE = 1.0  # s without a state, after which it is missed
SWITCH_INTERVAL = 1e-4  # s that a thread may keep another, which has a set-point to send, waiting
ANSWERS = {  # to who asks it to engage, or to disengage
    True: "asked for: uav/engaged is true once the aircraft flies the commands",
    False: "disengaged: nothing is commanded until it is engaged again",
}
ORBIT_AGE = 2.0  # s by which an orbit may be older than the command
ESTIMATED = {"airspeed": SPEED_LIMIT, "surplus": RATE_LIMIT}  # m/s, rad/s: by the controller

SHARE = 0.02  # -, of a new reading in the offset
STEP = 5e-3  # s by which a reading may differ before the clocks count as set anew
WITNESSES = 3  # such readings in a row: a single one may be late as the process was interrupted
CONNECT_LIMIT = 4.0  # s of one attempt to reach the aircraft
RETRY_PERIOD = 1.0  # s from one attempt to the next
WAIT = 0.1  # s for a measurement, and so to notice that it is to stop
STOP_LIMIT = 1.0  # s for the thread to end


class ClockOffset:
    """Offset of ROS time to the clock of a vehicle link.

    Args:
        ros: Reads ROS time in [ns].
        other: Reads the other clock in [s].
    """

    def __init__(self, ros: Callable[[], int], other: Callable[[], float]) -> None:
        self._ros, self._other = ros, other
        self._offset: int | None = None
        self._doubts = 0

    def read(self) -> int:
        """ROS time minus the other clock in [ns], read anew and averaged."""
        before = self._other()
        ros = self._ros()
        now = ros - round(0.5e9 * (before + self._other()))
        if self._offset is None:
            self._offset = now
        off = now - self._offset
        self._doubts = self._doubts + 1 if abs(off) > STEP * 1e9 else 0
        if self._doubts >= WITNESSES:
            self._offset, self._doubts = now, 0
        elif not self._doubts:
            self._offset += round(SHARE * off)
        return self._offset

    def ros(self, time: float) -> int:
        """ROS time in [ns] of a time of the other clock.

        Args:
            time: Of the other clock in [s].
        """
        return round(time * 1e9) + self.read()

    def other(self, stamp: int) -> float:
        """The other clock's time in [s] of a ROS time.

        Args:
            stamp: ROS time in [ns].
        """
        return (stamp - (self.read() if self._offset is None else self._offset)) * 1e-9


class LinkReader:
    """Connects, again and again while there is no aircraft, and reads until it is stopped.

    Args:
        link: To be read; this thread alone connects it.
        taken: Called with each measurement, in this thread; what it raises is reported among
            the link's events.

    Attributes:
        connected: Whether the aircraft was reached.
        since: When it was reached last, of the monotonic clock, in [s].
        trouble: Why there is no aircraft, in words; empty while there is one.
        refusal: Why it is given up, in words; empty while it is not.
    """

    def __init__(self, link: VehicleLink, taken: Callable[[Measurement], None]) -> None:
        self._link, self._taken = link, taken
        self.connected, self.trouble, self.refusal = False, "not connected yet", ""
        self.since = -math.inf
        self._told = ""
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="link", daemon=True)

    def start(self) -> None:
        """Begin."""
        self._thread.start()

    def stop(self) -> None:
        """End the thread, then the link; the aircraft does as the link's ``when_silent`` says."""
        self._stop.set()
        with contextlib.suppress(Exception):  # whatever a user's link raises, it is let go
            self._link.disengage()
        self._thread.join(STOP_LIMIT)
        with contextlib.suppress(Exception):
            self._link.close()

    def _run(self) -> None:
        while not self._stop.is_set():
            try:
                self._link.connect(CONNECT_LIMIT)
                self.since = time.monotonic()
                self.connected, self.trouble = True, ""
                self._read()
            except LinkRefusedError as error:
                self.refusal = str(error)
                return
            except LinkError as error:
                self.trouble = str(error)
            except Exception as error:  # whatever a user's link raises, it is tried again
                self.trouble = _failed(error)
            self.connected = False
            if self._stop.wait(RETRY_PERIOD):
                return
            with contextlib.suppress(Exception):  # connecting begins anew
                self._link.close()

    def _read(self) -> None:
        while not self._stop.is_set():
            measurement = self._link.measured(WAIT)
            if measurement is None or self._stop.is_set():
                continue
            try:
                self._taken(measurement)
            except Exception as error:  # not the link's: it is flown on
                words = f"a measurement is not published: {type(error).__name__}: {error}"
                if words != self._told:
                    self._told = words
                    self._link.events.add(Level.WARNING, words)


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
        # Airspeed [m/s] and surplus of the turn [rad/s] by the controller, and their stamp [ns]
        self._estimated = 0.0, 0.0, 0
        self._states, self._state_time, self._refusal = 0, -math.inf, ""
        if self.parameters.target_system:
            self._point, self._track = TARGET.type(), TARGET_ODOMETRY.type()
            self._points, self._tracks = publish(self, TARGET), publish(self, TARGET_ODOMETRY)
        self._engaged_publisher = publish(self, ENGAGED)
        self._reader = LinkReader(self._link, self._on_measured)
        self._open(self.parameters.telemetry_rate)
        listen(self, TRACKING_ERRORS, self._on_tracking)
        self.create_service(SetBool, "~/engage", self._on_engage)
        steady_timer(self, LOOK_PERIOD, self._look)
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
        if self.parameters.target_system and (sighting := self._link.sighting()) is not None:
            self._publish_sighting(self._clocks.ros(sighting.stamp), sighting)

    def _publish_sighting(self, stamp: int, sighting: Sighting) -> None:
        """On ``target/odometry`` where the velocity is told, on ``target/position`` where not."""
        if sighting.velocity is None:
            set_point(self._point, stamp, sighting.position, self._frames)
            self._points.publish(self._point)
            return
        set_truth(self._track, stamp, sighting.position, sighting.velocity, self._frames)
        self._tracks.publish(self._track)

    def _on_command(self, data: bytes) -> None:
        try:
            stamp, plan, step = even_command(data, self._frames)
        except MessageError as error:
            refusal = str(error)
        else:
            if not self._reader.connected:
                return
            orbit = self._orbit_at(stamp)
            refusal = self._guarded(
                lambda: self._link.command(self._clocks.other(stamp), plan, step, orbit)
            )
            self._ready = not refusal and orbit is not None
        self._received += 1
        self._refusal = refusal
        if refusal:
            self._refuse("command", refusal)

    def _refuse(self, what: str, words: str) -> None:
        self._rejected += 1
        super()._refuse(what, words)

    def _see_orbit(self, orbit: FlownOrbit, stamp: int) -> None:
        self._orbit = orbit, stamp

    def _on_tracking(self, message: Any) -> None:
        try:
            figures = tracking_figures(message)
            for name, limit in ESTIMATED.items():
                if abs(figures.get(name, 0.0)) > limit:
                    words = f"{name} is {figures[name]:g}, must be within {limit:g}"
                    raise MessageError(f"{TRACKING_ERRORS.name}: {words}")
            airspeed, surplus = (figures.get(name, 0.0) for name in ESTIMATED)
            self._estimated = airspeed, surplus, nanoseconds(message.header.stamp)
        except MessageError as error:
            self._refuse("estimate", str(error))

    def _orbit_at(self, stamp: int) -> FlownOrbit | None:
        """The newest orbit at a ROS time, with what is estimated; None without a new one."""
        if self._orbit is None:
            return None
        orbit, at = self._orbit
        age = (stamp - at) * 1e-9
        if abs(age) > ORBIT_AGE:
            return None
        orbit = orbit._replace(centre=orbit.centre + age * orbit.velocity)
        airspeed, surplus, at = self._estimated
        if abs(stamp - at) * 1e-9 > ORBIT_AGE:
            return orbit
        return orbit._replace(airspeed_now=airspeed, surplus=surplus)

    def _on_engage(self, request: Any, response: Any) -> Any:
        self._wanted = False
        refused = self._engage() if request.data else self._guarded(self._link.disengage)
        response.success, response.message = not refused, refused or ANSWERS[request.data]
        return response

    def _engage(self) -> str:
        """Take command; why not, in words."""
        if not self._reader.connected:
            return f"there is no aircraft: {self._reader.trouble}"
        return self._guarded(self._link.engage)

    @staticmethod
    def _guarded(ask: Callable[[], str | None]) -> str:
        """Why the link does not what it is asked for, in words; whatever it raises, we go on."""
        try:
            return ask() or ""
        except Exception as error:
            return _failed(error)

    def _look(self) -> None:
        if failure := self._guarded(self._look_at_link):
            self._diagnostics.report(diagnostics.ERROR, failure)

    def _look_at_link(self) -> None:
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
        if now - max(self._state_time, self._reader.since) > SILENCE:
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
        self._guarded(self._link.disengage)
        self._look()
        super().finish()
        self._reader.stop()


def _failed(error: Exception) -> str:
    return f"the link failed: {type(error).__name__}: {error}"


def _link(parameters: LinkParameters) -> VehicleLink:
    if parameters.link == SimulatedLink.name:
        raise ParameterError(
            f"parameter 'link' is {parameters.link!r}, must be another one: its time goes on as it "
            "is asked, for loops without ROS. The node uav_simulator flies a simulated aircraft"
        )
    try:
        return VEHICLE_LINK.find(parameters.link).of(parameters)  # type: ignore[no-any-return]
    except (ExtensionError, LinkError) as error:
        raise ParameterError(f"parameters 'link', 'connection': {error}") from error


if __name__ == "__main__":
    sys.setswitchinterval(SWITCH_INTERVAL)
    sys.exit(run("autopilot_link", AutopilotLink))
