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

"""Messages in, messages out, without a wire."""

import math
import random
import re
import struct

import pytest
from autopilot_steps import BOTH, autopilot, position_of

from uav_tracking_mpc.autopilot.arduplane import ArduPlane
from uav_tracking_mpc.autopilot.px4 import Px4
from uav_tracking_mpc.autopilot.vehicle_protocol import VehicleProtocol
from uav_tracking_mpc.dynamics.frames import quaternion_from_euler
from uav_tracking_mpc.links.mavlink.dialect import mavlink

GROUND = (255, 190)


class Talk:
    """The other end: packs what it says and parses what it hears, as over a wire."""

    def __init__(self, dialect, *overrides, on_runway=False):
        self.core = autopilot(dialect, *overrides, on_runway=on_runway)
        self.protocol = VehicleProtocol(self.core)
        self._out = mavlink.MAVLink(None, *GROUND)
        self._in = mavlink.MAVLink(None, 1, 1)

    def say(self, message):
        (heard,) = self._in.parse_buffer(message.pack(self._out))
        self.protocol.take(heard, self.core.time)
        return self.heard()

    def fly(self, seconds):
        self.protocol.advance(self.core.time + seconds)
        return self.heard()

    def heard(self):
        sender = mavlink.MAVLink(None, 1, 1)
        packed = b"".join(message.pack(sender) for message in self.protocol.outgoing())
        return mavlink.MAVLink(None).parse_buffer(packed) or []

    def command(self, number, *values, target=1):
        numbers = [*values, *[0.0] * (7 - len(values))]
        return self.say(mavlink.MAVLink_command_long_message(target, 1, number, 0, *numbers))


@pytest.fixture(params=[ArduPlane, Px4])
def talk(request):
    return Talk(request.param)


def of(name, messages):
    return [message for message in messages if message.get_type() == name]


def result(messages):
    (acknowledged,) = of("COMMAND_ACK", messages)
    assert (acknowledged.target_system, acknowledged.target_component) == GROUND
    return acknowledged.result


def test_telemetry_comes_at_the_rates_that_are_asked_for(talk):
    for name, interval in {"VFR_HUD": 20000.0, "ATTITUDE": -1.0}.items():
        number = getattr(mavlink, f"MAVLINK_MSG_ID_{name}")
        assert result(talk.command(511, number, interval)) == mavlink.MAV_RESULT_ACCEPTED
    heard, usual = talk.fly(10.0), talk.core.traits.stream_rates["GLOBAL_POSITION_INT"]
    names = ("HEARTBEAT", "VFR_HUD", "ATTITUDE", "GLOBAL_POSITION_INT")
    counts = [len(of(name, heard)) for name in names]
    assert counts == pytest.approx([11, 500, 0, 10.0 * usual], abs=1)
    assert result(talk.command(511, 12345, 20000.0)) == mavlink.MAV_RESULT_FAILED


def test_ardupilots_rates_end_at_a_share_of_its_main_loop():
    """GCS_Common.cpp, cap_message_interval."""
    talk = Talk(ArduPlane)
    talk.core.parameters.set("SCHED_LOOP_RATE", 50)
    talk.command(511, mavlink.MAVLINK_MSG_ID_VFR_HUD, 1000.0)
    assert len(of("VFR_HUD", talk.fly(5.0))) == pytest.approx(200, abs=2)


@BOTH
def test_what_is_told_is_the_state(dialect):
    talk = Talk(dialect, "uav_simulator.wind=[3.0, 4.0, 0.0]")
    heard, core = talk.fly(10.0), talk.core
    position, attitude = of("GLOBAL_POSITION_INT", heard)[-1], of("ATTITUDE", heard)[-1]
    state = core.state
    age = state.time - position.time_boot_ms * 1e-3
    assert -1e-3 < age < 0.26
    back = [state.east - age * state.east_rate, state.north - age * state.north_rate, state.up]
    assert position_of(position) == pytest.approx(back, abs=1.5)
    assert position.relative_alt == pytest.approx(1e5, abs=100)
    assert attitude.yaw == pytest.approx(state.yaw, abs=0.1)
    assert -attitude.yawspeed < 0.0  # clockwise
    hud = of("VFR_HUD", heard)[-1]
    assert hud.airspeed == pytest.approx(22.0 / core.density_factor, abs=0.1)
    assert hud.alt == pytest.approx(588.0, abs=0.1)


