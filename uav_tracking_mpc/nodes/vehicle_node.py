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

"""What the simulator's node and the link's share: a vehicle's state out, commands in, /tf."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from typing import Any

from builtin_interfaces.msg import Time
from geometry_msgs.msg import TransformStamped
from nav_msgs.msg import Odometry
from rclpy.node import Node

from uav_tracking_mpc.dynamics.frames import FORWARD_RIGHT_DOWN, NORTH_EAST_DOWN
from uav_tracking_mpc.dynamics.orbit import FlownOrbit
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.nodes.messages.conversions import (
    nanoseconds,
    set_air_velocity,
    set_header,
    set_measurement,
)
from uav_tracking_mpc.nodes.messages.named_figures import orbit_from_message
from uav_tracking_mpc.nodes.ros.declared_parameters import declare_parameters
from uav_tracking_mpc.nodes.ros.diagnostics import (
    WARN,
    Diagnostics,
    DuplicateSenders,
    ThrottledWarnings,
)
from uav_tracking_mpc.nodes.ros.endpoints import PacedPublisher, PublisherWatch, listen, publish
from uav_tracking_mpc.nodes.topics import (
    AIR_VELOCITY,
    CLOCK,
    COMMAND,
    ODOMETRY,
    ORBIT,
    STATIC_TRANSFORMS,
    TRANSFORMS,
    FrameNames,
    frame_names,
)

FLOWN = (COMMAND, ODOMETRY, AIR_VELOCITY)  # topics with one sender


class VehicleNode(Node):
    """Publishes a vehicle's state and hears the commands to it.

    Args:
        name: Of the node.
        parameters: Their dataclass.
        changeable: Whether they may be set in flight.
        options: As those of rclpy's Node.

    Raises:
        ParameterError: A parameter is not allowed.
    """

    def __init__(
        self, name: str, parameters: type, changeable: bool = False, **options: Any
    ) -> None:
        super().__init__(name, **options)
        self.parameters: Any = declare_parameters(self, parameters, changeable=changeable)
        self._frames = frame_names(self, self.parameters)
        self._received = self._rejected = 0

    def _open(self, rate: float | None, now: Callable[[], Time] | None = None) -> None:
        """Make publishers, subscriptions and diagnostics.

        Args:
            rate: Of the states, in wall time, in [Hz]; None in simulated time.
            now: Stamp of diagnostics, where the node itself makes the time.
        """
        self._odometry, self._air_velocity = ODOMETRY.type(), AIR_VELOCITY.type()
        self._state_publisher = PacedPublisher(self, ODOMETRY, rate)
        self._air_publisher = publish(self, AIR_VELOCITY)
        self._transforms = TransformBroadcaster(self, self._frames)
        self._diagnostics = Diagnostics(self, self._values, now)
        timed = now is not None or bool(self.get_parameter("use_sim_time").value)
        alone = *FLOWN, *((CLOCK,) if timed else ())
        self._senders = DuplicateSenders(self, alone, self._diagnostics.alarm)
        self._commanders = PublisherWatch(self, lambda words: self._diagnostics.report(WARN, words))
        self._warnings = ThrottledWarnings(self)
        self._commanders.listen(COMMAND, self._on_command, raw=True)
        listen(self, ORBIT, self._on_orbit)

    def _publish(self, stamp: int, seen: Measurement, state: bool = True) -> None:
        """Publish what was measured.

        Args:
            stamp: Its time in [ns].
            seen: The measurement.
            state: Whether the state is published, beside the velocity through the air.
        """
        set_measurement(self._odometry, stamp, seen, self._frames)
        if state:
            self._state_publisher.publisher.publish(self._odometry)
            self._transforms.publish(self._odometry)
        if seen.airspeed is not None:
            set_air_velocity(self._air_velocity, stamp, seen.airspeed, self._frames)
            self._air_publisher.publish(self._air_velocity)

    @abstractmethod
    def _on_command(self, data: bytes) -> None:
        """Fly a serialized command."""

    @abstractmethod
    def _see_orbit(self, orbit: FlownOrbit, stamp: int) -> None:
        """Take note of the orbit that the commands lead to, and of its time in [ns]."""

    def _on_orbit(self, message: Any) -> None:
        try:
            orbit = orbit_from_message(message, self._frames)
            self._see_orbit(orbit, nanoseconds(message.header.stamp))
        except Exception as error:  # whatever a user's plant raises, the node goes on
            self._refuse("orbit", str(error))

    def _refuse(self, what: str, words: str) -> None:
        """Warn of a command or an orbit that cannot be flown."""
        self._warnings.warn(what, f"{what} refused: {words}")

    def _values(self) -> dict[str, object]:
        """Keys, with units, and values for /diagnostics."""
        return {"state deadlines missed": self._state_publisher.missed, **self._commanders.values()}

    def finish(self) -> None:
        """Publish the last diagnostics."""
        self._diagnostics.end()


class TransformBroadcaster:
    """``/tf`` from ``map`` to the aircraft with each of its states, where ROS has tf2_msgs.

    On ``/tf_static`` are the frames of autopilots, as MAVROS names them: ``map_ned`` and
    ``base_link_frd``, the same places with north, east, down and forward, right, down as axes. The
    target is a point without orientation and has no frame. Where ``map`` lies on earth is for
    others to say.

    Args:
        node: Through which it publishes.
        frames: Of the aircraft's state.
    """

    def __init__(self, node: Node, frames: FrameNames) -> None:
        self._publisher: Any = None
        try:
            kind = TRANSFORMS.type
        except ImportError:
            node.get_logger().info("tf2_msgs is not installed: /tf is not published")
            return
        self._moving = kind(transforms=[TransformStamped()])
        self._publisher = publish(node, TRANSFORMS)
        self._static = publish(node, STATIC_TRANSFORMS)
        stamp = node.get_clock().now().nanoseconds
        self._static.publish(kind(transforms=static_transforms(stamp, frames)))

    def publish(self, odometry: Odometry) -> None:
        """Publish the transform that a state says, if somebody listens.

        Args:
            odometry: As in ``uav/odometry``.
        """
        if self._publisher is not None and self._publisher.get_subscription_count():
            vehicle_transform(odometry, self._moving.transforms[0])
            self._publisher.publish(self._moving)


def static_transforms(stamp: int, frames: FrameNames) -> list[TransformStamped]:
    """From each frame to the one with an autopilot's axes.

    Args:
        stamp: In [ns].
        frames: Of the aircraft's state.
    """
    transforms = []
    for parent, ending, rotation in (
        (frames.map, "_ned", NORTH_EAST_DOWN),
        (frames.base, "_frd", FORWARD_RIGHT_DOWN),
    ):
        message = TransformStamped()
        set_header(message, stamp, parent)
        message.child_frame_id = parent + ending
        q = message.transform.rotation
        q.x, q.y, q.z, q.w = rotation
        transforms.append(message)
    return transforms


def vehicle_transform(odometry: Odometry, message: TransformStamped) -> None:
    """Fill in the transform of the aircraft's frame, as tf2 has it: pose of child in parent.

    Parent and child are the frames of the odometry, which bear the prefix of their aircraft.

    Args:
        odometry: As in ``uav/odometry``.
        message: To be changed in place. Stamp and orientation are those of the odometry itself,
            not copies.
    """
    message.header = odometry.header
    message.child_frame_id = odometry.child_frame_id
    position, translation = odometry.pose.pose.position, message.transform.translation
    translation.x, translation.y, translation.z = position.x, position.y, position.z
    message.transform.rotation = odometry.pose.pose.orientation
