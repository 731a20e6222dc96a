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

import pytest

pytest.importorskip("rclpy")

from builtin_interfaces.msg import Time
from fault_streams import healthy

from uav_tracking_mpc.nodes.topics import AIR_VELOCITY, COMMAND, ODOMETRY, TARGET
from uav_tracking_mpc.studies.faults.message_fields import LATEST_STAMP, numbers, shift


def test_stamps_move_as_far_as_stamps_go():
    stamp = Time(sec=100, nanosec=500_000_000)
    shift(stamp, -0.75)
    assert (stamp.sec, stamp.nanosec) == (99, 750_000_000)
    shift(stamp, 1e10)
    assert stamp.sec == LATEST_STAMP


@pytest.mark.parametrize(
    ("topic", "count"), [(ODOMETRY, 7), (TARGET, 3), (AIR_VELOCITY, 3), (COMMAND, 9)]
)
def test_numbers_can_be_set(topic, count):
    message = healthy(topic)
    fields = numbers(topic, message)
    assert len(fields) == count
    for value, (holder, name) in enumerate(fields, 1):
        setattr(holder, name, float(value))
    assert [getattr(holder, name) for holder, name in numbers(topic, message)] == [
        *range(1, count + 1)
    ]
