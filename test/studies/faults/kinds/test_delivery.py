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

import numpy as np
import pytest

pytest.importorskip("rclpy")

from fault_streams import STREAM_FAULTS, arrivals

from uav_tracking_mpc.nodes.topics import AIR_VELOCITY, CLOCK, COMMAND, ODOMETRY, TARGET


@pytest.mark.parametrize(
    ("label", "share", "latest"),
    [
        ("loss", pytest.approx(0.8, abs=0.1), 0.0),
        ("jitter", 1.0, 0.2),
        ("odometry_reordered", 1.0, 0.3),
        ("odometry_duplicated", 3.0, 0.3),
    ],
)
def test_so_much_arrives_so_late(label, share, latest):
    heard = arrivals(label, ODOMETRY, 1000)
    delays = np.array([delay for delay, _ in heard])
    assert len(heard) / 1000 == share
    assert delays.min() < 0.02
    assert delays.max() == pytest.approx(latest, abs=0.02)
    if label == "odometry_reordered":
        assert set(delays) == {0.0, 0.3}  # on time, or behind later ones
    if label == "odometry_duplicated":
        assert {message.header.stamp.sec for _, message in heard[:3]} == {100}


@pytest.mark.parametrize(
    ("label", "topics"),
    [
        ("gap_state", (ODOMETRY, AIR_VELOCITY)),
        ("gap_target", (TARGET,)),
        ("gap_command", (COMMAND,)),
        ("target_lost", (TARGET,)),
        ("clock_pause", (CLOCK,)),
    ],
)
def test_silence_leaves_nothing(label, topics):
    assert STREAM_FAULTS[label].streams == topics
    for topic in topics:
        assert arrivals(label, topic) == []
