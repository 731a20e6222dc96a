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

from uav_tracking_mpc.settings.target import TargetParameters
from uav_tracking_mpc.simulation.motions.stop_and_go import StopAndGo

TARGET = StopAndGo(
    TargetParameters(position=(1.0, 2.0, 3.0), speed=5.0, drive_time=4.0, stand_time=3.0)
)


@pytest.mark.parametrize(
    ("time", "east", "speed"),
    [
        (0.0, 1.0, 5.0),
        (4.0, 21.0, 0.0),
        (6.0, 21.0, 0.0),
        (7.0, 21.0, 5.0),
        (8.0, 26.0, 5.0),
        (18.0, 61.0, 0.0),
    ],
)
def test_it_drives_and_stands_in_turn(time, east, speed):
    np.testing.assert_allclose(TARGET.position(time), [east, 2.0, 3.0])
    np.testing.assert_allclose(TARGET.velocity(time), [speed, 0.0, 0.0])
