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

from fault_streams import FIRST, arrivals

from uav_tracking_mpc.nodes.topics import CLOCK


@pytest.mark.parametrize(("label", "sign"), [("clock_forward", 1), ("clock_backward", -1)])
def test_the_clock_jumps_by_one_offset_and_never_below_zero(label, sign):
    offsets = set()
    for seed in range(20):
        seconds = [message.clock.sec for _, message in arrivals(label, CLOCK, seed=seed)]
        assert min(seconds) >= 0
        if min(seconds) > 0:
            ((offset),) = {second - true for true, second in enumerate(seconds, FIRST)}
            offsets.add(offset)
    assert offsets
    assert all(sign * offset > 0 for offset in offsets)
