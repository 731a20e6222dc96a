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
import small_uav

from uav_tracking_mpc.dynamics.orbit import CLOCKWISE, COUNTER_CLOCKWISE, Orbit
from uav_tracking_mpc.dynamics.vehicle import Response
from uav_tracking_mpc.dynamics.vehicle_models import Drift
from uav_tracking_mpc.dynamics.vehicle_models.lagged import Lagged
from uav_tracking_mpc.margins.loop_margins import loop_margins
from uav_tracking_mpc.margins.orbit_loop import SIZE, STEPS, FrozenOrbit, OrbitLoop, sampled_loop
from uav_tracking_mpc.mpc import compiled_method
from uav_tracking_mpc.mpc.compiled_method import Compilation
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.symbolic.functions import LOCK

LAGS = (0.3, 0.13, 0.16)
WIND = np.array([-5.0, 8.0, 0.0])


def frozen(drift=(0.0, 0.0, 0.0), azimuth=0.7, direction=CLOCKWISE):
    return FrozenOrbit(Orbit(300.0, 120.0, 22.0, direction), np.array(drift), azimuth)


@pytest.mark.parametrize("direction", [CLOCKWISE, COUNTER_CLOCKWISE])
@pytest.mark.parametrize("drift", [np.zeros(3), WIND, np.array([3.0, -2.0, 1.0])])
def test_the_orbit_is_flown_along_the_orbit(direction, drift):
    """The relative velocity is tangential and level."""
    situation = frozen(drift, 2.1, direction).situation(np.zeros(SIZE))
    (x, y, _), (east, north, up) = situation.offset, situation.relative_velocity
    assert math.hypot(x, y) == pytest.approx(math.sqrt(300.0**2 - 120.0**2))
    assert (up, x * east + y * north) == pytest.approx((0.0, 0.0), abs=1e-6)
    assert (x * north - y * east > 0.0) == (direction == COUNTER_CLOCKWISE)
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
    numbers, begin = model.numbers(duration / steps), where.situation(deviation)
    state = model.initial(begin.vehicle, begin.target, begin.rates)
    drift = Drift(where.drift.tolist(), [0.0] * 3)
    commands = np.array([where.motion()[5], 0.0, 0.0]) + inputs
    for _ in range(steps):
        state = model.step(state, commands.tolist(), duration / steps, numbers.tolist(), drift)
    azimuth = math.atan2(state.y, state.x)
    course = math.remainder(state.heading - azimuth, 2.0 * math.pi)
    there = np.array([math.hypot(state.x, state.y), state.z, course, *state[4:]])
    return there - replace(where, azimuth=azimuth).motion()


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


STILL = np.zeros(3)


@pytest.fixture(scope="module")
def loop():
    return OrbitLoop(small_uav.parameters())


def test_the_gain_is_a_derivative(loop):
    """Half the differences give the same: neither limits nor the solver's tolerance show."""
    where = loop.orbit_in(STILL)
    whole = loop.gain(where)
    deviation = np.array([0.05, -0.02, 5e-4, 2e-4, 0.01, -5e-4, 1e-4, 0.01])
    above, below = (loop._answer(where.situation(s * deviation), 0.0) for s in (1.0, -1.0))
    np.testing.assert_allclose(above - below, 2.0 * whole @ deviation, rtol=2e-3, atol=1e-6)


def test_small_uav_has_the_margins_that_are_asked_and_in_still_air_at_every_azimuth_the_same(loop):
    found, turned = (loop.margins(loop.orbit_in(STILL, azimuth)) for azimuth in (0.0, 3.0))
    assert found.disk == pytest.approx(turned.disk, rel=1e-3)
    assert min(channel.gain_db for channel in found.channels.values()) >= 6.0
    in_wind = [loop.margins(loop.orbit_in(WIND, azimuth)) for azimuth in (0.0, 2.0, 4.0)]
    for margins in (found, *in_wind):
        assert min(channel.delay_s for channel in margins.channels.values()) >= 0.3


def test_other_weights_have_other_margins(loop):
    quick = small_uav.parameters("input_weights=[0.04, 0.04, 0.2]", "rate_weights=[0.0, 0.0, 0.0]")
    found = []
    for parameters in (small_uav.parameters(), quick, small_uav.parameters()):
        loop.change(parameters)
        found.append(loop.margins(loop.orbit_in(STILL)))
    calm, hasty, again = found
    assert hasty.channels["turn"].delay_s < 0.3 < calm.channels["turn"].delay_s
    assert again.disk == pytest.approx(calm.disk, rel=1e-3)
    # An aircraft that is later than its margin is unstable.
    late = loop.told.dead_times + np.array([0.0, 1.05 * again.channels["path"].delay_s, 0.0])
    assert loop.margins(loop.orbit_in(STILL), loop.told._replace(dead_times=late)).disk == 0.0


@pytest.mark.parametrize(
    ("config", "overrides"),
    [
        ("small_uav", ["nmpc_controller.law=l1"]),
        ("small_uav", ["nmpc_controller.law=vector_field"]),
        ("paper", []),
    ],
)
def test_laws_and_the_papers_controller_have_margins_too(config, overrides):
    found = OrbitLoop(load_configuration(config, overrides).controller)
    margins = found.margins(found.orbit_in(STILL))
    assert 0.0 < margins.disk < 2.0
    assert all(math.isfinite(channel.gain_db) for channel in margins.channels.values())
    assert margins.channels["turn"].delay_s > 0.2


