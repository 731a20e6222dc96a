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

"""The response against the simulator's inner loop, which is exact."""

from dataclasses import replace

import numpy as np
import pytest
from excited_channel import answer, excitation, record
from scipy.signal import lfilter

from uav_tracking_mpc.studies.identification.channel_fit import (
    ChannelFit,
    HeldDemand,
    Limits,
    limited_fit,
    noise_of,
)
from uav_tracking_mpc.studies.identification.flight_record import Samples
from uav_tracking_mpc.studies.identification.identification import Profile


@pytest.mark.parametrize("lag", [0.0, 0.05, 0.3, 2.0])
@pytest.mark.parametrize("dead_time", [0.0, 0.13, 0.2])
def test_rate_and_integral_are_those_of_the_inner_loop(lag, dead_time):
    time, demand = excitation(seed=3, duration=20.0)
    demand[0] = 0.0  # the inner loop begins at rest
    rates, integrals = answer(demand, lag, dead_time)
    held = HeldDemand(Samples(time, demand))
    rate, integral = held.response(time, lag, dead_time, held.rates_at_steps(lag))
    later = time > dead_time + 1e-9  # a command that comes on at this very time counts already
    if lag:
        np.testing.assert_allclose(rate[later], rates[later], atol=1e-10)
    shift = integral[-1] - integrals[-1]
    np.testing.assert_allclose(integral[later], integrals[later] + shift, atol=1e-9)


def test_between_the_steps_the_rate_decays_exponentially():
    held = HeldDemand(Samples(np.array([0.0, 1.0]), np.array([0.0, 2.0])))
    time = np.array([1.3, 1.75])
    rate, _ = held.response(time, 0.5, 0.1, held.rates_at_steps(0.5))
    np.testing.assert_allclose(rate, 2.0 * (1.0 - np.exp(-(time - 1.1) / 0.5)))


@pytest.mark.parametrize("poles", [[1.0], [1.0, -1.5, 0.7]])
def test_coloured_noise_is_made_white_and_white_noise_stays_as_it_is(poles):
    drawn = 0.1 * np.random.default_rng(1).standard_normal(4000)
    noise = noise_of(lfilter([1.0], poles, drawn), 1e-3)
    white = noise.whitened(lfilter([1.0], poles, drawn))
    assert len(noise.polynomial) >= len(poles)
    assert abs(noise.deviation - 0.1) < 0.01
    assert abs(np.std(white) - 1.0) < 0.05
    assert abs(white[1:] @ white[:-1]) / len(white) < 0.05


def test_no_sensor_is_exact():
    assert noise_of(np.zeros(100), 0.01).deviation == 0.01


def fitted(channel):
    return ChannelFit(channel, channel.demand.value).run()


@pytest.mark.parametrize(("lag", "dead_time"), [(0.0, 0.0), (0.05, 0.31), (0.3, 0.0), (1.0, 0.17)])
def test_without_noise_the_truth_is_found(lag, dead_time):
    fit = fitted(record(lag, dead_time, 0.9, noise=0.0))
    assert fit.lag == pytest.approx(lag, abs=2e-3)
    assert fit.dead_time == pytest.approx(dead_time, abs=2e-3)
    assert fit.solved.gain == pytest.approx(0.9, abs=2e-3)
    np.testing.assert_allclose(fit.fitted(), fit.record.state.value, atol=1e-2)


def test_a_measured_rate_tells_more_although_it_is_biased():
    exact = record(0.2, 0.1, rate_noise=0.02)
    biased = exact.rate._replace(value=exact.rate.value + 0.5)
    fit = fitted(replace(exact, rate=biased))
    assert fit.lag == pytest.approx(0.2, abs=5e-3)
    assert fit.dead_time == pytest.approx(0.1, abs=5e-3)


def test_a_drift_of_the_state_is_no_response():
    """A constant wind of the airspeed, or a bias of the rate that is integrated."""
    still = record(0.3, 0.1, noise=0.01)
    time, value = still.state
    drifting = replace(still, state=Samples(time, value + 0.2 * time + 7.0))
    assert fitted(drifting).lag == pytest.approx(fitted(still).lag, abs=1e-3)


def test_coloured_noise_is_recognised():
    still = record(0.3, 0.1, noise=0.0)
    drawn = 0.03 * np.random.default_rng(5).standard_normal(len(still.state.time))
    gusts = lfilter([1.0], [1.0, -0.98], drawn)
    fit = fitted(replace(still, state=still.state._replace(value=still.state.value + gusts)))
    assert len(fit.noise[0].polynomial) > 1
    assert fit.lag + fit.dead_time == pytest.approx(0.4, abs=0.03)  # two standard deviations


def test_a_record_that_is_too_short_is_refused_and_a_rate_that_is_is_not_used():
    channel = record(0.3, 0.1)
    few = Samples(*(column[::100] for column in channel.state))
    with pytest.raises(ValueError, match="must be at least 25 over 10 s"):
        replace(channel, state=few).between_commands()
    assert replace(channel, rate=few).between_commands().rate is None
    short = replace(channel, state=Samples(*(column[:150] for column in channel.state)))
    with pytest.raises(ValueError, match="over 7.5 s"):
        short.between_commands()


def test_a_limit_is_found_and_does_not_disturb_the_rest():
    fit, limits = limited_fit(record(0.3, 0.1, gain=0.8, noise=0.05, limit=0.8, slow=0.8))
    assert 0.8 * limits.upper == pytest.approx(0.8, abs=0.04)
    assert 0.8 * limits.lower == pytest.approx(-0.8, abs=0.04)
    assert fit.lag == pytest.approx(0.3, abs=0.03)
    assert limited_fit(record(0.3, 0.1, slow=0.8))[1] == Limits()  # where there is none


def found(channel):
    return Profile(fitted(channel)).estimates()


def test_an_interval_holds_its_value_and_ends_at_what_is_possible():
    lag, dead_time, total, gain = found(record(0.0, 0.0))
    for estimate in (lag, dead_time, total, gain):
        assert estimate.lower <= estimate.value <= estimate.upper
    assert lag.lower == dead_time.lower == 0.0
    assert total.lower < 0.02


def test_twice_the_noise_widens_the_interval_of_the_sum_as_much():
    once, twice = (found(record(0.3, 0.15, noise=noise)).total for noise in (0.05, 0.1))
    assert 1.5 < (twice.upper - twice.lower) / (once.upper - once.lower) < 2.5


@pytest.mark.long
def test_of_many_flights_as_many_are_covered_as_claimed():
    """Of 60 at 95 %, fewer than 52 would be covered in 1 of 500 such tests."""
    random, covered = np.random.default_rng(0), np.zeros(4, int)
    for seed in range(60):
        lag, dead_time = np.exp(random.uniform(np.log(0.05), 0.0)), random.uniform(0.0, 0.3)
        estimate = found(record(lag, dead_time, 0.9, seed=seed))
        truth = (lag, dead_time, lag + dead_time, 0.9)
        covered += [e.lower <= t <= e.upper for e, t in zip(estimate, truth, strict=True)]
    assert np.all(covered >= 52), covered
