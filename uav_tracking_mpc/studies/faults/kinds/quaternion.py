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

"""An attitude that is none."""

from __future__ import annotations

from typing import Any

from uav_tracking_mpc.nodes.topics import ODOMETRY, Topic
from uav_tracking_mpc.studies.faults.stream_fault import MessageFault


class Quaternion(MessageFault):
    """Sends the quaternion (0, 0, 0, 0)."""

    name = "quaternion"
    topics = (ODOMETRY,)

    def change(self, topic: Topic, message: Any) -> None:
        """See :meth:`MessageFault.change`."""
        q = message.pose.pose.orientation
        q.x = q.y = q.z = q.w = 0.0
