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

"""Add a fault: the pitot tube ices up, and the airspeed that is measured stands still.

The fault is this one class. It strikes messages on their way to the controller; what must hold for
every flight is checked meanwhile, and what a fault adds is said in ``violations``::

    uav_tracking torture --minutes 10 --fault examples/add_a_fault.py:IcedPitot
"""

import sys
from collections.abc import Sequence

from rclpy.serialization import deserialize_message, serialize_message

from uav_tracking_mpc.cli.main import main
from uav_tracking_mpc.nodes.topics import AIR_VELOCITY, Topic
from uav_tracking_mpc.studies.faults.stream_fault import Delivery, StreamFault


class IcedPitot(StreamFault):
    """Delivers the first airspeed of the fault again and again, with the stamps of the new ones."""

    name = "iced_pitot"
    family = "air_velocity"
    duration = (2.0, 5.0)
    streams = (AIR_VELOCITY,)

    def deliver(self, topic: Topic, data: bytes) -> Sequence[Delivery]:
        """See :meth:`StreamFault.deliver`."""
        message = deserialize_message(data, topic.type)
        self.frozen = getattr(self, "frozen", message.twist)
        message.twist = self.frozen
        return [(0.0, serialize_message(message))]


if __name__ == "__main__":
    fault = f"{__file__}:IcedPitot"
    sys.exit(main(["torture", "--minutes", "1", "--fault", fault, *sys.argv[1:]]))
