"""/diagnostics: how a node is, in words and numbers, once a second and on change."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.clock import Clock, ClockType
from rclpy.node import Node

from uav_tracking_mpc.nodes.topics import DIAGNOSTICS

OK, WARN, ERROR = DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR


class Diagnostics:
    """Diagnostics of one node.

    The timer runs on a steady clock: a stopped simulation must not silence it.

    Args:
        node: Whose they are.
        values: Called at each report for keys (with units) and values.
    """

    def __init__(self, node: Node, values: Callable[[], Mapping[str, object]]) -> None:
        self._node = node
        self._values = values
        name = node.get_fully_qualified_name().lstrip("/")
        self._status = DiagnosticStatus(level=WARN, name=f"{name}: status", message="starting")
        self._status.hardware_id = "uav_tracking_mpc"
        self._message = DiagnosticArray(status=[self._status])
        self._publisher = node.create_publisher(DIAGNOSTICS.type, DIAGNOSTICS.name, DIAGNOSTICS.qos)
        self._timer = node.create_timer(
            1.0, self.publish, clock=Clock(clock_type=ClockType.STEADY_TIME)
        )

    def report(self, level: bytes, message: str) -> None:
        """Say how the node is; published and logged at once when it has changed.

        Args:
            level: OK, WARN or ERROR.
            message: For people.
        """
        if (level, message) == (self._status.level, self._status.message):
            return
        self._status.level, self._status.message = level, message
        logger = self._node.get_logger()
        # rclpy ties each call site to one severity, hence one line each.
        if level == OK:
            logger.info(message)
        elif level == WARN:
            logger.warning(message)
        else:
            logger.error(message)
        self.publish()

    def publish(self) -> None:
        """Publish the present state."""
        self._status.values = [
            KeyValue(key=key, value=f"{value:.6g}" if isinstance(value, float) else str(value))
            for key, value in self._values().items()
        ]
        self._message.header.stamp = self._node.get_clock().now().to_msg()
        self._publisher.publish(self._message)
