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

"""Commands are repeated until they are acknowledged, and every answer is told."""

from uav_tracking_mpc.control.event import EventLog, Level
from uav_tracking_mpc.links.mavlink.dialect import mavlink
from uav_tracking_mpc.links.mavlink.requests import ATTEMPTS, PROGRESS, WAIT, Requests

MODE = mavlink.MAV_CMD_DO_SET_MODE


class Wire:
    def __init__(self):
        self.sent = []

    def send(self, message):
        self.sent.append((message.get_type(), getattr(message, "confirmation", None)))


def asked():
    wire, events = Wire(), EventLog()
    requests = Requests(wire, events)
    requests.system = 7
    requests.ask(0.0, MODE, "the mode", 1.0, 15.0)
    return wire, events, requests


def acknowledgement(result, command=MODE):
    return mavlink.MAVLink_command_ack_message(command, result)


def test_what_is_accepted_is_sent_once_and_told():
    wire, events, requests = asked()
    assert requests.result(MODE) is None
    requests.see(acknowledgement(mavlink.MAV_RESULT_ACCEPTED), 0.1)
    requests.tend(10.0)
    assert wire.sent == [("COMMAND_LONG", 0)]
    assert requests.result(MODE) == "ACCEPTED"
    assert events.take() == [(Level.INFO, "the autopilot accepted the mode")]


def test_what_is_not_answered_is_repeated_then_given_up():
    wire, events, requests = asked()
    for attempt in range(1, ATTEMPTS + 2):
        requests.tend(attempt * WAIT + 1e-6)
    assert wire.sent == [("COMMAND_LONG", number) for number in range(ATTEMPTS)]
    assert requests.result(MODE) == "not answered"
    assert requests.refused == 1
    assert events.take() == [(Level.WARNING, "the autopilot refused the mode: not answered")]


def test_a_refusal_of_it_and_of_no_other_is_told_by_its_name():
    _, events, requests = asked()
    requests.see(acknowledgement(mavlink.MAV_RESULT_DENIED, mavlink.MAV_CMD_DO_REPOSITION), 0.1)
    assert (requests.refused, events.take()) == (0, [])
    requests.see(acknowledgement(mavlink.MAV_RESULT_TEMPORARILY_REJECTED), 0.1)
    assert requests.refused == 1
    assert "TEMPORARILY_REJECTED" in events.take()[0].words


def test_progress_puts_the_end_off():
    wire, _, requests = asked()
    requests.see(acknowledgement(mavlink.MAV_RESULT_IN_PROGRESS), 0.1)
    requests.tend(0.1 + 0.9 * PROGRESS)
    assert len(wire.sent) == 1


def test_a_place_keeps_its_digits_and_a_quiet_one_is_told_only_if_refused():
    wire, events, requests = asked()
    place, command = (473977000, 85456000, 600.0), mavlink.MAV_CMD_DO_REPOSITION
    requests.ask_there(0.0, command, "a loiter", (-1.0, 1.0, 80.0, 0.0), place, quiet=True)
    requests.see(acknowledgement(mavlink.MAV_RESULT_ACCEPTED, command), 0.1)
    assert wire.sent[-1] == ("COMMAND_INT", None)
    assert events.take() == []
