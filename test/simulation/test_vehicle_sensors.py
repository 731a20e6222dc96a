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

import dataclasses

import numpy as np
import pytest

from uav_tracking_mpc.estimation.measurement import SILENT, Measurement, SensorNoise
from uav_tracking_mpc.settings.simulator import SimulatorParameters
from uav_tracking_mpc.simulation.vehicle_sensors import VehicleSensors

TRUTH = Measurement(
    stamp=7.0,
    position=np.array([100.0, -50.0, 120.0]),
    ground_velocity=np.array([20.0, 3.0, 0.0]),
    heading=3.14,
    path_angle=0.1,
    airspeed=22.0,
)
NOISE = {
    "position_noise": 2.0,
    "attitude_noise": 0.02,
    "airspeed_noise": 0.5,
    "velocity_noise": 0.3,
}


def sensors(seed=0, **noise):
    return VehicleSensors(SimulatorParameters(**noise), np.random.SeedSequence(seed))


def test_without_noise_they_tell_the_truth():
    assert sensors().measure(TRUTH) is TRUTH


def test_noise_is_as_large_as_told():
    measured = [sensor.measure(TRUTH) for sensor in [sensors(**NOISE)] for _ in range(4000)]
    assert all(abs(each.heading) <= np.pi for each in measured)
    position = np.array([each.position for each in measured]) - TRUTH.position
    velocity = np.array([each.ground_velocity for each in measured]) - TRUTH.ground_velocity
    heading = np.angle(np.exp(1j * np.array([each.heading - TRUTH.heading for each in measured])))
    path_angle = np.array([each.path_angle for each in measured]) - TRUTH.path_angle
    airspeed = np.array([each.airspeed for each in measured]) - TRUTH.airspeed
    errors = np.column_stack([position, heading, path_angle, airspeed, velocity])
    told = np.array([2.0, 2.0, 2.0, 0.02, 0.02, 0.5, 0.3, 0.3, 0.3])
    np.testing.assert_allclose(errors.std(axis=0), told, rtol=0.06)
    np.testing.assert_array_less(np.abs(errors.mean(axis=0)), 5.0 * told / np.sqrt(4000))


def test_they_tell_their_noise_but_not_that_of_the_airspeed_nor_biases():
    """The topic of the airspeed has no covariance."""
    measured = sensors(**NOISE, heading_bias=0.1).measure(TRUTH)
    assert measured.noise == SensorNoise((2.0,) * 3, (0.3,) * 3, 0.02, 0.02)
    assert sensors(heading_bias=0.1).measure(TRUTH).noise == SILENT
    assert sensors(position_noise=500.0).measure(TRUTH).noise == SILENT


def test_the_same_seed_measures_the_same():
    one, other = sensors(seed=3, **NOISE).measure(TRUTH), sensors(seed=3, **NOISE).measure(TRUTH)
    np.testing.assert_array_equal(one.position, other.position)
    assert one.heading == other.heading


def test_a_measured_airspeed_is_never_negative_and_none_stays_none():
    slow = dataclasses.replace(TRUTH, airspeed=0.0)
    sensor = sensors(airspeed_noise=1.0)
    assert min(sensor.measure(slow).airspeed for _ in range(50)) == 0.0
    assert sensor.measure(dataclasses.replace(TRUTH, airspeed=None)).airspeed is None


def test_biases_are_added_to_what_they_name_alone():
    biases = {"heading_bias": 0.1, "airspeed_bias": 2.0, "turn_rate_bias": -0.03}
    measured = sensors(velocity_bias=(1.0, -2.0, 0.5), **biases).measure(TRUTH)
    np.testing.assert_array_equal(measured.position, TRUTH.position)
    error = measured.ground_velocity - TRUTH.ground_velocity
    np.testing.assert_allclose(error, [1.0, -2.0, 0.5])
    assert measured.heading == pytest.approx(3.24 - 2.0 * np.pi)
    assert measured.airspeed == 24.0
    assert measured.turn_rate == -0.03
    assert measured.path_angle == TRUTH.path_angle


@pytest.mark.parametrize("stamp_true", [True, False])
def test_a_late_state_is_that_of_a_delay_ago_and_its_stamp_may_lie(stamp_true):
    late = sensors(state_delay=0.3, state_stamp_true=stamp_true)
    times = np.arange(20) * 0.05
    seen = [
        late.measure(dataclasses.replace(TRUTH, stamp=t, position=[t, 0.0, 0.0])) for t in times
    ]
    measured_at = np.maximum(times - 0.3, 0.0)
    np.testing.assert_allclose([each.position[0] for each in seen], measured_at, atol=1e-9)
    stamps = measured_at if stamp_true else times
    np.testing.assert_allclose([each.stamp for each in seen], stamps, atol=1e-9)
