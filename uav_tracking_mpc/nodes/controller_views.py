"""What the controller shows to people: tracking errors, the plan as a path, markers."""

from __future__ import annotations

import time

import numpy as np
from numpy.typing import NDArray
from rclpy.node import Node

from uav_tracking_mpc.control.command import Command
from uav_tracking_mpc.dynamics import vehicle
from uav_tracking_mpc.nodes.topics import MARKERS, PREDICTED_PATH, TRACKING
from uav_tracking_mpc.nodes.view_messages import markers_message, path_message

PERIOD = 0.2  # s of wall time between paths and markers: people look at them


class ControllerViews:
    """Publishes what somebody listens to.

    Args:
        node: Through which it publishes.
    """

    def __init__(self, node: Node) -> None:
        self._path, self._markers = (
            node.create_publisher(topic.type, topic.name, topic.qos)
            for topic in (PREDICTED_PATH, MARKERS)
        )
        self._tracking = [
            (node.create_publisher(topic.type, topic.name, topic.qos), topic.type())
            for topic in TRACKING.values()
        ]
        self._last = -float("inf")

    def publish(self, stamp: int, wind: NDArray[np.float64], command: Command) -> None:
        """Show one command.

        Args:
            stamp: Of the state that it answers in [ns].
            wind: Shape (3,), in [m/s].
            command: What was sent.
        """
        if command.plan is not None:
            solution = command.plan.solution
            values = (*command.plan.error, solution.cost, solution.solve_time)
            for (publisher, message), value in zip(self._tracking, values, strict=True):
                if publisher.get_subscription_count():
                    message.data = float(value)
                    publisher.publish(message)
        now, present = time.monotonic(), command.present
        viewers = self._path.get_subscription_count() + self._markers.get_subscription_count()
        if present is not None and viewers and now - self._last >= PERIOD:
            self._last = now
            flown = _flown(present.vehicle, wind, command)
            self._path.publish(path_message(stamp, flown))
            self._markers.publish(markers_message(stamp, flown, present.target, command.orbit))


def _flown(
    state: NDArray[np.float64], wind: NDArray[np.float64], command: Command
) -> NDArray[np.float64]:
    """States along the plan, shape (n + 1, 6), in ``map``."""
    states = [state]
    for inputs in command.inputs:
        following = vehicle.advance(states[-1], inputs, command.step)
        following[:3] += command.step * wind
        states.append(following)
    return np.array(states)
