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
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from uav_tracking_mpc.dynamics.frames import wrap_angle
from uav_tracking_mpc.dynamics.vehicle import advance
from uav_tracking_mpc.simulation.inner_loop import (
    Channel,
    InnerLoop,
    OscillatingChannel,
    advance_lagged,
)


def test_without_lag_and_dead_time_a_command_is_flown_at_once():
    channel = Channel(lag=0.0, dead_time=0.0)
    channel.command(0.0, 0.4)
    assert channel.rate_after(0.1) == 0.4
    assert channel.integral(0.1) == pytest.approx(0.04)


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
    assert channel.next_change == pytest.approx(1.17)
    channel.mature(1.16)
    assert channel.wanted == 0.0
    channel.mature(1.17)
    assert (channel.wanted, channel.next_change) == (0.4, pytest.approx(1.27))
    channel.mature(1.27)
    assert (channel.wanted, channel.next_change) == (-0.2, np.inf)


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
    inner_loop = InnerLoop((0.0, 0.0, 0.0), (0.2, 0.0, 0.1))
    inner_loop.command(0.0, (0.1, 0.2, 0.3))
    assert inner_loop.unchanged_until(0.0) == pytest.approx(0.1)
    assert [channel.wanted for channel in inner_loop.channels] == [0.0, 0.2, 0.0]
    assert inner_loop.unchanged_until(0.1) == pytest.approx(0.2)
    assert inner_loop.unchanged_until(0.2) == np.inf
    assert [channel.wanted for channel in inner_loop.channels] == [0.1, 0.2, 0.3]


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
