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

"""Finite values that no flight has."""

from __future__ import annotations

from typing import Any

from uav_tracking_mpc.nodes.topics import COMMAND, ODOMETRY, TARGET, Topic
from uav_tracking_mpc.studies.faults.message_fields import numbers
from uav_tracking_mpc.studies.faults.stream_fault import MessageFault

FAR = 9e6  # m; finite, within any check of plausibility that leaves room for the earth


class Absurd(MessageFault):
    """Sends a state or a target 9000 km away, or a command of 1000 rad/s."""

    name = "absurd"
    topics = (ODOMETRY, TARGET, COMMAND)

    def change(self, topic: Topic, message: Any) -> None:
        """See :meth:`MessageFault.change`."""
        choice = self.rng.choice
        if topic == COMMAND:
            for holder, name in numbers(topic, message):
                setattr(holder, name, choice((1e3, -1e3)))
            return
        place = message.point if topic == TARGET else message.pose.pose.position
        place.x, place.z = choice((FAR, -FAR)), choice((FAR, -FAR, 0.0))
        if topic == ODOMETRY:
            message.twist.twist.linear.x = choice((0.0, 900.0))
