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

"""The link to ArduPlane, flown against the simulated one over its wire, in simulated time."""

import math
import threading
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from autopilot_steps import fly
from processes import PATIENCE
from stepped_flight import ORBIT, STEP, TURN, Nobody, Planner, engaged_flight, flight

from uav_tracking_mpc.autopilot.autopilot_core import Cmd, Order, Result
from uav_tracking_mpc.autopilot.simulated_autopilot import SteppedAutopilot
from uav_tracking_mpc.links import LinkError, LinkRefusedError
from uav_tracking_mpc.links.ardupilot import (
    BANK_KEPT,
    MODES,
    ROLL_ALONE,
    ArduPilotLink,
    ArduPlaneEnvelope,
)
from uav_tracking_mpc.links.mavlink.dialect import mavlink
from uav_tracking_mpc.links.mavlink.telemetry import Telemetry
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.settings.link import LinkParameters

FORCED = 3.0  # s for which ArduPlane keeps a bank that it was told


@pytest.fixture
def engaged():
    return engaged_flight("ardupilot")


def test_modes_have_names():
    link = ArduPilotLink()
    assert {link.mode_name(number) for number in MODES} == set(MODES.values())
    assert link.mode_name(99) == "number 99"
    assert [number for number in MODES if link.takes_commands(number)] == [15]


def test_the_bank_alone_is_commanded(engaged):
    engaged.fly(5.0)
    bank = math.degrees(engaged.sent[-1][1].roll)
    airspeed = engaged.link.heard.telemetry.newest.airspeed
    assert bank == pytest.approx(-math.degrees(math.atan(airspeed * 0.08 / 9.80665)), abs=0.1)
    assert all(target.mask == ROLL_ALONE for _, target in engaged.sent)
    times = np.array([time for time, _ in engaged.sent])
    assert np.diff(times).max() <= 0.06


@pytest.mark.parametrize("told", [0.0, 5.0, 15.0, 80.0])
def test_the_bank_is_that_of_the_airspeed_that_the_controller_estimates(engaged, told, monkeypatch):
    """A sensor that was stuck at 5 m/s had it bank by 9 deg for 35, and fly away by 1 km."""
    monkeypatch.setattr(Telemetry, "airspeed", told)
    engaged.fly(5.0, Planner(ORBIT._replace(airspeed_now=20.0)))
    bank = math.degrees(engaged.sent[-1][1].roll)
    assert bank == pytest.approx(-math.degrees(math.atan(20.0 * 0.08 / 9.80665)), abs=0.5)
    newest = engaged.link.heard.telemetry.newest
    assert newest.airspeed == (told or None)  # the controller finds it out by itself


def test_the_bank_leaves_out_what_the_aircraft_turns_besides(engaged):
    engaged.fly(2.0, Planner(ORBIT._replace(airspeed_now=20.0, surplus=0.02)))
    bank = math.degrees(engaged.sent[-1][1].roll)
    assert bank == pytest.approx(-math.degrees(math.atan(20.0 * 0.06 / 9.80665)), abs=0.1)


def test_an_estimate_that_does_not_come_any_more_is_forgotten(engaged):
    engaged.fly(2.0, Planner(ORBIT._replace(airspeed_now=30.0, surplus=0.01)))
    telemetry = engaged.link.heard.telemetry
    assert (telemetry.flown_airspeed, telemetry.surplus) == (30.0, 0.01)
    engaged.fly(0.5, Planner())  # of a controller that tells none
    assert telemetry.flown_airspeed == telemetry.airspeed
    engaged.fly(0.5, Planner(ORBIT._replace(airspeed_now=30.0)))
    engaged.fly(2.0, Nobody())
    assert (telemetry.flown_airspeed, telemetry.surplus) == (telemetry.airspeed, 0.0)


