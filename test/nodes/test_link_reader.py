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

"""Reading a link: its clock, and what happens whatever it raises."""

import threading

import pytest
from paced_link import PacedLink
from processes import wait_for

from uav_tracking_mpc.links import LinkError
from uav_tracking_mpc.nodes import autopilot_link
from uav_tracking_mpc.nodes.autopilot_link import ClockOffset, LinkReader

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


@pytest.fixture(autouse=True)
def _quick(monkeypatch):
    monkeypatch.setattr(autopilot_link, "RETRY_PERIOD", 0.01)


@pytest.fixture
def reader():
    """Makes a reader; it is stopped at the end."""
    made = []

    def make(link, taken=lambda measurement: None):
        made.append(LinkReader(link, taken))
        made[-1].start()
        return made[-1]

    yield make
    for each in made:
        each.stop()


def test_measurements_come_in_the_readers_thread_until_it_is_stopped(reader):
    link, seen = PacedLink(), []
    made = reader(link, lambda measurement: seen.append(threading.current_thread().name))
    assert wait_for(lambda: len(seen) > 2)
    assert set(seen) == {"link"}
    assert made.connected and made.trouble == made.refusal == ""
    link.engage()
    made.stop()
    assert not link.engaged
    assert link.closed
    count = len(seen)
    assert not wait_for(lambda: len(seen) > count, 0.2)


def test_a_measurement_that_cannot_be_published_ends_no_flight(reader):
    link, seen = PacedLink(), []

    def taken(measurement):
        seen.append(measurement)
        if len(seen) == 2:
            raise OverflowError("no such stamp")

    made = reader(link, taken)
    link.engage()
    assert wait_for(lambda: len(seen) > 4)
    assert link.engaged and not link.closed
    assert made.connected and made.trouble == ""
    words = [words for _, words in link.events.take() if "not published" in words]
    assert words == ["a measurement is not published: OverflowError: no such stamp"]


def test_it_waits_for_an_aircraft_that_is_not_there_yet(reader):
    link = PacedLink("nobody")
    made = reader(link)
    assert wait_for(lambda: made.trouble == "nobody answers")
    assert not made.connected
    link.address = ""
    assert wait_for(lambda: made.connected)
    assert made.refusal == ""


@pytest.mark.parametrize("error", [LinkError("the wire broke"), ZeroDivisionError("of a user")])
def test_a_link_that_fails_is_connected_again(reader, error):
    class Failing(PacedLink):
        """Fails after its first state."""

        connected = 0

        def connect(self, timeout):
            self.connected += 1
            super().connect(timeout)

        def measured(self, timeout):
            if self.connected < 3:
                raise error
            return super().measured(timeout)

    link, seen = Failing(), []
    made = reader(link, seen.append)
    assert wait_for(lambda: seen)
    assert link.connected == 3
    assert made.connected
