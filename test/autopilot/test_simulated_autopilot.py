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

"""In real time over UDP and TCP of this machine, heard by pymavlink itself."""

import contextlib
import itertools
import math
import os
import time

import pytest
from autopilot_steps import ORIGIN, position_of
from processes import PATIENCE
from pymavlink import mavutil

from uav_tracking_mpc.autopilot.simulated_autopilot import GroundVehicle, SimulatedAutopilot
from uav_tracking_mpc.autopilot.wire_faults import WIRE_FAULTS
from uav_tracking_mpc.links import LinkError
from uav_tracking_mpc.links.mavlink.dialect import mavlink
from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.settings.simulator import TargetParameters

PORTS = itertools.count(20000 + os.getpid() % 20000)  # of this process alone, one for each test
CONFIGURATION = load_configuration("small_uav")


@pytest.fixture
def where():
    return f"127.0.0.1:{next(PORTS)}"


@contextlib.contextmanager
def client(address, system=1):
    with contextlib.closing(
        mavutil.mavlink_connection(address, source_system=system, source_component=191)
    ) as connection:
        yield connection


@pytest.fixture
def listener(where):
    with client(f"udpin:{where}") as connection:
        yield connection


def heard(connection, name, timeout=PATIENCE):
    return connection.recv_match(type=name, blocking=True, timeout=timeout)


def hear_until(connection, name, wanted):
    """Hear messages of a name until one is as it is wanted."""
    deadline = time.monotonic() + PATIENCE
    while not wanted(heard(connection, name)):
        assert time.monotonic() < deadline


def asked(connection, command, *values):
    numbers = [*values, *[0.0] * (7 - len(values))]
    connection.mav.command_long_send(1, 1, command, 0, *numbers)
    acknowledged = heard(connection, "COMMAND_ACK")
    assert acknowledged.command == command
    return acknowledged.result


@pytest.mark.parametrize(
    ("dialect", "own", "other"),
    [("ardupilot", "udpout", "udpin"), ("px4", "udpin", "udpout"), ("ardupilot", "tcpin", "tcp")],
)
def test_a_flight_over_a_wire(dialect, own, other, where):
    autopilot = SimulatedAutopilot(dialect, CONFIGURATION, f"{own}:{where}")
    with client(f"{other}:{where}") as connection, autopilot:
        connection.mav.heartbeat_send(mavlink.MAV_TYPE_ONBOARD_CONTROLLER, 8, 0, 0, 0)
        heartbeat = heard(connection, "HEARTBEAT")
        assert heartbeat.autopilot == autopilot.core.traits.maker
        assert heartbeat.custom_mode == autopilot.core.custom_mode
        assert asked(connection, 511, mavlink.MAVLINK_MSG_ID_ATTITUDE, 20000.0) == 0
        times = [heard(connection, "ATTITUDE").time_boot_ms for _ in range(26)]
        assert times[-1] - times[0] == pytest.approx(500, abs=60)
        assert autopilot.pilot_mode("RTL")
        number = type(autopilot.core).modes["RTL"]
        hear_until(connection, "HEARTBEAT", lambda message: message.custom_mode == number)


def test_a_lost_tcp_connection_can_be_made_again(where):
    with SimulatedAutopilot("ardupilot", CONFIGURATION, f"tcpin:{where}"):
        for _ in range(2):
            with client(f"tcp:{where}") as connection:
                assert heard(connection, "HEARTBEAT") is not None


def test_two_companions_hear_the_pilots_change_at_once(where):
    with (
        SimulatedAutopilot("ardupilot", CONFIGURATION, f"udpin:{where}"),
        client(f"udpout:{where}") as companion,
        client(f"udpout:{where}", system=255) as ground,
    ):
        companion.mav.heartbeat_send(mavlink.MAV_TYPE_ONBOARD_CONTROLLER, 8, 0, 0, 0)
        assert heard(companion, "HEARTBEAT") is not None
        ground.mav.command_long_send(1, 1, 176, 0, 1.0, 5.0, 0, 0, 0, 0, 0)  # FBWA
        hear_until(companion, "HEARTBEAT", lambda message: message.custom_mode == 5)


def test_no_fault_ends_it(where, listener):
    with SimulatedAutopilot("ardupilot", CONFIGURATION, f"udpout:{where}") as autopilot:
        assert heard(listener, "HEARTBEAT") is not None
        for name in WIRE_FAULTS:
            fault = autopilot.begin_fault(name, seed=1)
            for _ in range(10):
                listener.mav.command_long_send(1, 1, 410, 0, *[0.0] * 7)
                listener.recv_match(blocking=True, timeout=0.02)
            autopilot.end_fault(fault)
        while listener.recv_match(blocking=False) is not None:
            pass
        hear_until(listener, "HEARTBEAT", lambda message: message.get_srcSystem() == 1)


@pytest.mark.parametrize(
    ("dialect", "changed", "error", "words"),
    [
        ("inav", {}, ParameterError, "dialect is 'inav', must be one of ardupilot, px4"),
        ("px4", {"origin": (91.0, 0.0, 0.0)}, ParameterError, "origin is latitude 91"),
        ("px4", {"connection": "radio:7"}, LinkError, "must be udpin:HOST:PORT"),
    ],
)
def test_bad_words_are_told(dialect, changed, error, words):
    with pytest.raises(error, match=words):
        SimulatedAutopilot(dialect, CONFIGURATION, **changed)


def test_signed_messages_alone_are_taken_where_there_is_a_key(tmp_path, where, listener):
    key = tmp_path / "key"
    key.write_bytes(bytes(range(32)))
    with SimulatedAutopilot("ardupilot", CONFIGURATION, f"udpout:{where}", key=str(key)):
        assert heard(listener, "HEARTBEAT").get_header().incompat_flags == 1  # signed
        listener.mav.command_long_send(1, 1, 410, 0, *[0.0] * 7)
        assert heard(listener, "COMMAND_ACK", timeout=0.5) is None
        listener.setup_signing(bytes(range(32)), sign_outgoing=True)
        assert asked(listener, 410) == mavlink.MAV_RESULT_ACCEPTED


def test_a_second_vehicle_is_heard_on_the_same_wire(where, listener):
    systems = set()
    with SimulatedAutopilot("px4", CONFIGURATION, f"udpout:{where}", target_system=9):
        hear_until(
            listener,
            "GLOBAL_POSITION_INT",
            lambda message: systems.add(message.get_srcSystem()) or systems == {1, 9},
        )


def test_it_tells_where_it_drives():
    target = TargetParameters(motion="line", position=(50.0, -20.0, 0.0), speed=5.0)
    vehicle, parser, heard = GroundVehicle(target, ORIGIN, 42), mavlink.MAVLink(None), []
    for tick in range(1000):
        for frame in vehicle.frames(0.01 * tick):
            heard += parser.parse_buffer(frame)
    assert {message.get_srcSystem() for message in heard} == {42}
    *before, last = (m for m in heard if m.get_type() == "GLOBAL_POSITION_INT")
    assert len(before) == 49
    east, north, _ = position_of(last)
    driven = 5.0 * last.time_boot_ms * 1e-3
    assert math.hypot(east - 50.0, north + 20.0) == pytest.approx(driven, abs=0.05)
    assert math.hypot(last.vx, last.vy) == pytest.approx(500.0, abs=1.0)
