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
from uav_tracking_mpc.simulation.motions import motion_of
from uav_tracking_mpc.simulation.target_sensor import TargetSensor

MOVING = {"motion": "line", "speed": 5.0}


def fly(parameters, count=200, step=0.1):
    """(time delivered, time measured, position) of every delivery."""
    sensor, heard = TargetSensor(parameters, motion_of(parameters)), []
    for k in range(count):
        sensor.measure(k * step)
        heard += [(k * step, *delivery) for delivery in sensor.delivered(k * step)]
    return heard


def test_without_noise_it_is_the_truth_at_once():
    parameters = TargetParameters(**MOVING)
    heard = fly(parameters)
    assert len(heard) == 200
    for now, measured, position in heard:
        assert now == measured
        np.testing.assert_array_equal(position, motion_of(parameters).position(measured))


def test_noise_is_as_large_as_told_and_reproducible():
    parameters = TargetParameters(noise=3.0, seed=7)
    positions = np.array([position for _, _, position in fly(parameters, 4000)])
    np.testing.assert_allclose(positions.std(axis=0), 3.0, rtol=0.05)
    again = np.array([position for _, _, position in fly(parameters, 4000)])
    np.testing.assert_array_equal(positions, again)


def test_dropouts_are_as_frequent_as_told_and_leave_the_noise_of_the_others():
    whole = {t: p for _, t, p in fly(TargetParameters(noise=1.0), 4000)}
    some = {t: p for _, t, p in fly(TargetParameters(noise=1.0, dropout=0.3), 4000)}
    assert len(some) == pytest.approx(0.7 * 4000, rel=0.05)
    for time, position in some.items():
        np.testing.assert_array_equal(position, whole[time])
    assert not fly(TargetParameters(dropout=1.0))


def test_a_delayed_measurement_bears_the_time_of_measuring():
    parameters = TargetParameters(delay=0.35, **MOVING)
    heard = fly(parameters)
    assert heard[0][0] == pytest.approx(0.4)  # the first look after 0.35 s
    for now, measured, position in heard:
        assert 0.35 - 1e-8 <= now - measured <= 0.45
        np.testing.assert_array_equal(position, motion_of(parameters).position(measured))
    assert len(heard) == 196


def test_after_the_clock_went_back_nothing_of_the_future_is_delivered():
    parameters = TargetParameters(delay=1.0)
    sensor = TargetSensor(parameters, motion_of(parameters))
    sensor.measure(100.0)
    sensor.measure(2.0)
    assert [time for time, _ in sensor.delivered(200.0)] == [2.0]