def test_a_ground_station_that_sends_it_elsewhere_is_not_overridden(engaged):
    engaged.fly(2.0)
    core = engaged.autopilot.core
    latitude, longitude, _ = core.origin.place([600.0, 0.0, 120.0])
    there = Order(Cmd.DO_REPOSITION, x=math.degrees(latitude), y=math.degrees(longitude), z=120.0)
    assert core.command(there) == Result.ACCEPTED
    at = engaged.time
    engaged.fly(2.0)
    assert not engaged.link.engaged
    assert not engaged.sent_after(at + 1.0)
    assert any("sent the aircraft to another place" in words for words in engaged.words)
    assert core.mode == "GUIDED"
    assert engaged.engage() == ""  # asked again, it circles our target again
    engaged.fly(2.0)
    assert engaged.link.engaged


def test_a_target_that_moves_is_still_ours(engaged):
    engaged.autopilot.begin_fault("loss")
    engaged.fly(20.0, Planner(speed=5.0))
    assert engaged.link.engaged


def test_an_orbit_may_come_in_lists_or_in_one_array_that_is_filled_anew(engaged):
    class InPlace(Planner):
        def __init__(self, centre):
            super().__init__(ORBIT._replace(centre=centre))

        def answer(self, flown, measured):
            self.orbit.centre[0] = 5.0 * flown.time
            flown.link.command(measured.stamp, TURN, STEP, self.orbit)

    for centre in ([0.0, 0.0, 120.0], np.array([0.0, 0.0, 120.0])):
        engaged.fly(10.0, InPlace(centre))
        assert engaged.link.engaged
        assert abs(engaged.autopilot.core.loiter.east - 5.0 * engaged.time) < 40.0


def test_another_program_that_asks_for_fewer_states_is_asked_against(engaged):
    engaged.fly(3.0)
    for name in ("GLOBAL_POSITION_INT", "ATTITUDE", "VFR_HUD"):
        engaged.autopilot.protocol.rates.ask(name, 0.25)
    engaged.fly(3.0)
    begin, planner = engaged.time, Planner()
    engaged.fly(2.0, planner)
    assert planner.states > 0.9 * 50.0 * (engaged.time - begin)


def test_without_a_companion_it_loiters_about_the_target(engaged):
    engaged.fly(5.0)
    core = engaged.autopilot.core
    fly(core, 50.0)
    distances = [math.hypot(state.east, state.north) for state in fly(core, 20.0)]
    assert core.mode == "GUIDED"
    # Its own loiter of that radius, grown by the thinner air as the real one's is.
    assert np.ptp(distances) < 5.0
    assert np.mean(distances) == pytest.approx(ORBIT.radius, rel=0.15)
    assert core.state.up == pytest.approx(ORBIT.centre[2], abs=0.5)
    assert core.state.airspeed == pytest.approx(ORBIT.airspeed, abs=0.2)


def test_an_orbit_at_the_least_airspeed_in_thinner_air_is_not_flown_at_cruise(engaged):
    slow = engaged.link.inspect().envelope["airspeed_min"]
    engaged.fly(2.0, Planner(ORBIT._replace(centre=np.array([0.0, 0.0, 400.0]), airspeed=slow)))
    assert engaged.autopilot.core._guided.speed == engaged.link.vehicle["AIRSPEED_MIN"]
    assert engaged.link.values()["commands refused"] == 0


def test_a_pilot_who_hands_over_again_elsewhere_is_brought_to_that_loiter_too():
    by_mode = LinkParameters(link="ardupilot", engage_on_mode=True)
    flown = flight("ardupilot", link=by_mode).fly(1.5)
    core = flown.autopilot.core
    for _ in range(2):  # GUIDED, entered by a pilot, is a loiter about where the aircraft is then
        assert flown.autopilot.pilot_mode("GUIDED")
        flown.fly(5.0)
        assert flown.link.engaged
        assert core.loiter[:2] == pytest.approx(ORBIT.centre[:2], abs=0.1)
        assert core.loiter.radius == pytest.approx(-ORBIT.radius)
        flown.autopilot.pilot_mode("FBWA")
        flown.fly(5.0)
        assert not flown.link.engaged


def test_a_controller_that_dies_ends_in_that_loiter_too(engaged):
    engaged.fly(10.0, Nobody())
    assert not engaged.sent_after(engaged.time - FORCED)
    assert engaged.autopilot.core.mode == "GUIDED"


