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

"""The linearised motion near an orbit beside the vehicle that is flown."""

import math
from dataclasses import replace

import numpy as np
import pytest

from uav_tracking_mpc.control.orbit_deviation import SIZE, STEPS, FrozenOrbit
from uav_tracking_mpc.dynamics.orbit import CLOCKWISE, COUNTER_CLOCKWISE, Orbit
from uav_tracking_mpc.dynamics.vehicle_models import Drift
from uav_tracking_mpc.dynamics.vehicle_models.lagged import Lagged

LAGS = (0.3, 0.13, 0.16)
WIND = np.array([-5.0, 8.0, 0.0])


def frozen(drift=(0.0, 0.0, 0.0), azimuth=0.7, direction=CLOCKWISE):
    return FrozenOrbit(Orbit(300.0, 120.0, 22.0, direction), np.array(drift), azimuth)


@pytest.mark.parametrize("direction", [CLOCKWISE, COUNTER_CLOCKWISE])
@pytest.mark.parametrize("drift", [np.zeros(3), WIND, np.array([3.0, -2.0, 1.0])])
def test_the_orbit_is_flown_along_the_orbit(direction, drift):
    """The relative velocity is tangential and level."""
    where = frozen(drift, 2.1, direction)
    situation = where.situation(np.zeros(SIZE))
    relative, offset = situation.relative_velocity, situation.offset
    assert np.hypot(*offset[:2]) == pytest.approx(math.sqrt(300.0**2 - 120.0**2))
    assert relative[2] == pytest.approx(0.0, abs=1e-9)
    assert relative[:2] @ offset[:2] == pytest.approx(0.0, abs=1e-6)
    sense = 1.0 if direction == COUNTER_CLOCKWISE else -1.0
    assert sense * (offset[0] * relative[1] - offset[1] * relative[0]) > 0.0
    assert situation.airspeed == 22.0


def test_a_deviation_is_where_it_says():
    where = frozen()
    deviation = np.array([5.0, 2.0, 0.1, 0.02, 1.0, 0.01, 0.02, 0.3])
    there, orbit = where.situation(deviation), where.situation(np.zeros(SIZE))
    assert np.hypot(*there.offset[:2]) - np.hypot(*orbit.offset[:2]) == pytest.approx(5.0)
    assert there.offset[2] - orbit.offset[2] == pytest.approx(2.0)
    assert there.vehicle[3:] - orbit.vehicle[3:] == pytest.approx(deviation[2:5])
    assert there.rates - orbit.rates == pytest.approx(deviation[5:])


def flown_deviation(where, deviation, duration, inputs=(0.0, 0.0, 0.0)):
    """Deviation from the orbit, at the azimuth that is reached, after a time."""
    model, steps = Lagged(rate_lag=LAGS), 200
    numbers = model.numbers(duration / steps)
    state = model.initial(*_begin(where, deviation))
    drift = Drift(where.drift.tolist(), [0.0] * 3)
    commands = np.array([where.motion()[5], 0.0, 0.0]) + inputs
    for _ in range(steps):
        state = model.step(state, commands.tolist(), duration / steps, numbers.tolist(), drift)
    azimuth = math.atan2(state.y, state.x)
    course = math.remainder(state.heading - azimuth, 2.0 * math.pi)
    there = np.array([math.hypot(state.x, state.y), state.z, course, *state[4:]])
    return there - replace(where, azimuth=azimuth).motion()


def _begin(where, deviation):
    situation = where.situation(deviation)
    return situation.vehicle, situation.target, situation.rates


@pytest.mark.parametrize("drift", [np.zeros(3), WIND])
def test_the_derivative_is_that_of_the_flight(drift):
    where, short = frozen(drift), 1e-3
    a, b = where.dynamics(LAGS)
    still = flown_deviation(where, np.zeros(SIZE), short)
    for component, step in enumerate(0.1 * STEPS):
        deviation = np.zeros(SIZE)
        deviation[component] = step
        change = flown_deviation(where, deviation, short) - still - deviation
        expected = short * a @ deviation + 0.5 * short**2 * a @ a @ deviation
        np.testing.assert_allclose(change / step, expected / step, atol=3e-6 / step * 0.01 + 1e-5)
    for axis in range(3):
        inputs = np.zeros(3)
        inputs[axis] = 0.1
        change = flown_deviation(where, np.zeros(SIZE), short, inputs) - still
        expected = short * b[:, axis] + 0.5 * short**2 * a @ b[:, axis]
        np.testing.assert_allclose(change / 0.1, expected, atol=1e-5)


def test_in_still_air_the_azimuth_does_not_matter():
    first, second = (frozen(azimuth=azimuth).dynamics(LAGS)[0] for azimuth in (0.3, 4.0))
    np.testing.assert_allclose(first, second, atol=1e-8)
