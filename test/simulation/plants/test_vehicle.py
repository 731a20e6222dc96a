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

"""The vehicle (3) behind its inner loops: against SciPy, bit for bit, within its limits."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from uav_tracking_mpc.dynamics.frames import wrap_angle
from uav_tracking_mpc.dynamics.orbit import FlownOrbit
from uav_tracking_mpc.dynamics.vehicle import advance, velocity
from uav_tracking_mpc.settings.simulator import SimulatorParameters
from uav_tracking_mpc.simulation.plants.vehicle import (
    Channel,
    HeldPlant,
    InnerLoop,
    OscillatingChannel,
    VehiclePlant,
    advance_lagged,
)


@given(st.floats(0.01, 5.0), st.floats(-1, 1), st.floats(-1, 1), st.floats(0.001, 10.0))
def test_a_lag_is_exponential(lag, rate, wanted, duration):
    """And its integral is what is wanted less what the lag still owes."""
    channel = Channel(lag, dead_time=0.0)
    channel.rate = rate
    channel.command(0.0, wanted)
    end, integral = channel.rate_after(duration), channel.integral(duration)
    assert end == pytest.approx(wanted + (rate - wanted) * np.exp(-duration / lag), abs=1e-12)
    assert integral == pytest.approx(wanted * duration - lag * (end - rate), abs=1e-9)


def test_a_command_waits_for_its_dead_time():
    channel = Channel(lag=0.0, dead_time=0.17)
    channel.command(1.0, 0.4)
    channel.command(1.05, 0.4)  # the same again changes nothing
    channel.command(1.1, -0.2)
    for time, wanted, until in ((1.16, 0.0, 1.17), (1.17, 0.4, 1.27), (1.27, -0.2, np.inf)):
        channel.mature(time)
        assert (channel.wanted, channel.next_change) == (wanted, pytest.approx(until))


def test_a_command_replaces_those_of_a_later_time():
    """The clock went back: what was commanded after now has not been."""
    channel = Channel(lag=0.0, dead_time=0.5)
    channel.command(10.0, 0.1)
    channel.command(10.2, 0.2)
    channel.command(5.0, 0.3)
    assert channel.next_change == 5.5
    channel.mature(100.0)
    assert channel.wanted == 0.3


def test_channels_keep_their_own_dead_times():
    inner_loop, seen = InnerLoop((0.0, 0.0, 0.0), (0.2, 0.0, 0.1)), []
    inner_loop.command(0.0, (0.1, 0.2, 0.3))
    for time in (0.0, 0.1, 0.2):
        until = inner_loop.unchanged_until(time)
        seen.append((until, *(channel.wanted for channel in inner_loop.channels)))
    expected = [(0.1, 0.0, 0.2, 0.0), (0.2, 0.0, 0.2, 0.3), (np.inf, 0.1, 0.2, 0.3)]
    np.testing.assert_allclose(seen, expected)


STATE = (10.0, -20.0, 120.0, 0.3, 0.1, 22.0)
WANTED = (0.4, -0.2, 1.5)
RATES = (-0.4, 0.2, -1.0)


def channels(lags, rates=RATES, wanted=WANTED):
    made = []
    for lag, rate, value in zip(lags, rates, wanted, strict=True):
        channel = Channel(lag, dead_time=0.0)
        channel.rate, channel.wanted = rate, value
        made.append(channel)
    return tuple(made)


@pytest.mark.parametrize("lags", [(0.3, 0.13, 0.16), (0.05, 0.05, 0.05), (1.0, 0.0, 0.02)])
@pytest.mark.parametrize("duration", [0.01, 0.05, 0.5, 12.0])
def test_against_scipy(lags, duration):
    """(3) with lags as nine equations; a lag of zero as inputs held."""

    def rates(_, x):
        psi, chi, v = x[3:6]
        flown = [
            wanted if lag == 0.0 else rate
            for lag, rate, wanted in zip(lags, x[6:], WANTED, strict=True)
        ]
        following = [
            0.0 if lag == 0.0 else (wanted - rate) / lag
            for lag, rate, wanted in zip(lags, x[6:], WANTED, strict=True)
        ]
        level = v * np.cos(chi)
        return [level * np.cos(psi), level * np.sin(psi), v * np.sin(chi), *flown, *following]

    oracle = solve_ivp(
        rates, (0.0, duration), [*STATE, *RATES], method="DOP853", rtol=1e-12, atol=1e-12
    ).y[:, -1]
    made = channels(lags)
    oracle[3:5] = wrap_angle(oracle[3:5])
    np.testing.assert_allclose(advance_lagged(STATE, made, duration), oracle[:6], atol=2e-8)
    for channel, lag, rate, wanted in zip(made, lags, oracle[6:], WANTED, strict=True):
        assert channel.rate == pytest.approx(wanted if lag == 0.0 else rate, abs=1e-9)


@pytest.mark.parametrize(
    ("lags", "rates"),
    [((0.0, 0.0, 0.0), RATES), ((0.3, 0.2, 0.1), WANTED)],
    ids=["without lag", "rates that are what is wanted"],
)
def test_what_is_wanted_at_once_is_the_exact_vehicle(lags, rates):
    flown = advance_lagged(STATE, channels(lags, rates), 1.0)
    np.testing.assert_allclose(flown, advance(STATE, WANTED, 1.0), atol=1e-9)


@given(st.floats(0.5, 20.0), st.floats(0.1, 0.95), st.floats(-1, 1), st.floats(-1, 1))
def test_a_roll_may_follow_as_a_damped_oscillation(frequency, damping, first, second):
    """Against the differential equation, through a change of the command."""
    channel, times = OscillatingChannel(frequency, damping, dead_time=0.0), (0.3, 0.45)
    integral, state = 0.0, np.zeros(3)
    for begin, wanted, duration in zip((0.0, times[0]), (first, second), times, strict=True):
        channel.command(begin, wanted)
        integral += channel.integral(duration)
        assert channel.rate_after(0.0) == pytest.approx(channel.rate, abs=1e-12)
        channel.follow(duration)

        def motion(_, y, wanted=wanted):
            rate, slope, _ = y
            return [slope, frequency**2 * (wanted - rate) - 2 * damping * frequency * slope, rate]

        state = solve_ivp(motion, (0.0, duration), state, rtol=1e-9, atol=1e-11).y[:, -1]
    assert [channel.rate, integral] == pytest.approx([state[0], state[2]], abs=1e-7)


LEVEL_FLIGHT = SimulatorParameters(initial_speed=5.0, initial_path_angle=0.2)


def flown(plant, count, step):
    """States after each of so many steps, shape (count, 6)."""
    states = []
    for _ in range(count):
        plant.advance(step)
        states.append(plant.state.copy())
    return np.array(states)


def test_commands_are_saturated():
    plant = VehiclePlant(LEVEL_FLIGHT)
    plant.accept([[9.0, -9.0, 9.0]], [0.0])
    np.testing.assert_allclose(plant.inputs(), [np.pi / 4, -np.pi / 4, 1.0])


SMALL_UAV = SimulatorParameters(
    initial_position=(300.0, 0.0, 120.0),
    initial_speed=22.0,
    speed_min=14.0,
    speed_max=32.0,
    acceleration_min=-1.5,
    acceleration_max=3.0,
)
INNER_LOOP = {"rate_lag": (0.3, 0.13, 0.16), "dead_time": (0.17, 0.2, 0.1)}
WIND = {"wind": (6.0, -3.0, 0.2), "gust_intensity": 8.0}
PLAN = np.array([[0.4, 0.1, 0.5], [-0.3, -0.2, 1.5], [0.2, 0.05, -0.5]])


def fly(plant, duration, step=0.05, plan=PLAN):
    plant.accept(plan, plant.time + np.arange(len(plan)))
    return flown(plant, round(duration / step), step)


def test_inner_loop_against_scipy():
    """(3) with lags and dead times, integrated piece by piece between the delayed commands."""
    plant = VehiclePlant(replace(SMALL_UAV, **INNER_LOOP))
    x, begin = np.concatenate([plant.state, np.zeros(3)]), 0.0
    flown = fly(plant, 2.5)[-1]
    lag, dead = np.array(INNER_LOOP["rate_lag"]), np.array(INNER_LOOP["dead_time"])

    def rates(t, x):
        wanted = [
            PLAN[int(t - delay), axis] if t >= delay else 0.0 for axis, delay in enumerate(dead)
        ]
        return np.concatenate([velocity(x[:6]), x[6:], (wanted - x[6:]) / lag])

    for end in sorted({*(dead + 0.0), *(dead + 1.0), *(dead + 2.0), 2.5}):
        x = solve_ivp(
            lambda t, x, at=0.5 * (begin + end): rates(at, x),
            (begin, end),
            x,
            method="DOP853",
            rtol=1e-11,
            atol=1e-11,
        ).y[:, -1]
        begin = end
    np.testing.assert_allclose(flown, x[:6], atol=1e-6)
    np.testing.assert_allclose(plant.rates, x[6:], atol=1e-6)


def test_without_inner_loop_and_wind_the_vehicle_is_flown_bit_for_bit():
    plant = VehiclePlant(SMALL_UAV)
    plant.accept(PLAN, np.arange(3.0))
    expected = plant.state
    for inputs in np.repeat(PLAN, 20, axis=0):
        expected = advance(expected, inputs, 0.05)
        plant.advance(0.05)
        np.testing.assert_array_equal([*plant.state, *plant.rates], [*expected, *inputs])
    assert plant.plan.failsafes == 0


def test_dead_time_alone_shifts_the_commands():
    delayed = VehiclePlant(replace(SMALL_UAV, dead_time=(0.175, 0.175, 0.175)))
    fly(delayed, 1.0)
    prompt = VehiclePlant(SMALL_UAV)
    prompt.state = advance(prompt.state, np.zeros(3), 0.175)
    prompt.accept(PLAN, np.arange(3.0))
    prompt.advance(0.825)
    np.testing.assert_allclose(delayed.state, prompt.state, atol=1e-9)


def test_steady_wind_carries_the_vehicle_along():
    moved = VehiclePlant(replace(SMALL_UAV, wind=(6.0, -3.0, 0.2)))
    drift = fly(moved, 2.0)[-1] - fly(VehiclePlant(SMALL_UAV), 2.0)[-1]
    np.testing.assert_allclose(drift, [12.0, -6.0, 0.4, 0.0, 0.0, 0.0], atol=1e-9)
    np.testing.assert_array_equal(moved.wind, [6.0, -3.0, 0.2])
    np.testing.assert_allclose(
        moved.ground_velocity, velocity(moved.state) + moved.wind, atol=1e-12
    )


def test_ground_velocity_is_the_derivative_of_the_position():
    """Within a gust, which is held for 20 ms."""
    plant = VehiclePlant(replace(SMALL_UAV, **WIND, **INNER_LOOP))
    fly(plant, 1.0)
    ground, before = plant.ground_velocity, plant.state.copy()
    plant.advance(1e-5)
    np.testing.assert_allclose((plant.state[:3] - before[:3]) / 1e-5, ground, atol=1e-3)


def test_the_same_seed_flies_the_same_at_any_rate():
    """But for the command that changes between two steps; here all changes are on both grids."""
    parameters = replace(SMALL_UAV, **WIND, **INNER_LOOP)
    coarse = fly(VehiclePlant(parameters), 2.0, step=0.05)[-1]
    np.testing.assert_array_equal(fly(VehiclePlant(parameters), 2.0, step=0.05)[-1], coarse)
    np.testing.assert_allclose(fly(VehiclePlant(parameters), 2.0, step=0.01)[-1], coarse, atol=2e-3)
    other = fly(VehiclePlant(replace(parameters, seed=1)), 2.0)[-1]
    assert np.linalg.norm(other[:3] - coarse[:3]) > 0.1


def test_bank_limits_the_turn():
    """g tan(45 deg) / 22 m/s = 0.446 rad/s, tighter when slower."""
    plant = VehiclePlant(replace(SMALL_UAV, bank_max=np.pi / 4, yaw_rate_max=2.0))
    for turn, airspeed, limit in ((0.9, 22.0, 1.0), (0.9, 14.0, 1.0), (-0.9, 14.0, -1.0)):
        plant.state[5] = airspeed
        plant.accept([[turn, 0.0, 0.0]], [0.0])
        assert plant.inputs()[0] == pytest.approx(limit * 9.80665 / airspeed)


@pytest.mark.parametrize("inner_loop", [{}, INNER_LOOP], ids=["at once", "lagging"])
def test_the_speed_stays_inside_its_limits(inner_loop):
    plant = VehiclePlant(replace(SMALL_UAV, **inner_loop))
    speeds = fly(plant, 20.0, plan=[[0.0, 0.0, 3.0]] * 12 + [[0.0, 0.0, -1.5]] * 20)[:, 5]
    assert speeds.max() == pytest.approx(32.0, abs=1e-9)
    assert 14.0 <= speeds[-1] < 25.0  # and it leaves the limit when told to
    assert plant.rates[2] == pytest.approx(-1.5, abs=1e-3)


@pytest.mark.parametrize("inner_loop", [{}, INNER_LOOP], ids=["at once", "lagging"])
def test_when_the_plan_is_over_the_wings_are_levelled(inner_loop):
    plant = VehiclePlant(replace(SMALL_UAV, initial_path_angle=0.3, **inner_loop))
    plant.accept([[0.4, 0.1, 1.0]], [0.0])
    *_, before, level = flown(plant, 401, 0.05)
    assert plant.plan.holding and plant.plan.failsafes == 1
    np.testing.assert_allclose(plant.rates, 0.0, atol=1e-4)
    np.testing.assert_allclose(level[3:], [before[3], 0.0, before[5]], atol=1e-4)


def test_the_truth_is_the_state():
    plant = VehiclePlant(replace(SMALL_UAV, **WIND, **INNER_LOOP))
    fly(plant, 1.0)
    truth = plant.truth
    motion = *truth.state(truth.airspeed), *truth.ground_velocity
    np.testing.assert_array_equal(motion, [*plant.state, *plant.ground_velocity])
    rates = truth.turn_rate, truth.path_angle_rate, truth.stamp
    np.testing.assert_array_equal(rates, [*plant.rates[:2], plant.time])


def test_looking_does_not_change_the_flight():
    """Sensors have their own numbers: however often they are read, the gusts stay."""
    parameters = replace(SMALL_UAV, **WIND, position_noise=1.0)
    looked, alone = VehiclePlant(parameters), VehiclePlant(parameters)
    looked.measured()
    np.testing.assert_array_equal(fly(looked, 1.0), fly(alone, 1.0))


FLIGHT = SimulatorParameters(
    initial_position=(400.0, 0.0, 100.0), initial_path_angle=0.0, initial_speed=20.0,
    speed_max=40.0, rate_lag=(0.3, 0.13, 0.16), pitch_rate_max=0.5, acceleration_min=-4.0,
    acceleration_max=5.0, yaw_rate_max=0.8,
)  # fmt: skip


def orbit(up=100.0, climb=0.0, airspeed=20.0):
    return FlownOrbit(np.array([0.0, 0.0, up]), np.array([3.0, 0.0, climb]), 200.0, airspeed)


def test_it_flies_the_commanded_turn_and_ignores_the_rest():
    held, free = HeldPlant(FLIGHT), VehiclePlant(FLIGHT)
    held.accept([[0.2, 0.1, 2.0]], [0.0])
    free.accept([[0.2, 0.0, 0.0]], [0.0])
    np.testing.assert_allclose(flown(held, 18, 0.05), flown(free, 18, 0.05), atol=1e-9)


def test_altitude_and_airspeed_become_what_it_is_told():
    plant = HeldPlant(FLIGHT)
    plant.see_orbit(orbit(up=130.0, airspeed=23.0))
    settled = flown(plant, 1200, 0.05)[-1, [2, 4, 5]]
    np.testing.assert_array_less(np.abs(settled - [130.0, 0.0, 23.0]), [0.05, 1e-3, 0.01])


def test_the_altitude_goes_on_with_the_centre_when_nothing_more_is_heard():
    plant = HeldPlant(FLIGHT)
    plant.see_orbit(orbit(climb=0.5))
    _, _, height, *_ = flown(plant, 800, 0.05)[-1]
    assert plant.altitude == pytest.approx(120.0)
    assert height == pytest.approx(120.0, abs=0.5)


def test_it_climbs_no_faster_than_it_can():
    plant = HeldPlant(FLIGHT)
    plant.see_orbit(orbit(up=300.0))
    heights = flown(plant, 120, 0.05)[:, 2]
    assert heights[-1] - heights[-21] == pytest.approx(5.0, abs=0.05)
