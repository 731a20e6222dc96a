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

"""Every plant passes the check, changes in flight or says that it cannot, and is measured."""

from dataclasses import replace

import numpy as np
import pytest

from uav_tracking_mpc.dynamics.frames import wrap_angle
from uav_tracking_mpc.estimation.measurement import SILENT, Measurement, SensorNoise
from uav_tracking_mpc.parameters.conformance import ConformanceError
from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.simulator import SimulatorParameters
from uav_tracking_mpc.simulation.plants import PLANT, Plant, VehicleSensors
from uav_tracking_mpc.simulation.plants.conformance import check_plant
from uav_tracking_mpc.simulation.plants.euler import EulerPlant
from uav_tracking_mpc.simulation.plants.jsbsim import JSBSimPlant
from uav_tracking_mpc.simulation.plants.vehicle import HeldPlant, VehiclePlant


@pytest.mark.parametrize("name", PLANT.names)
def test_every_plant_passes(name):
    check_plant(PLANT.find(name))


class Degrees(VehiclePlant):
    @property
    def truth(self):
        truth = super().truth
        return replace(truth, heading=np.degrees(truth.heading))


class Gullible(VehiclePlant):
    def accept(self, inputs, starts):
        if np.shape(inputs) == (1, 2):
            return
        super().accept(inputs, starts)


class Random(VehiclePlant):
    def advance(self, duration):
        super().advance(duration)
        self.state[0] += np.random.default_rng().normal() * (duration > 0.0)


class Frozen(VehiclePlant):
    def advance(self, duration):
        self.time += duration


class Timeless(VehiclePlant):
    def advance(self, duration):
        before = self.time
        super().advance(duration)
        self.time = before


class Diverging(VehiclePlant):
    def advance(self, duration):
        super().advance(duration)
        self.state[2] = np.inf if self.time > 1.0 else self.state[2]


class Unready(VehiclePlant):
    def __init__(self, parameters):
        raise RuntimeError("no licence")


@pytest.mark.parametrize(
    ("plant", "words"),
    [
        (Unready, "vehicle: RuntimeError: no licence"),
        (Degrees, r"truth at 0.05 s: heading is .*are the units right"),
        (Gullible, "a plan of the wrong shape is taken, must raise ValueError"),
        (Random, "differs from that of another with its seed"),
        (Frozen, "has not moved"),
        (Timeless, "has the stamp 0.0 s after 1 steps of 0.05 s"),
        (Diverging, "position is .*inf.*, must be three finite numbers"),
    ],
)
def test_what_is_wrong_is_said(plant, words):
    with pytest.raises(ConformanceError, match=words):
        check_plant(plant)


PARAMETERS = SimulatorParameters(
    initial_position=(400.0, 0.0, 120.0), initial_heading=1.0, initial_path_angle=0.0,
    initial_speed=22.0, speed_max=40.0, bank_max=0.8,
)  # fmt: skip


class Outside(Plant):
    """What knows nothing of changes: it moves straight on."""

    name = "outside"

    def advance(self, duration):
        self.time += duration

    @property
    def truth(self):
        return replace(VehiclePlant(self.parameters).truth, stamp=self.time)


ALL = (VehiclePlant, HeldPlant, JSBSimPlant, EulerPlant, Outside)


@pytest.mark.parametrize("kind", [VehiclePlant, HeldPlant, JSBSimPlant])
def test_other_wind_carries_it_away_without_a_jump(kind):
    plant, still = kind(PARAMETERS), kind(PARAMETERS)
    before = plant.truth.position
    plant.change(replace(PARAMETERS, wind=(3.0, -4.0, 0.0)))
    np.testing.assert_allclose(plant.truth.position, before, atol=1e-9)
    for _ in range(20):
        plant.advance(0.05)
        still.advance(0.05)
        np.testing.assert_allclose(plant.wind, [3.0, -4.0, 0.0], atol=1e-6)
    drifted = plant.truth.position - still.truth.position
    if kind is JSBSimPlant:  # it has mass: the wind takes it along by and by
        assert drifted[0] > 0.1 and drifted[1] < -0.1
    else:
        np.testing.assert_allclose(drifted, [3.0, -4.0, 0.0], atol=1e-6)


@pytest.mark.parametrize("kind", [VehiclePlant, HeldPlant, JSBSimPlant])
def test_gusts_begin_and_end(kind):
    plant = kind(PARAMETERS)

    def spread():
        winds = []
        for _ in range(200):
            plant.advance(0.05)
            winds.append(plant.wind)
        return np.std(winds, axis=0).max()

    assert spread() < 1e-9
    plant.change(replace(PARAMETERS, gust_intensity=8.0))
    assert spread() > 0.1
    plant.change(PARAMETERS)
    plant.advance(30.0)  # what is in the filters dies away
    assert spread() < 0.01


