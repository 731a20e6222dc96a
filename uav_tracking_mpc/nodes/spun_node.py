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

"""A node in the background of a program that is none: its own context and thread."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable
from typing import Generic, TypeVar

from rclpy.context import Context
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.node import Node

from uav_tracking_mpc.nodes.log_folder import ensure_log_folder

N = TypeVar("N", bound=Node)
TURN = 0.1  # s that a turn of the executor may wait
logger = logging.getLogger(__name__)


class SpunNode(Generic[N]):
    """Spins a node until it is closed.

    Args:
        create: Makes the node, with the context as keyword argument ``context``.
        domain: ROS domain; that of the environment by default.

    Attributes:
        node: The node.
    """

    def __init__(self, create: Callable[..., N], domain: int | None = None) -> None:
        if changed := ensure_log_folder():
            logger.info(changed)
        self._context = Context()
        self._context.init(args=[], domain_id=domain)
        self.node = create(context=self._context)
        self._executor = EventsExecutor(context=self._context)
        self._executor.add_node(self.node)
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._spin, name=self.node.get_name(), daemon=True)
        self._thread.start()

    def _spin(self) -> None:
        while not self._ended.is_set():
            try:
                self._executor.spin_once(timeout_sec=TURN)
            except Exception:  # what a callback raises must not end the others
                logger.exception("%s", self.node.get_name())

    def close(self) -> None:
        """End the thread, the node and its context."""
        self._ended.set()
        self._thread.join()
        self._executor.shutdown()
        self.node.destroy_node()
        self._context.try_shutdown()
