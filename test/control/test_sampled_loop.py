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

"""The sampled loop: its response beside its closed form in time, and margins at its very limit."""

from dataclasses import replace

import numpy as np
import pytest

from uav_tracking_mpc.control.loop_margins import loop_margins
from uav_tracking_mpc.control.orbit_deviation import SIZE, FrozenOrbit
from uav_tracking_mpc.control.sampled_loop import sampled_loop
from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.dynamics.response import Response

PERIOD = 0.05
STILL = FrozenOrbit(Orbit(300.0, 120.0, 22.0), np.zeros(3), 0.0)
TOLD = Response(np.array([0.3, 0.13, 0.16]), np.array([0.17, 0.2, 0.1]), np.ones(3))
# distance, height, course, path angle, airspeed, and their rates
GAIN = np.array(
    [
        [-0.02, 0.0, -1.2, 0.0, 0.0, -0.3, 0.0, 0.0],
        [0.0, -0.12, -0.1, -2.7, 0.0, 0.0, -0.3, 0.0],
        [0.0, 0.0, 0.0, 0.0, -0.35, 0.0, 0.0, -0.06],
    ]
)


def loop(plant=TOLD, told=TOLD, predicts=True, gain=GAIN):
    predicted = STILL.dynamics(told.lags) if predicts else None
    return sampled_loop(PERIOD, gain, STILL.dynamics(plant.lags), plant, predicted, told)


def margins(each):
    frequency = each.frequencies(1200)
    return loop_margins(frequency, each.response(frequency))


def changed(response, name, axis, value):
    values = getattr(response, name).copy()
    values[axis] = value
    return response._replace(**{name: values})


@pytest.mark.parametrize("predicts", [True, False])
def test_the_response_is_that_of_the_closed_loop(predicts):
    """det(I + L) = 0 at the poles of the closed loop: |z| there, anywhere off the unit circle."""
    each = loop(changed(TOLD, "dead_times", 0, 0.33), predicts=predicts)
    poles = np.linalg.eigvals(each.closed())
    slow = poles[np.abs(poles) > 0.8]
    assert len(slow) >= 5
    response = each.response(np.log(slow) / (1j * PERIOD))
    worst = np.abs(np.linalg.det(np.eye(3) + response)) / np.abs(response).max(axis=(1, 2))
    assert worst.max() < 1e-6


@pytest.mark.parametrize("predicts", [True, False])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_at_the_margins_the_loop_is_at_its_limit(axis, predicts):
    each = loop(predicts=predicts)
    assert each.growth() < 0.999
    channel = list(margins(each).channels.values())[axis]
    for share, stable in ((0.99, True), (1.01, False)):
        longer = TOLD.dead_times[axis] + share * channel.delay_s
        late = loop(changed(TOLD, "dead_times", axis, longer), predicts=predicts)
        assert (late.growth() < 1.0) == stable
        louder = 10.0 ** (share * channel.gain_increase_db / 20.0)
        loud = loop(changed(TOLD, "gains", axis, louder), predicts=predicts)
        assert (loud.growth() < 1.0) == stable


def test_a_dead_time_of_whole_periods_is_a_delay():
    now, later = (
        loop(changed(TOLD, "dead_times", 1, time), predicts=False) for time in (0.1, 0.25)
    )
    frequency = now.frequencies(20)
    delay = np.ones((20, 1, 3), dtype=complex)
    delay[:, 0, 1] = np.exp(-1j * frequency * 0.15)
    np.testing.assert_allclose(
        later.response(frequency), now.response(frequency) * delay, rtol=1e-9, atol=1e-12
    )


def test_prediction_of_what_is_true_takes_the_dead_time_out_of_the_poles():
    """A Smith predictor: the poles are those without dead time, where every one is the same."""
    even = Response(np.array([0.3, 0.13, 0.16]), np.full(3, 0.2), np.ones(3))
    none = even._replace(dead_times=np.zeros(3))
    gain = GAIN.copy()
    gain[2, 7] = 0.0  # the acceleration is worked out by half a step of its own
    with_it, without = loop(even, even, gain=gain), loop(none, none, predicts=False, gain=gain)
    assert with_it.growth() == pytest.approx(without.growth(), abs=2e-3)
    assert margins(with_it).disk < margins(without).disk


def test_gains_multiply_the_loop():
    frequency = loop().frequencies(5)
    gains = np.array([2.0, 0.5, 3.0])
    np.testing.assert_allclose(
        loop(TOLD._replace(gains=gains)).response(frequency), loop().response(frequency) * gains
    )


def test_channels_that_follow_at_once():
    quick = Response(np.zeros(3), np.zeros(3), np.ones(3))
    each = loop(quick, quick)
    assert each.growth() < 1.0
    assert each.plant_step.shape == (SIZE, SIZE)
    assert replace(each, acceleration_share=1.0).growth() == pytest.approx(each.growth())
