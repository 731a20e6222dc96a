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

"""Intervals hold the truth as often as they claim."""

import numpy as np
import pytest
from excited_channel import record

from uav_tracking_mpc.studies.identification.channel_fit import ChannelFit
from uav_tracking_mpc.studies.identification.profile_intervals import estimates


def found(channel):
    return estimates(ChannelFit(channel, channel.demand.value).run())


def test_an_interval_holds_its_value_and_ends_at_what_is_possible():
    lag, dead_time, total, gain = found(record(0.0, 0.0))
    for estimate in (lag, dead_time, total, gain):
        assert estimate.lower <= estimate.value <= estimate.upper
    assert lag.lower == dead_time.lower == 0.0
    assert total.holds(0.0) or total.lower < 0.02


def test_twice_the_noise_widens_the_interval_of_the_sum_as_much():
    widths = []
    for noise in (0.05, 0.1):
        total = found(record(0.3, 0.15, noise=noise)).total
        widths.append(total.upper - total.lower)
    assert 1.5 < widths[1] / widths[0] < 2.5


@pytest.mark.long
def test_of_many_flights_as_many_are_covered_as_claimed():
    """Of 60 at 95 %, fewer than 52 would be covered in 1 of 500 such tests."""
    random, covered = np.random.default_rng(0), np.zeros(4, int)
    for seed in range(60):
        lag, dead_time = np.exp(random.uniform(np.log(0.05), 0.0)), random.uniform(0.0, 0.3)
        estimate = found(record(lag, dead_time, 0.9, seed=seed))
        truth = (lag, dead_time, lag + dead_time, 0.9)
        covered += [one.holds(value) for one, value in zip(estimate, truth, strict=True)]
    assert np.all(covered >= 52), covered
