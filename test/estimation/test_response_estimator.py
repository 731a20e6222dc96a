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

"""Lag, dead time and gain come out of commands and response, and nothing where there is none."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from uav_tracking_mpc.estimation.response_estimator import (
    DELAY_TRUST,
    GAIN_LIMITS,
    GAIN_TRUST,
    ChannelResponse,
    ResponseEstimator,
)
from uav_tracking_mpc.simulation.plants.vehicle import InnerLoop

TICK = 0.05
SIZES = np.array([0.15, 0.08, 1.0])  # of commands [rad/s, rad/s, m/s^2]
NOISE = np.array([0.01, 0.01, 0.2])  # of what is measured [rad/s, rad/s, m/s]
BIAS = np.array([0.03, -0.01, 1.0])
TURN_RATE_MAX = 10.0


class Aircraft:
    """Channels with lag, dead time and gain that are flown by steps at random times."""

    def __init__(self, seed, lags, dead_times, gains, noise=NOISE):
        self.rng, self.noise = np.random.default_rng(seed), noise
        self.loop, self.gains = InnerLoop(lags, dead_times), np.array(gains)
        self.time, self.airspeed = 100.0, 22.0
        self.inputs, self.until = np.zeros(3), np.zeros(3)
        self.estimator = ResponseEstimator()

    def fly(self, seconds, sizes=SIZES, state_delay=0.0, turn_rate_max=TURN_RATE_MAX):
        """The commands take effect at once, the measurements are stamped too late."""
        for _ in range(round(seconds / TICK)):
            self.measure(state_delay, turn_rate_max)
            for axis in np.flatnonzero(self.time >= self.until):
                self.inputs[axis] = sizes[axis] * self.rng.uniform(-1.0, 1.0)
                self.until[axis] = self.time + self.rng.uniform(0.5, 4.0)
            plan = self.inputs[np.newaxis].copy()
            self.estimator.commanded(self.time, self.time, plan, 1.0)
            wanted = self.inputs * self.gains
            wanted[0] = np.clip(wanted[0], -turn_rate_max, turn_rate_max)
            self.loop.command(self.time, wanted.tolist())
            self.advance()
        return self.estimator.channels

    def measure(self, state_delay, turn_rate_max):
        turn, climb, _ = (channel.rate for channel in self.loop.channels)
        values = np.array([turn, climb, self.airspeed]) + BIAS
        values += self.noise * self.rng.standard_normal(3)
        self.estimator.see(self.time + state_delay, *values.tolist(), turn_rate_max)

    def advance(self):
        flown = 0.0
        while flown < TICK - 1e-9:
            change = self.loop.unchanged_until(self.time + flown) - self.time
            duration = max(min(change, TICK) - flown, 1e-9)
            *_, engine = self.loop.channels
            self.airspeed += engine.integral(duration)
            for channel in self.loop.channels:
                channel.rate = channel.rate_after(duration)
            flown += duration
        self.time += TICK


def random_aircraft(seed, noise=NOISE):
    rng = np.random.default_rng([seed, 1])
    lags, dead_times = rng.uniform(0.02, 1.0, 3), rng.uniform(0.0, 0.6, 3)
    gains = rng.uniform(0.7, 1.4, 3)
    return Aircraft(seed, lags, dead_times, gains, noise), lags, dead_times, gains


@settings(max_examples=settings.default.max_examples // 5)  # each flies for a minute
@given(seed=st.integers(0, 10_000))
def test_it_converges_to_the_truth(seed):
    aircraft, lags, dead_times, gains = random_aircraft(seed)
    channels = aircraft.fly(60.0)
    for axis, channel in enumerate(channels):
        delay = lags[axis] + dead_times[axis]
        assert abs(channel.delay - delay) < 0.02 + 5.0 * channel.delay_deviation
        assert channel.delay == pytest.approx(delay, abs=0.15)
        assert abs(channel.lag - lags[axis]) < 0.03 + 5.0 * channel.lag_deviation
        assert channel.gain == pytest.approx(gains[axis], abs=0.12)


def test_without_noise_it_is_within_the_grid_s_rounding():
    aircraft, lags, dead_times, gains = random_aircraft(3, np.zeros(3))
    for axis, channel in enumerate(aircraft.fly(40.0)):
        assert channel.lag == pytest.approx(lags[axis], abs=0.05)
        assert channel.dead_time == pytest.approx(dead_times[axis], abs=0.04)
        assert channel.delay == pytest.approx(lags[axis] + dead_times[axis], abs=0.03)
        assert channel.gain == pytest.approx(gains[axis], abs=0.02)
        assert channel.trusted and channel.gain_trusted


def test_its_deviations_cover_the_truth_about_as_often_as_they_say():
    within = []
    for seed in range(12):
        aircraft, lags, dead_times, gains = random_aircraft(seed)
        for axis, channel in enumerate(aircraft.fly(40.0)):
            errors = channel.delay - lags[axis] - dead_times[axis], channel.gain - gains[axis]
            deviations = channel.delay_deviation, channel.gain_deviation
            within.append(np.abs(errors) / deviations)
    within = np.array(within)
    assert np.mean(within < 1.0) > 0.5
    assert np.mean(within < 2.0) > 0.8
    assert np.mean(within < 0.05) < 0.3  # and do not claim far too much


def test_a_state_that_is_late_under_a_false_stamp_is_dead_time():
    aircraft = Aircraft(0, (0.3, 0.13, 0.16), (0.17, 0.2, 0.1), np.ones(3), np.zeros(3))
    for channel, delay in zip(aircraft.fly(40.0, state_delay=0.3), (0.47, 0.33, 0.26), strict=True):
        assert channel.delay == pytest.approx(delay + 0.3, abs=0.03)


def test_nothing_is_trusted_that_was_not_excited():
    aircraft = Aircraft(1, (0.3, 0.13, 0.16), (0.17, 0.2, 0.1), np.ones(3))
    for channel in aircraft.fly(90.0, sizes=np.zeros(3)):
        assert not (channel.trusted or channel.lag_trusted or channel.gain_trusted)


def test_trust_fades_when_the_excitation_ends_and_the_estimate_stays():
    aircraft = Aircraft(2, (0.3, 0.13, 0.16), (0.17, 0.2, 0.1), np.ones(3))
    before = aircraft.fly(40.0)[0]
    after = aircraft.fly(180.0, sizes=np.zeros(3))[0]
    assert before.trusted
    assert after.delay_deviation > 1.4 * before.delay_deviation
    assert after.delay == pytest.approx(before.delay, abs=3.0 * after.delay_deviation)


def test_a_response_at_the_bank_limit_is_left_out():
    aircraft = Aircraft(4, (0.3, 0.13, 0.16), (0.17, 0.2, 0.1), (1.4, 1.0, 1.0), np.zeros(3))
    turn, *_ = aircraft.fly(60.0, sizes=2.0 * SIZES, turn_rate_max=0.35)
    assert turn.gain == pytest.approx(1.4, abs=0.08)
    assert turn.delay == pytest.approx(0.47, abs=0.04)


def test_it_is_bounded_whatever_is_measured():
    estimator, rng = ResponseEstimator(), np.random.default_rng(5)
    for tick in range(600):
        time = tick * TICK
        values = rng.standard_normal(3) * rng.choice([1.0, 1e3, 1e-9, 1e200])
        estimator.see(time, values[0], values[1], values[2] if tick % 7 else None, 0.4)
        estimator.commanded(time, time, rng.standard_normal((3, 3)), 0.2)
        for channel in estimator.channels:
            assert 0.0 <= channel.lag <= 2.0
            assert 0.0 <= channel.dead_time <= 2.0
            assert GAIN_LIMITS[0] <= channel.gain <= GAIN_LIMITS[1]


def test_gaps_and_plans_that_ran_out_are_left_out():
    aircraft = Aircraft(6, (0.3, 0.13, 0.16), (0.17, 0.2, 0.1), np.ones(3), np.zeros(3))
    for _ in range(4):
        aircraft.fly(15.0)
        for channel in aircraft.loop.channels:  # somebody else flies for a while
            channel.rate, channel.wanted = 0.3, 0.3
        aircraft.time += 3.0
    for channel, delay in zip(aircraft.fly(15.0)[:2], (0.47, 0.33), strict=False):
        assert channel.delay == pytest.approx(delay, abs=0.03)


def test_an_interruption_forgets_nothing_that_was_learnt():
    aircraft = Aircraft(7, (0.3, 0.13, 0.16), (0.17, 0.2, 0.1), np.ones(3))
    known = list(aircraft.fly(20.0))
    aircraft.estimator.interrupt()
    assert aircraft.estimator.channels == known


def test_the_same_flight_gives_the_same_estimate_bit_for_bit():
    flights = [random_aircraft(8)[0].fly(20.0) for _ in range(2)]
    assert flights[0] == flights[1]


@pytest.mark.parametrize("trusted_before", [False, True])
def test_a_channel_that_swings_is_flown_by_a_less_certain_estimate(trusted_before):
    uncertain = ChannelResponse(
        delay_deviation=2.0 * DELAY_TRUST[trusted_before], gain_deviation=2.0 * GAIN_TRUST[True]
    )
    before = ChannelResponse(trusted=trusted_before)
    assert not uncertain.judged(before, swings=False).trusted
    assert uncertain.judged(before, swings=True).trusted
    assert not ChannelResponse().judged(before, swings=True).trusted
