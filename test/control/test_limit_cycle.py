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

"""A limit cycle is noticed with its period and amplitude; swings in gusts are none."""

import math

import numpy as np
import pytest

from uav_tracking_mpc.control.limit_cycle import LONGEST, LimitCycleWatch

TICK = 0.05


def watched(values):
    """What the watch says of each sample."""
    watch, found = LimitCycleWatch(), []
    for tick, value in enumerate(values):
        watch.see(tick * TICK, float(value))
        found.append(watch.swing)
    return found


def times(seconds):
    return np.arange(0.0, seconds, TICK)


@pytest.mark.parametrize("period", [0.5, 1.7, 6.0, 12.0])
@pytest.mark.parametrize("shape", [np.sin, lambda angle: np.sign(np.sin(angle))])
def test_a_regular_swing_is_found_with_period_and_amplitude(period, shape):
    time = times(max(20.0, 9.0 * period))
    *_, swing = watched(0.2 + 0.3 * shape(2.0 * math.pi * time / period))
    assert swing.period == pytest.approx(period, rel=0.1)
    assert 0.2 < swing.amplitude < 0.45


@pytest.mark.parametrize(
    "values",
    [
        0.03 * np.sin(4.0 * times(60.0)),  # small
        0.3 * np.sin(2.0 * math.pi * times(200.0) / (2.0 * LONGEST)),  # an orbit in wind
        0.3 * np.exp(-0.3 * times(60.0)) * np.sin(4.0 * times(60.0)),  # dies away
        np.sign(np.sin(0.5 * times(60.0) ** 1.5)) * (times(60.0) < 5.0),  # a manoeuvre
    ],
)
def test_other_swings_are_none(values):
    assert watched(values)[-1] is None


def test_noise_with_the_correlation_of_gusts_is_hardly_ever_taken_for_one():
    alarms = 0
    for seed in range(10):
        rng, value, values = np.random.default_rng(seed), 0.0, []
        for _ in range(round(60.0 / TICK)):
            value += TICK / 0.7 * -value + 0.15 * math.sqrt(2.0 * TICK / 0.7) * rng.normal()
            values.append(value)
        alarms += any(found is not None for found in watched(values))
    assert alarms <= 1


def test_it_ends_when_it_ends_and_says_so_once():
    time = times(40.0)
    values = np.where(time < 20.0, 0.3 * np.sin(4.0 * time), 0.0)
    watch = LimitCycleWatch()
    changes = [now for now, value in zip(time, values, strict=True) if watch.see(now, value)]
    begun, ended = changes
    assert 5.0 < begun < 15.0
    assert 20.0 < ended < 25.0
    assert watch.swing is None


def test_a_gap_or_another_time_begins_anew():
    watch = LimitCycleWatch()
    for now in times(20.0):
        watch.see(now, 0.3 * math.sin(4.0 * now))
    assert watch.swing is not None
    watch.see(5.0, 0.3)
    assert watch.swing is None
