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

"""What is no pose leaves no transform in a bag; test_flight_bag.py reads those that do."""

import numpy as np
import pytest
from rclpy.serialization import serialize_message

from uav_tracking_mpc.nodes.conversions import set_odometry
from uav_tracking_mpc.nodes.recorded_transform import recorded_transform
from uav_tracking_mpc.nodes.topics import ODOMETRY

STATE = np.array([1.0, 2.0, 3.0, 0.4, 0.1, 20.0])


def odometry():
    message = ODOMETRY.type()
    set_odometry(message, 1, STATE, np.zeros(3), np.zeros(3))
    return message


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("part", ["position", "orientation"])
def test_a_pose_that_is_not_finite_makes_none(part, value):
    message = odometry()
    assert recorded_transform(serialize_message(message)) is not None
    getattr(message.pose.pose, part).y = value
    assert recorded_transform(serialize_message(message)) is None


def test_bytes_that_end_too_early_make_none():
    data = serialize_message(odometry())
    expected = recorded_transform(data)
    assert expected.numbers[:3] == (1.0, 2.0, 3.0)
    poses = data.index(np.array([1.0, 2.0, 3.0]).tobytes()) + 7 * 8
    for length in range(poses):
        assert recorded_transform(data[:length]) is None
    assert recorded_transform(data[:poses]) == expected
    assert recorded_transform(b"\x00\x00\x00\x00" + data[4:]) is None  # big-endian
