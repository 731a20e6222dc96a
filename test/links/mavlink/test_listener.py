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

"""What an autopilot says of itself, and what counts of it after nobody has read for a while."""

from types import SimpleNamespace

import pytest

from uav_tracking_mpc.control.event import EventLog, Level
from uav_tracking_mpc.links.mavlink.dialect import mavlink
from uav_tracking_mpc.links.mavlink.listener import STALL, Listener
from uav_tracking_mpc.settings.link import LinkParameters

AUTOPILOT = mavlink.MAVLink(None, 3, 1)
HEARTBEAT = mavlink.MAVLink_heartbeat_message(1, 3, 128, 15, 4, 3)
ATTITUDE = mavlink.MAVLink_attitude_message(1000, 0.1, 0.0, 1.0, 0.0, 0.0, 0.0)


class Wire:
    """A connection over which comes what is put into it, one batch at each read."""

    def __init__(self):
        self.batches, self.time, self.address, self.closed = [], 100.0, "here", False

    def now(self):
        return self.time

    def wait(self, timeout):
        return bool(self.batches)

    def receive(self, timeout):
        batch = self.batches.pop(0) if self.batches else []
        for message in batch:
            message.pack(AUTOPILOT)  # with its sender
        return batch

    def send(self, message):
        pass


@pytest.fixture
def listener():
    heard = Listener(Wire(), LinkParameters(), EventLog())
    heard.requests.system, heard.heartbeat = 3, HEARTBEAT
    return heard


@pytest.mark.parametrize(
    ("version", "identity"),
    [
        (None, "MAVLink system 3"),
        (SimpleNamespace(uid=0, uid2=[0] * 18), "MAVLink system 3"),
        (SimpleNamespace(uid=0x1234, uid2=[0] * 18), "0000000000001234"),
        (SimpleNamespace(uid=0x1234, uid2=[1, 255] + [0] * 16), "01ff" + "00" * 16),
    ],
)
def test_its_serial_number_tells_it_apart_or_else_its_number_on_mavlink(version, identity):
    latest = {} if version is None else {"AUTOPILOT_VERSION": version}
    autopilot = SimpleNamespace(latest=latest, system=3)
    assert Listener.identity.fget(autopilot) == identity


@pytest.mark.parametrize(
    ("severity", "level"),
    [
        (mavlink.MAV_SEVERITY_EMERGENCY, Level.WARNING),
        (mavlink.MAV_SEVERITY_WARNING, Level.WARNING),
        (mavlink.MAV_SEVERITY_NOTICE, Level.INFO),
        (mavlink.MAV_SEVERITY_DEBUG, Level.INFO),
    ],
)
def test_its_warnings_and_what_is_worse_are_warnings(listener, severity, level):
    listener.connection.batches = [[mavlink.MAVLink_statustext_message(severity, b"low battery")]]
    listener.receive(0.0)
    ((said, words),) = listener._events.take()
    assert (said, words) == (level, "autopilot: low battery")


def test_of_all_that_waited_while_nobody_read_the_heartbeats_alone_count(listener):
    """Attitudes of then would pass for those of now."""
    batch = [HEARTBEAT, ATTITUDE]
    kinds = []
    for pause in (0.0, 0.5 * STALL, 1.5 * STALL, 0.0):
        listener.connection.time += pause
        listener.connection.batches = [batch] * 3
        heard = [listener.receive(0.0)]
        while listener.connection.batches:
            heard.append(listener.receive(0.0))
        kinds.append([[message.get_type() for message in each] for each in heard])
    fresh = [["HEARTBEAT", "ATTITUDE"]] * 3
    assert kinds == [fresh, fresh, [["HEARTBEAT"] * 3], fresh]


def test_a_fix_that_is_lost_and_found_is_told_and_one_that_never_was_is_not(listener):
    told = []
    for fix in (0, 1, 3, 4, 1, 0, 3):
        raw = mavlink.MAVLink_gps_raw_int_message(0, fix, 0, 0, 0, 0, 0, 0, 0, 0)
        listener.connection.batches = [[raw]]
        listener.receive(0.0)
        told.append([(each.level, each.words) for each in listener._events.take()])
    lost = "the satellite receiver has lost its fix: positions may be dead reckoning"
    again = "the satellite receiver has a fix again"
    assert told == [[], [], [], [], [(Level.WARNING, lost)], [], [(Level.INFO, again)]]
