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

"""Two clocks of one machine: what is read between them is smooth, and steps are followed."""

import pytest

from uav_tracking_mpc.nodes.clock_offset import ClockOffset

APART = 1_700_000_000.0  # s


class Clocks:
    """ROS time ahead of another clock, each read late by a jitter."""

    def __init__(self):
        self.now, self.apart, self.late = 100.0, APART, 0.0

    def ros(self):
        return round((self.now + self.apart + self.late) * 1e9)

    def other(self):
        return self.now


@pytest.fixture
def clocks():
    return Clocks()


@pytest.fixture
def offset(clocks):
    return ClockOffset(clocks.ros, clocks.other)


def test_there_and_back(clocks, offset):
    stamp = offset.ros(99.5)
    assert stamp == pytest.approx((APART + 99.5) * 1e9, abs=1e3)
    assert offset.other(stamp) == pytest.approx(99.5, abs=1e-6)
    assert ClockOffset(clocks.ros, clocks.other).other(stamp) == pytest.approx(99.5, abs=1e-6)


def test_a_reading_that_was_interrupted_counts_for_little(clocks, offset):
    offset.read()
    for late in (2e-3, 0.3):
        clocks.late = late
        assert offset.ros(100.0) == pytest.approx((APART + 100.0) * 1e9, abs=1e5)


def test_a_clock_that_is_set_anew_is_followed(clocks, offset):
    offset.read()
    clocks.apart += 3600.0
    for _ in range(3):
        stamp = offset.ros(100.0)
    assert stamp == pytest.approx((APART + 3700.0) * 1e9, abs=1e3)


def test_a_clock_that_drifts_is_followed(clocks, offset):
    for _ in range(1000):
        clocks.now += 0.02
        clocks.apart += 0.02 * 500e-6  # as fast as NTP slews
        stamp = offset.ros(clocks.now)
    assert stamp * 1e-9 - clocks.now - clocks.apart == pytest.approx(0.0, abs=1e-3)
