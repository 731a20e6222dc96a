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

"""Read a bag: how far the aircraft was from its orbit, from the messages of a flight alone.

Every ``uav_tracking fly`` leaves its flight as ``mission.mcap``. No ROS is needed to read it::

    uav_tracking fly --config paper --output output/demo
    python examples/read_a_bag.py output/demo/mission.mcap
"""

import sys
from pathlib import Path

import numpy as np
from rosbags.highlevel import AnyReader

from uav_tracking_mpc import load_configuration


def distances(bag: Path) -> tuple[np.ndarray, np.ndarray]:
    """Times in [s] and distances from aircraft to target in [m], both of shape (n,)."""
    target, times, ranges = None, [], []
    with AnyReader([bag]) as reader:
        wanted = [c for c in reader.connections if c.topic in ("/uav/odometry", "/target/position")]
        for connection, _, data in reader.messages(wanted):
            message = reader.deserialize(data, connection.msgtype)
            point = message.pose.pose.position if "odometry" in connection.topic else message.point
            position = np.array([point.x, point.y, point.z])
            if connection.topic == "/target/position":
                target = position
            elif target is not None:
                stamp = message.header.stamp
                times.append(stamp.sec + 1e-9 * stamp.nanosec)
                ranges.append(np.linalg.norm(position - target))
    return np.array(times), np.array(ranges)


if __name__ == "__main__":
    if len(sys.argv) != 2 or not Path(sys.argv[1]).exists():
        print(f"usage: {sys.argv[0]} BAG", file=sys.stderr)
        sys.exit(2)
    time, distance = distances(Path(sys.argv[1]))
    error = np.abs(distance - load_configuration("paper").controller.range)
    outside = np.flatnonzero(error > 1.0)
    print(f"{len(time)} states in {time[-1] - time[0]:.1f} s")
    print(f"within 1 m of the orbit's range after {time[outside[-1]] - time[0]:.1f} s")
