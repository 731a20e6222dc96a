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

"""The thread that reads a link: it waits, goes on, gives up and ends."""

import threading

import pytest
from paced_link import PacedLink
from waiting import wait_for

from uav_tracking_mpc.links import LinkError
from uav_tracking_mpc.nodes import link_reader
from uav_tracking_mpc.nodes.link_reader import LinkReader


@pytest.fixture(autouse=True)
def _quick(monkeypatch):
    monkeypatch.setattr(link_reader, "RETRY_PERIOD", 0.01)


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


def test_it_gives_up_what_no_waiting_helps(reader):
    made = reader(PacedLink("copter"))
    assert wait_for(lambda: made.refusal == "it is a copter")
    assert not made.connected


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
