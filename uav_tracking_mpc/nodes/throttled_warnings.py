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

"""Warnings that may come with every message: one line a subject and period."""

from __future__ import annotations

import time

from rclpy.node import Node

PERIOD = 5.0  # s between warnings of one subject


class ThrottledWarnings:
    """The logger's own throttle is one for all topics: a stream of refusals would hide another's.

    Args:
        node: Whose log they are in.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._last: dict[str, float] = {}

    def warn(self, subject: str, words: str) -> None:
        """Log a warning unless one of its subject was logged just before.

        Args:
            subject: One of a few, such as the name of a topic.
            words: What there is to say.
        """
        now = time.monotonic()
        if now - self._last.get(subject, -PERIOD) >= PERIOD:
            self._last[subject] = now
            self._node.get_logger().warning(words)
