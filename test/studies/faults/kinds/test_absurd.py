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

from fault_streams import arrivals

from uav_tracking_mpc.nodes.conversions import position_from_point, vehicle_from_odometry
from uav_tracking_mpc.nodes.topics import ODOMETRY, TARGET


@pytest.mark.parametrize(
    ("label", "topic", "read"),
    [
        ("odometry_absurd", ODOMETRY, vehicle_from_odometry),
        ("target_absurd", TARGET, position_from_point),
    ],
)
def test_absurd_places_pass_every_check_of_a_single_message(label, topic, read):
    values = np.array([read(message) for _, message in arrivals(label, topic)])
    assert np.all(np.isfinite(values))
    assert np.max(np.abs(values)) > 1e6
