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

from uav_tracking_mpc.settings.simulator import TargetParameters
from uav_tracking_mpc.simulation.motions.straight import Jump, Line, Stationary, StopAndGo, Weaving


def test_it_stands_whatever_its_speed():
    target = Stationary(TargetParameters(position=(1.0, 2.0, 3.0), speed=5.0))
    np.testing.assert_array_equal(target.position(9.0), [1.0, 2.0, 3.0])
    np.testing.assert_array_equal(target.velocity(9.0), np.zeros(3))


def test_it_runs_straight_towards_its_heading():
    line = Line(TargetParameters(position=(1.0, 2.0, 3.0), speed=5.0, heading=np.pi / 2))
    np.testing.assert_allclose(line.position(4.0), [1.0, 22.0, 3.0])
    np.testing.assert_allclose(line.velocity(4.0), [0.0, 5.0, 0.0], atol=1e-12)


def test_it_is_elsewhere_at_once_and_drives_on():
    parameters = TargetParameters(
        position=(1.0, 2.0, 3.0), speed=5.0, jump_time=10.0, jump_offset=(-100.0, 50.0, 5.0)
    )
    target = Jump(parameters)
    np.testing.assert_allclose(target.position(10.0 - 1e-9), [51.0, 2.0, 3.0], atol=1e-6)
    np.testing.assert_allclose(target.position(10.0), [-49.0, 52.0, 8.0])
    np.testing.assert_allclose(target.position(11.0), [-44.0, 52.0, 8.0])
    np.testing.assert_array_equal(target.velocity(10.0), [5.0, 0.0, 0.0])


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


def test_it_weaves_across_its_way():
    parameters = TargetParameters(
        position=(1.0, 2.0, 3.0), speed=5.0, heading=0.0, weave_speed=3.0, weave_period=8.0
    )
    target = Weaving(parameters)
    np.testing.assert_allclose(target.position(8.0), [41.0, 2.0, 3.0], atol=1e-12)
    np.testing.assert_allclose(target.velocity(2.0), [5.0, 3.0, 0.0], atol=1e-12)