@pytest.mark.parametrize(
    ("dialect", "name", "told"),
    [
        (
            ArduPlane,
            "WIND",
            {
                "direction": math.degrees(math.atan2(-3.0, -4.0)),
                "speed": math.sqrt(26.0),
                "speed_z": -1.0,
            },
        ),
        (Px4, "WIND_COV", {"wind_x": 4.0, "wind_y": 3.0, "wind_z": 0.0}),
    ],
)
def test_each_tells_the_wind_its_way(dialect, name, told):
    wind = of(name, Talk(dialect, "uav_simulator.wind=[3.0, 4.0, 1.0]").fly(1.0))[-1].to_dict()
    assert {key: wind[key] for key in told} == pytest.approx(told, abs=1e-3)


def test_a_change_of_mode_is_told_at_once_by_ardupilot_and_with_the_next_heartbeat_by_px4():
    ardupilot, px4 = Talk(ArduPlane), Talk(Px4)
    ardupilot.fly(1.5)
    px4.fly(1.5)
    heard = ardupilot.command(176, 1.0, 15.0)
    assert result(heard) == mavlink.MAV_RESULT_ACCEPTED
    assert [message.custom_mode for message in of("HEARTBEAT", heard)] == [15]
    assert not of("HEARTBEAT", px4.command(176, 1.0, 4.0, 5.0))
    assert [message.custom_mode for message in of("HEARTBEAT", px4.fly(1.0))] == [84148224]


def test_its_time_is_told_to_who_asks(talk):
    talk.fly(2.0)
    assert talk.say(mavlink.MAVLink_timesync_message(5, 12345)) == []  # somebody's answer
    for talk.core.clock_offset in (0.0, 100.0):
        (answer,) = talk.say(mavlink.MAVLink_timesync_message(0, 12345))
        told = round((2.0 + talk.core.clock_offset) * 1e9)
        assert (answer.tc1, answer.ts1) == (told, 12345)
    assert of("ATTITUDE", talk.fly(1.0))[-1].time_boot_ms > 102_000


def test_parameters_are_listed_read_and_set(talk):
    listed = talk.say(mavlink.MAVLink_param_request_list_message(1, 1))
    assert [value.param_index for value in listed] == list(range(listed[0].param_count))
    assert [value.param_id for value in listed] == list(talk.core.parameters)
    real = next(value for value in listed if value.param_type == mavlink.MAV_PARAM_TYPE_REAL32)
    name = real.param_id.encode()
    for message in (
        mavlink.MAVLink_param_set_message(1, 1, name, 12.5, real.param_type),
        mavlink.MAVLink_param_request_read_message(1, 1, name, -1),
    ):
        assert [told.param_value for told in talk.say(message)] == [12.5]
    assert talk.say(mavlink.MAVLink_param_request_read_message(1, 1, b"NO_SUCH", -1)) == []
    talk.say(mavlink.MAVLink_param_set_message(1, 1, name, math.nan, real.param_type))
    assert talk.core.parameters[real.param_id] == 12.5


def test_integers_are_values_at_ardupilot_and_bytes_at_px4():
    read = mavlink.MAVLink_param_request_read_message
    (told,) = Talk(ArduPlane).say(read(1, 1, b"SYSID_MYGCS", -1))
    assert told.param_value == 255.0
    talk = Talk(Px4)
    (told,) = talk.say(read(1, 1, b"NAV_RCL_ACT", -1))
    assert struct.unpack("<i", struct.pack("<f", told.param_value)) == (2,)
    (five,) = struct.unpack("<f", struct.pack("<i", 5))
    kind = mavlink.MAV_PARAM_TYPE_INT32
    talk.say(mavlink.MAVLink_param_set_message(1, 1, b"COM_OBL_RC_ACT", five, kind))
    assert talk.core.parameters["COM_OBL_RC_ACT"] == 5


def test_messages_are_sent_on_request(talk):
    for name in ("AUTOPILOT_VERSION", "HOME_POSITION", "EXTENDED_SYS_STATE"):
        heard = talk.command(512, getattr(mavlink, f"MAVLINK_MSG_ID_{name}"))
        assert result(heard) == mavlink.MAV_RESULT_ACCEPTED
        assert len(of(name, heard)) == 1
    (home,) = of("HOME_POSITION", talk.command(410))
    assert (home.latitude, home.longitude, home.altitude) == (473977000, 85456000, 488000)
    assert result(talk.command(512, 12345)) == talk.core.traits.unknown_message


def test_commands_that_are_unknown_or_for_somebody_else(talk):
    assert result(talk.command(31999)) == mavlink.MAV_RESULT_UNSUPPORTED
    assert talk.command(176, 1.0, 15.0, target=2) == []
    assert bool(talk.command(410, target=0)) == talk.core.traits.hears_all
    assert result(talk.command(176, math.nan)) == mavlink.MAV_RESULT_DENIED