@pytest.mark.parametrize("kind", ALL)
def test_sensors_become_noisy_and_true_again(kind):
    plant = kind(PARAMETERS)
    plant.change(replace(PARAMETERS, position_noise=2.0, heading_bias=0.1, speed=3.0))
    first, second = plant.measured(), plant.measured()
    assert not np.array_equal(first.position, second.position)
    assert first.heading == pytest.approx(plant.aboard.heading + 0.1)
    plant.change(PARAMETERS)
    np.testing.assert_array_equal(plant.measured().position, plant.truth.position)


@pytest.mark.parametrize("kind", ALL)
@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"seed": 3}, "'seed' is 3, must stay 0 while the simulator runs"),
        ({"initial_speed": 21.0}, "'initial_speed' is 21.0, must stay 22.0 while"),
        ({"hold_climb_max": 1.0}, "cannot change it in flight"),
    ],
)
def test_what_stays_is_told_and_nothing_is_half_applied(kind, values, words):
    plant = kind(PARAMETERS)
    with pytest.raises(ParameterError, match=words):
        plant.change(replace(PARAMETERS, position_noise=2.0, **values))
    assert plant.parameters is PARAMETERS
    np.testing.assert_array_equal(plant.measured().position, plant.truth.position)


@pytest.mark.parametrize("kind", [EulerPlant, Outside])
def test_a_plant_without_air_to_change_says_so(kind):
    plant = kind(PARAMETERS)
    with pytest.raises(ParameterError, match=f"the plant '{kind.name}' cannot change it in flight"):
        plant.change(replace(PARAMETERS, wind=(1.0, 0.0, 0.0)))


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
    errors = np.array(
        [[*each.state(each.airspeed), *each.ground_velocity] for each in measured]
    ) - [*TRUTH.state(TRUTH.airspeed), *TRUTH.ground_velocity]
    errors[:, 3] = wrap_angle(errors[:, 3])
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
    states = [sensors(seed=3, **NOISE).measure(TRUTH).state(0.0) for _ in range(2)]
    np.testing.assert_array_equal(*states)


def test_a_measured_airspeed_is_never_negative_and_none_stays_none():
    slow = replace(TRUTH, airspeed=0.0)
    sensor = sensors(airspeed_noise=1.0)
    assert min(sensor.measure(slow).airspeed for _ in range(50)) == 0.0
    assert sensor.measure(replace(TRUTH, airspeed=None)).airspeed is None


def test_what_is_stuck_keeps_what_it_measured_last_until_it_is_repaired():
    stuck = dict.fromkeys(("airspeed_fault", "heading_fault", "velocity_fault"), "stuck")
    sensor = sensors(**stuck, position_fault="frozen")
    sensor.measure(TRUTH)
    later = replace(
        TRUTH, position=TRUTH.position + 1.0, heading=1.0, airspeed=30.0, ground_velocity=np.ones(3)
    )
    seen = sensor.measure(later)
    np.testing.assert_array_equal(seen.state(seen.airspeed), TRUTH.state(TRUTH.airspeed))
    np.testing.assert_array_equal(seen.ground_velocity, TRUTH.ground_velocity)
    sensor.change(SimulatorParameters(heading_fault="stuck", position_fault="level"))
    seen = sensor.measure(later)
    level = [*later.position[:2], TRUTH.position[2]]
    np.testing.assert_array_equal(seen.position, level)
    assert (seen.heading, seen.airspeed) == (TRUTH.heading, 30.0)
    sensor.change(SimulatorParameters())
    assert sensor.measure(later) is later


def test_biases_are_added_to_what_they_name_alone():
    biases = {"heading_bias": 0.1, "airspeed_bias": 2.0, "turn_rate_bias": -0.03}
    measured = sensors(velocity_bias=(1.0, -2.0, 0.5), **biases).measure(TRUTH)
    error = measured.ground_velocity - TRUTH.ground_velocity
    np.testing.assert_allclose(error, [1.0, -2.0, 0.5])
    expected = [*TRUTH.position, 3.24 - 2.0 * np.pi, TRUTH.path_angle, 24.0]
    np.testing.assert_allclose(measured.state(measured.airspeed), expected)
    assert measured.turn_rate == -0.03


@pytest.mark.parametrize("stamp_true", [True, False])
def test_a_late_state_is_that_of_a_delay_ago_and_its_stamp_may_lie(stamp_true):
    late = sensors(state_delay=0.3, state_stamp_true=stamp_true)
    times = np.arange(20) * 0.05
    seen = [late.measure(replace(TRUTH, stamp=t, position=[t, 0.0, 0.0])) for t in times]
    measured_at = np.maximum(times - 0.3, 0.0)
    np.testing.assert_allclose([each.position[0] for each in seen], measured_at, atol=1e-9)
    stamps = measured_at if stamp_true else times
    np.testing.assert_allclose([each.stamp for each in seen], stamps, atol=1e-9)
