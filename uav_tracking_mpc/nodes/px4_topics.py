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

"""The topics of PX4's ROS 2 interface; px4_msgs is looked for when they are opened."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from typing import Any, Protocol

from uav_tracking_mpc.links import LinkRefusedError
from uav_tracking_mpc.nodes.px4_messages import topic

HEARD = {
    "VehicleGlobalPosition": "/fmu/out/vehicle_global_position",
    "VehicleOdometry": "/fmu/out/vehicle_odometry",
    "AirspeedValidated": "/fmu/out/airspeed_validated",
    "VehicleStatus": "/fmu/out/vehicle_status",
    "HomePosition": "/fmu/out/home_position",
}
SAID = {
    "OffboardControlMode": "/fmu/in/offboard_control_mode",
    "FixedWingLateralSetpoint": "/fmu/in/fixed_wing_lateral_setpoint",
    "FixedWingLongitudinalSetpoint": "/fmu/in/fixed_wing_longitudinal_setpoint",
    "VehicleCommand": "/fmu/in/vehicle_command",
}


class Wire(Protocol):
    """What carries the messages."""

    def receive(self, timeout: float) -> list[tuple[str, Any]]:
        """Kinds and messages that have come, by name.

        Args:
            timeout: How long to wait for the first in [s].
        """

    def send(self, kind: str, fill: Callable[[Any], None]) -> None:
        """Send a message.

        Args:
            kind: Name of its class.
            fill: Fills it.
        """

    def close(self) -> None:
        """Let go."""


class RosWire:
    """Topics of PX4.

    Raises:
        LinkRefusedError: px4_msgs is not installed, or older than the fixed-wing set-points.
    """

    def __init__(self) -> None:
        try:
            kinds = importlib.import_module("px4_msgs.msg")
        except ImportError as error:
            raise LinkRefusedError(
                "PX4 over ROS 2 needs px4_msgs in the workspace (github.com/PX4/px4_msgs)"
            ) from error
        if missing := [name for name in (*HEARD, *SAID) if not hasattr(kinds, name)]:
            raise LinkRefusedError(
                f"px4_msgs has no {missing[0]}, must be that of PX4 1.17 or later"
            )
        import rclpy
        from rclpy.executors import SingleThreadedExecutor
        from rclpy.qos import QoSProfile, ReliabilityPolicy

        quality = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
        self._node = rclpy.create_node("px4_ros_link")
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(self._node)
        self._come: list[tuple[str, Any]] = []
        for name, place in HEARD.items():
            kind = getattr(kinds, name)
            self._node.create_subscription(
                kind,
                topic(place, kind),
                lambda message, name=name: self._come.append((name, message)),
                quality,
            )
        self._kinds = {name: getattr(kinds, name) for name in SAID}
        self._publishers = {
            name: self._node.create_publisher(kind, topic(SAID[name], kind), quality)
            for name, kind in self._kinds.items()
        }

    def receive(self, timeout: float) -> list[tuple[str, Any]]:
        """See :meth:`Wire.receive`."""
        self._executor.spin_once(timeout_sec=max(timeout, 0.0))
        come, self._come = self._come, []
        return come

    def send(self, kind: str, fill: Callable[[Any], None]) -> None:
        """See :meth:`Wire.send`."""
        message = self._kinds[kind]()
        message.timestamp = self._node.get_clock().now().nanoseconds // 1000
        fill(message)
        self._publishers[kind].publish(message)

    def close(self) -> None:
        """See :meth:`Wire.close`."""
        self._executor.shutdown(timeout_sec=0.0)
        self._node.destroy_node()