def test_what_was_told_into_a_dead_link_is_told_again(engaged):
    engaged.fly(2.0)
    higher = ORBIT._replace(centre=ORBIT.centre + np.array([0.0, 0.0, 30.0]))
    fault = engaged.autopilot.begin_fault("deaf")
    engaged.fly(6.0, Planner(higher))
    engaged.autopilot.end_fault(fault)
    engaged.fly(25.0, Planner(higher))
    assert engaged.autopilot.core.state.up == pytest.approx(higher.centre[2], abs=1.0)


def test_the_answer_to_a_ground_station_is_none_to_us(engaged):
    engaged.fly(2.0)
    higher = ORBIT._replace(centre=ORBIT.centre + np.array([0.0, 0.0, 30.0]))
    fault = engaged.autopilot.begin_fault("deaf")
    engaged.fly(0.2, Planner(higher))
    command, accepted = Cmd.GUIDED_CHANGE_ALTITUDE, Result.ACCEPTED
    answer = mavlink.MAVLink_command_ack_message(command, accepted, 0, 0, 255, 190)
    engaged.autopilot.radio.send(answer)
    engaged.fly(0.2, Planner(higher))
    engaged.autopilot.end_fault(fault)
    engaged.fly(25.0, Planner(higher))
    assert engaged.autopilot.core.state.up == pytest.approx(higher.centre[2], abs=1.0)


def test_a_restart_of_the_autopilot_gives_command_back(engaged):
    engaged.fly(2.0)
    engaged.autopilot.restart()
    engaged.fly(3.0)
    assert not engaged.link.engaged
    assert engaged.link.values()["restarts"] == 1


def test_a_wire_that_is_opened_anew_keeps_neither_commands_nor_the_pilot_waiting(engaged):
    link, wire = engaged.link, engaged.link.heard.connection
    opening, opened = threading.Event(), threading.Event()

    def slow():
        opening.set()
        opened.wait(PATIENCE)
        raise LinkError("not there")

    def answer():
        link.command(link.now(), TURN, STEP, ORBIT)
        link.disengage()
        return link.engaged

    wire.open = slow
    wire._drop()
    with ThreadPoolExecutor(2) as pool:
        reading = pool.submit(link.measured, 1.0)
        assert opening.wait(PATIENCE)
        assert not pool.submit(answer).result(PATIENCE)
        link.close()
        opened.set()
        assert isinstance(reading.exception(PATIENCE), LinkError | None)  # it is closed


def test_a_fence_becomes_the_controllers():
    fence = {"FENCE_ENABLE": 1, "FENCE_TYPE": 10, "FENCE_RADIUS": 800, "FENCE_ALT_MIN": 40}
    envelope = flight("ardupilot", **fence).link.inspect().envelope
    assert envelope["fence_radius"] == 790.0
    assert envelope["fence_centre"] == pytest.approx((0.0, 0.0), abs=0.1)
    assert envelope["height_min"] == pytest.approx(50.0, abs=0.1)


def test_command_is_not_taken_from_every_mode():
    flown = flight("ardupilot")
    for mode in ("MANUAL", "FBWA", "RTL", "TAKEOFF"):
        flown.autopilot.pilot_mode(mode)
        flown.fly(0.2)
        assert f"mode is {mode}, must be one of" in flown.engage()


@pytest.mark.parametrize(
    ("kind", "maker", "words"),
    [
        (mavlink.MAV_TYPE_QUADROTOR, mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA, "is a QUADROTOR"),
        (mavlink.MAV_TYPE_FIXED_WING, mavlink.MAV_AUTOPILOT_PX4, "is PX4, must be ARDUPILOTMEGA"),
    ],
)
def test_another_vehicle_is_refused(kind, maker, words):
    autopilot = SteppedAutopilot("ardupilot", load_configuration("small_uav"))
    send = autopilot.radio.send

    def other(message):
        if message.get_type() == "HEARTBEAT":
            message.type, message.autopilot = kind, maker
        send(message)

    autopilot.radio.send = other
    link = ArduPilotLink(parameters=LinkParameters(), connection=autopilot.connection)
    with pytest.raises(LinkRefusedError, match=words):
        link.connect(5.0)


