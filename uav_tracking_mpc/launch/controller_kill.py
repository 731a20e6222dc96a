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

"""Service ``nmpc_controller/kill`` of a launcher: the controller dies and starts again."""

from __future__ import annotations

from typing import Any

from rclpy.node import Node
from std_srvs.srv import Trigger

from uav_tracking_mpc.launch.supervisor import Supervisor

CONTROLLER = "nmpc_controller"


class ControllerKill:
    """Kills the controller of a simulated flight when it is asked to, for trials.

    A flight does not end over that death: the process is missed by nobody and started at once, as
    it was started before, with the parameters of the start.

    Args:
        node: Of the launcher; serves the service.
        supervisor: Of the controller's process.
    """

    def __init__(self, node: Node, supervisor: Supervisor) -> None:
        self._supervisor, self._wanted = supervisor, False
        node.create_service(Trigger, f"{CONTROLLER}/kill", self._on_request)

    def _on_request(self, request: Any, response: Any) -> Any:
        self._wanted = True  # a callback does not wait for the end of a process
        response.success = True
        response.message = f"{CONTROLLER} is killed and started again"
        return response

    def follow(self) -> None:
        """Do what was asked for since the last call."""
        if not self._wanted:
            return
        self._wanted = False
        self._supervisor.kill(CONTROLLER)
        self._supervisor.restart(CONTROLLER)
