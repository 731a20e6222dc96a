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

"""A service that keeps back for a while what a node sends, as if it were lost; for trials."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.node import Node
from std_srvs.srv import Trigger

DURATION = 15.0  # s of the node's time: longer than a plan, and than the target's default timeout


class Outage:
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
