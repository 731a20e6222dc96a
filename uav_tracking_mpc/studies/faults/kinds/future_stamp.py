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

"""Stamps of the future."""

from __future__ import annotations

from typing import Any

from uav_tracking_mpc.nodes.topics import Topic
from uav_tracking_mpc.studies.faults.message_fields import shift
from uav_tracking_mpc.studies.faults.stream_fault import MessageFault


class FutureStamp(MessageFault):
    """Stamps a message 0.2 s to 20 s too late, or with the last time there is."""

    name = "future_stamp"

    def change(self, topic: Topic, message: Any) -> None:
        """See :meth:`MessageFault.change`."""
        shift(message.header.stamp, self.rng.choice((self.rng.uniform(0.2, 20.0), 1e10)))
