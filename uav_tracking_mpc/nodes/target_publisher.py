"""Node ``target_publisher``: publishes the target's measured position."""

from __future__ import annotations

import sys
from typing import Any

from rclpy.node import Node

from uav_tracking_mpc.nodes import diagnostics
from uav_tracking_mpc.nodes.conversions import set_point
from uav_tracking_mpc.nodes.declared_parameters import declare_parameters
from uav_tracking_mpc.nodes.run import run
from uav_tracking_mpc.nodes.topics import TARGET
from uav_tracking_mpc.settings.target import TargetParameters
from uav_tracking_mpc.simulation.motions import motion_of
from uav_tracking_mpc.simulation.target_sensor import TargetSensor

DELIVERY_PERIOD = 0.01  # s; how closely a delay is kept


class TargetPublisher(Node):
    """Moves the target as its parameters say; with simulated time, by that time.

    Args:
        options: As those of rclpy's Node.

    Raises:
        ParameterError: A parameter is not allowed, or there is no such motion.
    """

    def __init__(self, **options: Any) -> None:
        super().__init__("target_publisher", **options)
        self.parameters = declare_parameters(self, TargetParameters)
        self._motion = motion_of(self.parameters)
        self._sensor = TargetSensor(self.parameters, self._motion)
        simulated = bool(self.get_parameter("use_sim_time").value)
        self._start = 0 if simulated else self.get_clock().now().nanoseconds
        self._message = TARGET.type()
        self._position = self._motion.position(0.0)
        self._publisher = self.create_publisher(TARGET.type, TARGET.name, TARGET.qos)
        self._diagnostics = diagnostics.Diagnostics(self, self._values)
        self._timer = self.create_timer(1.0 / self.parameters.rate, self._measure)
        if self.parameters.delay > 0.0:
            self._delivery = self.create_timer(DELIVERY_PERIOD, self._deliver)

    def _time(self) -> float:
        """Since the target's start in [s]."""
        return (self.get_clock().now().nanoseconds - self._start) * 1e-9

    def _measure(self) -> None:
        now = self._time()
        self._position = self._motion.position(now)
        self._sensor.measure(now)
        self._deliver()
        self._diagnostics.report(diagnostics.OK, f"target is {self.parameters.motion}")

    def _deliver(self) -> None:
        for measured, position in self._sensor.delivered(self._time()):
            set_point(self._message, self._start + round(measured * 1e9), position)
            self._publisher.publish(self._message)

    def _values(self) -> dict[str, object]:
        x, y, z = self._position.tolist()
        rate, began = self.parameters.rate, str(self._start)
        return {"x [m]": x, "y [m]": y, "z [m]": z, "rate [Hz]": rate, "began [ns]": began}

    def finish(self) -> None:
        """Publish the last diagnostics."""
        self._diagnostics.publish()


def main() -> int:
    """Entry point of the executable."""
    return run("target_publisher", TargetPublisher)


if __name__ == "__main__":
    sys.exit(main())
