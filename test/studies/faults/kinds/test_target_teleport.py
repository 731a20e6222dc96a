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

import math

import pytest

pytest.importorskip("rclpy")

from fault_streams import REACH, arrivals

from uav_tracking_mpc.nodes.topics import TARGET


def test_a_target_leaps_to_one_place_and_stays_there():
    places = {
        (message.point.x, message.point.y) for _, message in arrivals("target_teleport", TARGET)
    }
    ((x, y),) = places
    assert math.hypot(x - 1.0, y - 2.0) == pytest.approx(REACH)
