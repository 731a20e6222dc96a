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

"""Messages that come several times."""

from __future__ import annotations

from collections.abc import Sequence

from uav_tracking_mpc.nodes.topics import Topic
from uav_tracking_mpc.studies.faults.stream_fault import Delivery, TopicFault

LATEST = 0.3  # s of simulated time by which the third copy is late, at most


class Duplicated(TopicFault):
    """Delivers a message twice at once, and a third time later."""

    name = "duplicated"

    def deliver(self, topic: Topic, data: bytes) -> Sequence[Delivery]:
        """See :meth:`StreamFault.deliver`."""
        return [(0.0, data), (0.0, data), (self.rng.uniform(0.0, LATEST), data)]