@pytest.mark.parametrize(
    ("dialect", "number", "answered"),
    [(ArduPlane, 15, (11, 0, "GUIDED")), (Px4, 84148224, (176, 0, "RTL"))],
)
def test_set_mode_is_answered_as_the_real_ones_do(dialect, number, answered):
    talk = Talk(dialect)
    (answer,) = of("COMMAND_ACK", talk.say(mavlink.MAVLink_set_mode_message(1, 1, number)))
    assert (answer.command, answer.result, talk.core.mode) == answered


def test_a_quaternion_is_flown_and_one_that_is_none_is_not():
    talk = Talk(ArduPlane)
    talk.command(176, 1.0, 15.0)

    def told(quaternion):
        zeros = [0.0] * 4
        talk.say(
            mavlink.MAVLink_set_attitude_target_message(0, 1, 1, 0b11111110, quaternion, *zeros)
        )

    told(quaternion_from_euler(math.radians(-25.0), 0.3, 1.0))
    talk.fly(2.9)
    assert math.degrees(talk.core.state.roll) == pytest.approx(-25.0, abs=0.5)
    told([math.nan, 0.0, 0.0, 0.0])
    talk.fly(1.0)
    assert abs(math.degrees(talk.core.state.roll) + 25.0) > 1.0  # its time is over


def test_texts_reach_the_ground(talk):
    heard = talk.command(176, 1.0, 10.0 if isinstance(talk.core, ArduPlane) else 6.0)
    (text,) = of("STATUSTEXT", heard)
    assert "Mode 10 cannot" in text.text or "Offboard is currently not possible" in text.text


def test_a_restart_begins_its_clock_and_rates_again(talk):
    talk.command(511, mavlink.MAVLINK_MSG_ID_ATTITUDE, -1.0)
    talk.fly(5.0)
    talk.protocol.restart()
    heard = of("ATTITUDE", talk.fly(1.0))
    assert len(heard) > 5
    assert heard[-1].time_boot_ms <= 1000


FLOATS = (math.nan, math.inf, -math.inf, 0.0, -1.0, 1.0, 1e-30, 1e9, -1e9, 3.4e38, -3.4e38, 15.0)
TAKEN = (
    "COMMAND_INT", "COMMAND_LONG", "HEARTBEAT", "PARAM_REQUEST_READ", "PARAM_SET",
    "SET_ATTITUDE_TARGET", "SET_MODE", "TIMESYNC",
)  # fmt: skip
ARRAYS = {"q": 4}
COMMANDS = sorted(
    {number for core in (ArduPlane, Px4) for number in (*core.answers, *core.mode_commands)}
    | {410, 511, 512, 520}  # those of the protocol itself
)
MESSAGES = 1500


def number(type_, rng):
    if type_ == "float":
        return rng.choice(FLOATS)
    bits = int(re.search(r"\d+", type_)[0])
    lowest = 0 if type_[0] == "u" else -(2 ** (bits - 1))
    return rng.choice([lowest, lowest + 2**bits - 1, 0, 1, rng.randrange(lowest, lowest + 2**bits)])


def mutated(rng, names):
    name = rng.choice(TAKEN)
    kind = getattr(mavlink, f"MAVLink_{name.lower()}_message")
    values = []
    for field, type_ in zip(kind.fieldnames, kind.fieldtypes, strict=True):
        if field in ("target_system", "target_component"):
            values.append(1)
        elif field == "command":
            values.append(rng.choice(COMMANDS))
        elif type_ == "char":
            values.append(rng.choice(names).encode())
        elif field in ARRAYS:
            values.append([number(type_, rng) for _ in range(ARRAYS[field])])
        else:
            values.append(number(type_, rng))
    return kind(*values)


@BOTH
def test_no_message_ends_the_flight(dialect):
    protocol = VehicleProtocol(autopilot(dialect))
    core, rng = protocol.core, random.Random(1)
    sender, parser = mavlink.MAVLink(None, 255, 1), mavlink.MAVLink(None)
    for _ in range(MESSAGES):
        message = mutated(rng, list(core.parameters))
        for heard in parser.parse_buffer(message.pack(sender)) or []:
            protocol.take(heard, core.time)
        protocol.advance(core.time + 0.01)
        for answer in protocol.outgoing():
            assert answer.pack(sender)
        assert all(map(math.isfinite, core.state))
    assert core.time == pytest.approx(0.01 * MESSAGES)
