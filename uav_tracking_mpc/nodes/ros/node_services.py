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

"""Services of nodes beside ROS's own: an outage for trials, and taking the commands away."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.node import Node
from std_srvs.srv import SetBool, Trigger

from uav_tracking_mpc.nodes.ros.managed_node import ManagedNode, Stage

DURATION = 15.0  # s of the node's time: longer than a plan, and than the target's default timeout


class SimulatedOutage:
    """Service ``~/lose_...`` (std_srvs/Trigger): it begins an outage that ends by itself.

    Whoever asked for it need not be there at its end. Asked again, it lasts from then on.

    Args:
        node: That keeps something back.
        service: Name of the service, without the node's.
        what: That is kept back, in words.
        time: Time by which it lasts in [s].
    """

    def __init__(self, node: Node, service: str, what: str, time: Callable[[], float]) -> None:
        self._node, self._service, self._what, self._time = node, service, what, time
        self._begin: float | None = None
        node.create_service(Trigger, f"~/{service}", self._on_request)

    @property
    def lasts(self) -> bool:
        """Whether it goes on now; where time goes back before its begin, it is over."""
        return self._begin is not None and 0.0 <= self._time() - self._begin < DURATION

    @property
    def words(self) -> str:
        """What is kept back, and for how long."""
        return f"{self._what} is kept back for {DURATION:g} s by the service {self._service}"

    def _on_request(self, request: Any, response: Any) -> Any:
        self._begin = self._time()
        response.success, response.message = True, self.words
        self._node.get_logger().info(f"{self._service}: {self.words}")
        return response


DISENGAGED = "disengaged by the service engage"


class CommandGate:
    """Takes the commands away from an active controller and gives them back.

    It is engaged at the start, and stays as it was told to be through deactivation and cleanup:
    what a pilot has stopped, a lifecycle manager does not start. Whether an autopilot *flies* what
    is sent is another matter, which its link decides (``autopilot_link/engage``).

    Args:
        node: The controller's.
        told: Called when an active node is to send commands from now on, or none any more.

    Attributes:
        engaged: Whether commands are to be sent.
    """

    def __init__(self, node: ManagedNode, told: Callable[[], None]) -> None:
        self.engaged = True
        self._node, self._told = node, told
        node.create_service(SetBool, "~/engage", self._on_request)

    def _on_request(self, request: Any, response: Any) -> Any:
        response.success, response.message = self._answer(request.data)
        self._node.get_logger().info(f"engage {str(request.data).lower()}: {response.message}")
        return response

    def _answer(self, wanted: bool) -> tuple[bool, str]:
        active = self._node.stage is Stage.ACTIVE
        if wanted and not active:
            return False, "not engaged: the node is not active, activate it first"
        self.engaged = wanted
        if active:
            self._told()
        if wanted:
            return True, "engaged: states are answered with commands"
        return True, "disengaged: the vehicle flies its plan to the end, then holds"
