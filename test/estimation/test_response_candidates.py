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

"""The candidates' responses are those of the plant's channels, at any time and dead time."""

import numpy as np
import pytest

from uav_tracking_mpc.estimation.response_estimator import (
    ACCELERATION,
    DEAD_TIMES,
    LAGS,
    ResponseCandidates,
)
from uav_tracking_mpc.simulation.plants.vehicle import InnerLoop


def at(candidates, time):
    """Responses at one time."""
    return candidates.at(np.array([time]))[0]


def simulated(commands, lag, dead_time, until):
    """Rates at a time of channels that begin at rest at 0 s, and what was gained."""
    loop, gained = InnerLoop([lag] * 3, [dead_time] * 3), 0.0
    ends = [*[time for time, _ in commands[1:]], until]
    for (begin, inputs), end in zip(commands, ends, strict=True):
        loop.command(begin, inputs)
        now = begin
        while now < end:
            step = max(min(loop.unchanged_until(now), end) - now, 1e-9)
            gained += loop.channels[ACCELERATION].integral(step)
            for channel in loop.channels:
                channel.rate = channel.rate_after(step)
            now += step
    return np.array([channel.rate for channel in loop.channels]), gained


def test_they_are_the_response_of_first_order_channels_with_dead_time():
    rng = np.random.default_rng(0)
    times = np.cumsum(rng.uniform(0.02, 0.3, 30))
    commands = [(float(t), rng.uniform(-1.0, 1.0, 3)) for t in times]
    candidates = ResponseCandidates()
    for time, inputs in commands:
        candidates.commanded(time, time, inputs[np.newaxis], 1.0)
    now = times[-1] + 0.137
    responses = at(candidates, now)
    for row, column in ((0, 3), (3, 5), (7, 1), (20, 8), (14, 11)):
        rates, gained = simulated(commands, LAGS[column], DEAD_TIMES[row], now)
        np.testing.assert_allclose(responses[:2, row, column], rates[:2], atol=1e-6)
        assert responses[ACCELERATION, row, column] == pytest.approx(gained, abs=1e-6)


def test_several_times_are_answered_as_one_after_the_other():
    rng = np.random.default_rng(1)
    times = np.cumsum(rng.uniform(0.02, 0.3, 8))
    once, each = ResponseCandidates(), ResponseCandidates()
    answers = []
    for time in times:
        answers.append(at(each, time))
        plan = rng.uniform(-1.0, 1.0, (4, 3))
        for candidates in (once, each):
            candidates.commanded(time + 0.01, time, plan, 0.1)
    np.testing.assert_allclose(once.at(times), answers, atol=1e-12)


def test_the_segments_of_a_plan_follow_each_other_until_another_is_sent():
    plan = np.outer([1.0, 2.0, 3.0], np.ones(3))
    candidates = ResponseCandidates()
    candidates.commanded(10.1, 10.0, plan, 0.5)
    assert candidates.end == 11.5
    np.testing.assert_allclose(at(candidates, 10.3)[0, 0, 0], 1.0)
    np.testing.assert_allclose(at(candidates, 10.6)[0, 0, 0], 2.0)
    candidates.commanded(10.8, 10.7, 7.0 * plan, 0.5)
    np.testing.assert_allclose(at(candidates, 11.1)[0, :, 0][DEAD_TIMES <= 0.25], 7.0)
    np.testing.assert_allclose(at(candidates, 11.1)[0, 7, 0], 2.0)  # of 0.35 s before


def test_what_a_plan_says_of_before_it_was_sent_was_not_flown():
    candidates = ResponseCandidates()
    candidates.commanded(8.0, 8.0, np.full((5, 3), 0.2), 1.0)
    candidates.commanded(10.2, 9.0, np.outer([-0.3, 0.2, 0.2], np.ones(3)), 1.0)
    np.testing.assert_allclose(at(candidates, 10.5)[0, :, 0], 0.2)


def test_it_never_runs_out_of_memory():
    candidates = ResponseCandidates()
    for tick in range(1500):
        time = 0.01 * tick
        candidates.commanded(time, time, np.full((1, 3), float(tick)), 1.0)
        if tick % 10 == 0:
            at(candidates, time)
    assert len(candidates._pieces) < 200
    steady = at(candidates, time)[0, :, 0]
    np.testing.assert_allclose(steady, np.floor(tick - DEAD_TIMES / 0.01 + 1e-6), atol=1.01)