def test_nobody_there_is_said_with_the_place_and_the_time():
    with pytest.raises(LinkError, match=r"no autopilot answers at 'udpin:127.0.0.1:\d+' within"):
        ArduPilotLink("udpin:127.0.0.1:14687").connect(0.3)


NEW = {
    "ROLL_LIMIT_DEG": 45.0,
    "AIRSPEED_MIN": 12.0,
    "AIRSPEED_MAX": 28.0,
    "AIRSPEED_CRUISE": 20.0,
    "TECS_CLMB_MAX": 5.0,
    "TECS_SINK_MIN": 2.0,
    "TECS_SINK_MAX": 4.0,
    "TECS_TIME_CONST": 5.0,
    "RLL2SRV_RMAX": 60.0,
}
OLD = {
    "LIM_ROLL_CD": 4500.0,
    "ARSPD_FBW_MIN": 12.0,
    "ARSPD_FBW_MAX": 28.0,
    "TRIM_ARSPD_CM": 2000.0,
    **{name: NEW[name] for name in NEW if name.startswith(("TECS", "RLL"))},
}


def test_old_and_new_names_mean_the_same():
    new, old = ArduPlaneEnvelope(NEW, 1.05), ArduPlaneEnvelope(OLD, 1.05)
    assert new.values(20.0) == old.values(20.0)
    assert new.cruise == pytest.approx(old.cruise) == pytest.approx(21.0)

    values = new.values(21.0)
    assert values["bank_max"] == pytest.approx(math.radians(45.0) - BANK_KEPT)
    assert (values["airspeed_min"], values["airspeed_max"]) == pytest.approx((12.6, 29.4))
    assert math.sin(values["path_angle_max"]) * 21.0 == pytest.approx(5.0)
    assert math.sin(values["path_angle_min"]) * 21.0 == pytest.approx(-4.0)
    assert values["roll_rate_max"] < math.radians(60.0)


@pytest.mark.parametrize(
    ("airspeed", "prevention", "bank"),
    [(13.0, 1.0, 31.6), (15.0, 1.0, 45.0), (12.0, 1.0, 25.0), (13.0, 0.0, 45.0)],
)
def test_near_the_stall_the_bank_is_less_where_stalls_are_prevented(airspeed, prevention, bank):
    envelope = ArduPlaneEnvelope({**NEW, "STALL_PREVENTION": prevention}, 1.0)
    assert math.degrees(envelope.bank_max(airspeed)) == pytest.approx(bank, abs=0.1)


def test_what_cannot_be_read_is_not_made_up():
    envelope = ArduPlaneEnvelope({}, 1.0)
    assert (envelope.values(20.0), envelope.bank_max(20.0), envelope.cruise) == ({}, None, None)


def test_a_fence_has_the_kinds_that_are_switched_on():
    fence = {"FENCE_ENABLE": 1.0, "FENCE_ALT_MAX": 150.0, "FENCE_ALT_MIN": 20.0}
    fence["FENCE_RADIUS"] = 900.0
    circle = ArduPlaneEnvelope({**fence, "FENCE_TYPE": 2.0}, 1.0).fence()
    assert circle == (-math.inf, math.inf, 890.0)
    assert ArduPlaneEnvelope({**fence, "FENCE_TYPE": 11.0}, 1.0).fence() == (30.0, 140.0, 890.0)
    fence |= {"FENCE_ENABLE": 0.0, "FENCE_TYPE": 2.0}
    assert ArduPlaneEnvelope(fence, 1.0).fence() is None
    assert ArduPlaneEnvelope({**fence, "FENCE_AUTOENABLE": 3.0}, 1.0).fence() == circle


def test_the_pilot_is_told_what_matters():
    doubtful = {"FENCE_ENABLE": 1.0, "FENCE_ACTION": 6.0, "STICK_MIXING": 1.0}
    doubtful.update({"SCHED_LOOP_RATE": 50.0, "GUIDED_TIMEOUT": 0.0})
    words = " ".join(ArduPlaneEnvelope(doubtful, 1.0).warnings(50.0))
    for name in ("FENCE_ACTION is 6", "STICK_MIXING", "comes at 40 Hz", "GUIDED_TIMEOUT is 0"):
        assert name in words
