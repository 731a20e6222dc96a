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

"""Steers a flight of ROS nodes by what every ROS user has: parameters, services, a topic."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from uav_tracking_mpc.nodes.steering_requests import NoAnswerError, SteeringRequests
from uav_tracking_mpc.view.steering import CONTROLLER, SIMULATOR, TARGET, Steering

ENGAGE = f"{CONTROLLER}/engage"
PAUSE = f"{SIMULATOR}/pause"
RESET = f"{SIMULATOR}/reset"
# By name: the service that lets it happen, and what it does. None needs this process at its end.
FAULTS = {
    "target lost": (f"{TARGET}/lose_target", "nothing measures the target for 15 s"),
    "state lost": (f"{SIMULATOR}/lose_state", "no state of the aircraft is published for 15 s"),
    "controller killed": (
        f"{CONTROLLER}/kill",
        "SIGKILL to the process of the controller, which is then started again",
    ),
}


class RosSteering(Steering):
    """Requests to the nodes of one aircraft.

    What is steered depends on who is there: with a real autopilot there is no simulator, with a
    tracker no simulated target, and only the launcher of a simulated flight kills controllers.

    Args:
        node: That asks (rclpy's Node), in an executor that is spun in a thread of its own.
        namespace: Of the aircraft, with or without slashes at its ends; empty for none.
    """

    def __init__(self, node: Any, namespace: str) -> None:
        self._requests = SteeringRequests(
            node,
            namespace,
            owners=(CONTROLLER, SIMULATOR, TARGET),
            switches=(ENGAGE, PAUSE),
            triggers=(RESET, *(service for service, _ in FAULTS.values())),
        )

    @property
    def nodes(self) -> frozenset[str]:  # type: ignore[override]  # only read
        """Who is there now."""
        return frozenset(
            owner
            for owner in (CONTROLLER, SIMULATOR, TARGET)
            if self._requests.offered(f"{owner}/set_parameters_atomically")
        )

    @property
    def faults(self) -> Mapping[str, str]:  # type: ignore[override]  # only read
        """Those that somebody offers now."""
        return {
            name: words
            for name, (service, words) in FAULTS.items()
            if self._requests.offered(service)
        }

    def parameters(self, node: str) -> Mapping[str, Any]:
        """See :meth:`Steering.parameters`; empty where the node does not answer.

        Args:
            node: One of ``nodes``.
        """
        try:
            return self._requests.parameters(node)
        except NoAnswerError:
            return {}

    def change(self, node: str, **values: Any) -> str:
        """See :meth:`Steering.change`.

        Args:
            node: One of ``nodes``.
            values: By name.
        """
        try:
            return self._requests.change(node, values)
        except NoAnswerError as error:
            return str(error)

    def send_target(self, east: float, north: float) -> str:
        """See :meth:`Steering.send_target`.

        A topic does not answer: that the goal is taken, or why it is not, the parameters tell,
        which a goal sets.

        Args:
            east: In ``map`` in [m].
            north: In ``map`` in [m].
        """
        if not (math.isfinite(east) and math.isfinite(north)):
            return f"the target cannot go to ({east}, {north}): both must be finite"
        goal = self._requests.send_goal(east, north)
        if goal is None:
            return f"{TARGET} has not told where the target is"
        return self.change(TARGET, motion="stationary", position=goal)

    def pause(self, still: bool) -> str:
        """See :meth:`Steering.pause`.

        Args:
            still: Whether it is to stand.
        """
        return self._call(PAUSE, data=still)

    def reset(self) -> str:
        """See :meth:`Steering.reset`."""
        return self._call(RESET)

    def engage(self, on: bool) -> str:
        """See :meth:`Steering.engage`.

        Args:
            on: Whether it is to command.
        """
        return self._call(ENGAGE, data=on)

    def inject(self, fault: str) -> str:
        """See :meth:`Steering.inject`.

        Args:
            fault: One of ``faults``.
        """
        if fault not in self.faults:
            known = ", ".join(self.faults) or "none"
            return f"fault {fault!r} is not offered here; offered: {known}"
        return self._call(FAULTS[fault][0])

    def _call(self, service: str, **request: Any) -> str:
        try:
            return self._requests.call(service, **request)
        except NoAnswerError as error:
            return str(error)