PERIOD = 0.05
STILL_SAMPLED_LOOP = FrozenOrbit(Orbit(300.0, 120.0, 22.0), np.zeros(3), 0.0)
TOLD = Response(np.array([0.3, 0.13, 0.16]), np.array([0.17, 0.2, 0.1]), np.ones(3))
# distance, height, course, path angle, airspeed, and their rates
GAIN = np.array(
    [
        [-0.02, 0.0, -1.2, 0.0, 0.0, -0.3, 0.0, 0.0],
        [0.0, -0.12, -0.1, -2.7, 0.0, 0.0, -0.3, 0.0],
        [0.0, 0.0, 0.0, 0.0, -0.35, 0.0, 0.0, -0.06],
    ]
)


def loop_sampled_loop(plant=TOLD, told=TOLD, predicts=True, gain=GAIN):
    predicted = STILL_SAMPLED_LOOP.dynamics(told.lags) if predicts else None
    return sampled_loop(
        PERIOD, gain, STILL_SAMPLED_LOOP.dynamics(plant.lags), plant, predicted, told
    )


def margins(each):
    frequency = each.frequencies(600)
    return loop_margins(frequency, each.response(frequency))


def changed(response, name, axis, value):
    values = getattr(response, name).copy()
    values[axis] = value
    return response._replace(**{name: values})


@pytest.mark.parametrize("predicts", [True, False])
def test_the_response_is_that_of_the_closed_loop(predicts):
    """det(I + L) = 0 at the poles of the closed loop: |z| there, anywhere off the unit circle."""
    each = loop_sampled_loop(changed(TOLD, "dead_times", 0, 0.33), predicts=predicts)
    poles = np.linalg.eigvals(each.closed())
    slow = poles[np.abs(poles) > 0.8]
    assert len(slow) >= 5
    response = each.response(np.log(slow) / (1j * PERIOD))
    worst = np.abs(np.linalg.det(np.eye(3) + response)) / np.abs(response).max(axis=(1, 2))
    assert worst.max() < 1e-6


@pytest.mark.parametrize("predicts", [True, False])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_at_the_margins_the_loop_is_at_its_limit(axis, predicts):
    each = loop_sampled_loop(predicts=predicts)
    assert each.growth() < 0.999
    channel = list(margins(each).channels.values())[axis]
    for share, stable in ((0.99, True), (1.01, False)):
        longer = TOLD.dead_times[axis] + share * channel.delay_s
        late = loop_sampled_loop(changed(TOLD, "dead_times", axis, longer), predicts=predicts)
        assert (late.growth() < 1.0) == stable
        louder = 10.0 ** (share * channel.gain_increase_db / 20.0)
        loud = loop_sampled_loop(changed(TOLD, "gains", axis, louder), predicts=predicts)
        assert (loud.growth() < 1.0) == stable


def test_a_dead_time_of_whole_periods_is_a_delay():
    now, later = (
        loop_sampled_loop(changed(TOLD, "dead_times", 1, time), predicts=False)
        for time in (0.1, 0.25)
    )
    frequency = now.frequencies(20)
    delay = np.ones((20, 1, 3), dtype=complex)
    delay[:, 0, 1] = np.exp(-1j * frequency * 0.15)
    np.testing.assert_allclose(
        later.response(frequency), now.response(frequency) * delay, rtol=1e-9, atol=1e-12
    )


def test_prediction_of_what_is_true_takes_the_dead_time_out_of_the_poles():
    """A Smith predictor: the poles are those without dead time, where every one is the same."""
    gain = GAIN.copy()
    gain[2, 7] = 0.0  # the acceleration is worked out by half a step of its own
    even, none = (TOLD._replace(dead_times=np.full(3, time)) for time in (0.2, 0.0))
    with_it = loop_sampled_loop(even, even, gain=gain)
    without = loop_sampled_loop(none, none, predicts=False, gain=gain)
    assert with_it.growth() == pytest.approx(without.growth(), abs=2e-3)
    assert margins(with_it).disk < margins(without).disk


def test_gains_multiply_the_loop():
    frequency = loop_sampled_loop().frequencies(5)
    gains = np.array([2.0, 0.5, 3.0])
    np.testing.assert_allclose(
        loop_sampled_loop(TOLD._replace(gains=gains)).response(frequency),
        loop_sampled_loop().response(frequency) * gains,
    )


def test_channels_that_follow_at_once():
    quick = Response(np.zeros(3), np.zeros(3), np.ones(3))
    each = loop_sampled_loop(quick, quick)
    assert each.growth() < 1.0
    assert each.plant_step.shape == (SIZE, SIZE)
    assert replace(each, acceleration_share=1.0).growth() == pytest.approx(each.growth())


def test_a_change_in_flight_waits_for_no_compiler_of_the_margins(monkeypatch):
    """Only for what builds expressions, as that does which tells whether there is machine code."""
    locked, digest = [], compiled_method._digest

    def digested(problem):
        locked.append(LOCK._is_owned())
        return digest(problem)

    monkeypatch.setattr(compiled_method, "_digest", digested)
    monkeypatch.setattr(Compilation, "wait", lambda self: locked.append(LOCK._is_owned()))
    OrbitLoop(load_configuration("small_uav").controller)
    assert locked[:2] == [True, False]  # and then the machine code is there
