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

"""Forward speed with the wrong sign."""

from __future__ import annotations

from typing import Any

from uav_tracking_mpc.nodes.topics import AIR_VELOCITY, ODOMETRY, Topic
from uav_tracking_mpc.studies.faults.stream_fault import MessageFault


class NegativeSpeed(MessageFault):
    """Turns the sign of the forward speed, over ground or through the air."""

    name = "negative_speed"
    topics = (ODOMETRY, AIR_VELOCITY)

    def change(self, topic: Topic, message: Any) -> None:
        """See :meth:`MessageFault.change`."""
        twist = message.twist.twist if topic == ODOMETRY else message.twist
        twist.linear.x = -twist.linear.x
