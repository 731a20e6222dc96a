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

"""The thread that reads a vehicle link, its stamps in ROS time, and the vehicle that it circles."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable

from rclpy.node import Node

from uav_tracking_mpc.control.event import Level
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.links import LinkError, LinkRefusedError, Sighting, VehicleLink
from uav_tracking_mpc.nodes.messages.conversions import set_point, set_stamp, set_vector
from uav_tracking_mpc.nodes.messages.message_checks import FRAMES, FrameNames
from uav_tracking_mpc.nodes.ros.endpoints import publish
from uav_tracking_mpc.nodes.topics import TARGET, TARGET_ODOMETRY

SHARE = 0.02  # -, of a new reading in the offset
STEP = 5e-3  # s by which a reading may differ before the clocks count as set anew
WITNESSES = 3  # readings in a row that say so: one may lie where the process was interrupted


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


CONNECT_LIMIT = 4.0  # s of one attempt to reach the aircraft
RETRY_PERIOD = 1.0  # s from one attempt to the next
WAIT = 0.1  # s for a measurement, and so to notice that it is to stop
STOP_LIMIT = 1.0  # s for the thread to end


class LinkReader:
    """Connects, again and again while there is no aircraft, and reads until it is stopped.

    Args:
        link: To be read; this thread alone connects it.
        taken: Called with each measurement, in this thread; what it raises is reported among
            the link's events.

    Attributes:
        connected: Whether the aircraft was reached.
        trouble: Why there is no aircraft, in words; empty while there is one.
        refusal: Why it is given up, in words; empty while it is not.
    """

    def __init__(self, link: VehicleLink, taken: Callable[[Measurement], None]) -> None:
        self._link, self._taken = link, taken
        self.connected, self.trouble, self.refusal = False, "not connected yet", ""
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
                self.connected, self.trouble = True, ""
                self._read()
            except LinkRefusedError as error:
                self.refusal = str(error)
                return
            except LinkError as error:
                self.trouble = str(error)
            except Exception as error:  # whatever a user's link raises, it is tried again
                self.trouble = f"the link failed: {type(error).__name__}: {error}"
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


class SightingPublisher:
    """On ``target/odometry`` where the velocity is told, on ``target/position`` where it is not.

    Args:
        node: Through which it publishes.
        frames: Of the messages.
    """

    def __init__(self, node: Node, frames: FrameNames = FRAMES) -> None:
        self._frames = frames
        self._points, self._tracks = (publish(node, topic) for topic in (TARGET, TARGET_ODOMETRY))
        self._point, self._track = TARGET.type(), TARGET_ODOMETRY.type()
        self._track.header.frame_id = self._track.child_frame_id = frames.map

    def publish(self, stamp: int, sighting: Sighting) -> None:
        """Publish a sighting.

        Args:
            stamp: Its time in [ns].
            sighting: Of the vehicle.
        """
        if sighting.velocity is None:
            set_point(self._point, stamp, sighting.position, self._frames)
            self._points.publish(self._point)
            return
        set_stamp(self._track.header.stamp, stamp)
        set_vector(self._track.pose.pose.position, sighting.position)
        set_vector(self._track.twist.twist.linear, sighting.velocity)
        self._tracks.publish(self._track)
