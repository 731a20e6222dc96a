"""Node ``monitor``: a live table of the flight, for terminals without ``ros2 topic``."""

from __future__ import annotations

import functools
import math
import sys
import time
from typing import Any

from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rich.console import Console, Group
from rich.live import Live
from rich.markup import escape
from rich.table import Table

from uav_tracking_mpc.nodes.conversions import (
    MessageError,
    air_velocity_from_twist,
    measurement_from_odometry,
    plan_from_command,
    position_from_point,
)
from uav_tracking_mpc.nodes.run import run
from uav_tracking_mpc.nodes.target_odometry import target_from_odometry
from uav_tracking_mpc.nodes.topics import (
    AIR_VELOCITY,
    COMMAND,
    DIAGNOSTICS,
    ODOMETRY,
    TARGET,
    TARGET_ODOMETRY,
    TRACKING,
    Topic,
)

SHOWN = (ODOMETRY, AIR_VELOCITY, TARGET, TARGET_ODOMETRY, COMMAND, *TRACKING.values())
REFRESH_PERIOD = 0.25  # s
STALE = 2.0  # s of wall time after which a topic counts as silent
LEVELS = {b"\x00": "ok", b"\x01": "[yellow]warning[/]", b"\x02": "[red]error[/]", b"\x03": "stale"}


class Monitor(Node):
    """Shows what comes on the topics, how often, and what the nodes say of themselves.

    Args:
        console: Where to show it; the terminal by default.
        options: Of rclpy's Node.
    """

    def __init__(self, console: Console | None = None, **options: Any) -> None:
        super().__init__("monitor", **options)
        self._latest: dict[str, Any] = {}
        self._arrivals: dict[str, list[float]] = {}
        self._statuses: dict[str, Any] = {}
        for topic in (*SHOWN, DIAGNOSTICS):
            callback = functools.partial(self._on_message, topic)
            self.create_subscription(topic.type, topic.name, callback, topic.qos)
        self._live = Live(self.table(), console=console, refresh_per_second=4)
        self._live.start()
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(REFRESH_PERIOD, self._refresh, clock=steady)

    def _refresh(self) -> None:
        self._live.update(self.table())

    def _on_message(self, topic: Topic, message: Any) -> None:
        if topic is DIAGNOSTICS:
            self._statuses.update({status.name: status for status in message.status})
            return
        self._latest[topic.name] = message
        arrivals = self._arrivals.setdefault(topic.name, [])
        arrivals.append(time.monotonic())
        del arrivals[:-20]

    def table(self) -> Group:
        """What is known now, as tables."""
        flight = Table(title="flight", expand=True)
        for heading in ("topic", "rate", "value"):
            flight.add_column(heading)
        for topic in SHOWN:
            flight.add_row(topic.name, self._rate(topic), escape(self._words(topic)))
        nodes = Table(title="nodes", expand=True)
        for heading in ("node", "level", "says"):
            nodes.add_column(heading)
        for name, status in sorted(self._statuses.items()):
            # Others publish here too: their words are text, not markup.
            level = LEVELS.get(status.level, "?")
            nodes.add_row(escape(name.partition(":")[0]), level, escape(status.message))
        return Group(flight, nodes)

    def _rate(self, topic: Topic) -> str:
        arrivals = self._arrivals.get(topic.name, [])
        if not arrivals:
            return "nothing yet"
        if time.monotonic() - arrivals[-1] > STALE:
            return "[red]silent[/]"
        span = arrivals[-1] - arrivals[0]
        return f"{(len(arrivals) - 1) / span:.1f} Hz" if span > 0.0 else ""

    def _words(self, topic: Topic) -> str:
        message = self._latest.get(topic.name)
        if message is None:
            return ""
        try:
            if topic is ODOMETRY:
                motion = measurement_from_odometry(message)
                x, y, z = motion.position
                return (
                    f"x {x:.2f}  y {y:.2f}  z {z:.2f} m   "
                    f"heading {math.degrees(motion.heading):.1f}  "
                    f"path angle {math.degrees(motion.path_angle):.1f} deg   "
                    f"ground speed {math.hypot(*motion.ground_velocity):.2f} m/s"
                )
            if topic is AIR_VELOCITY:
                return f"airspeed {math.hypot(*air_velocity_from_twist(message)):.2f} m/s"
            if topic is TARGET:
                x, y, z = position_from_point(message)
                return f"x {x:.2f}  y {y:.2f}  z {z:.2f} m"
            if topic is TARGET_ODOMETRY:
                (x, y, z), velocity, _ = target_from_odometry(message)
                speed = "" if velocity is None else f"   speed {math.hypot(*velocity):.2f} m/s"
                return f"x {x:.2f}  y {y:.2f}  z {z:.2f} m{speed}"
            if topic is COMMAND:
                yaw, pitch, acceleration = plan_from_command(message)[0][0]
                return (
                    f"yaw rate {yaw:+.4f}  path-angle rate {pitch:+.4f} rad/s   "
                    f"acceleration {acceleration:+.4f} m/s^2"
                )
        except MessageError as error:
            return f"unusable: {error}"
        unit = topic.meaning.partition("[")[2].partition("]")[0]
        return (
            f"{message.data:+.4f} {unit}"
            if unit in ("m", "rad", "m/s")
            else f"{message.data:.3g} {unit}"
        )

    def finish(self) -> None:
        """Leave the last table on the screen."""
        self._live.update(self.table())
        self._live.stop()


def main() -> int:
    """Entry point of the executable."""
    return run("monitor", Monitor)


if __name__ == "__main__":
    sys.exit(main())
