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

"""The link to PX4, flown against the simulated one over its wire, in simulated time."""

import math
import re

import numpy as np
import pytest
from stepped_flight import ByController, Nobody, SteppedFlight

from uav_tracking_mpc.links.mavlink.px4_envelope import Px4Envelope
from uav_tracking_mpc.links.px4 import INERT_TIME, NO_RATES, Px4Link, main_and_sub
from uav_tracking_mpc.settings.link import LinkParameters

HOLD = "LOITER"  # as the simulated autopilot calls it
NOTICE = 0.15  # s: CURRENT_MODE comes ten times a second


def flight(**changed):
    return SteppedFlight("px4", **{"COM_OBL_RC_ACT": 5, **changed})


@pytest.fixture
def engaged():
    flown = flight()
    assert flown.engage() == ""
    return flown


@pytest.mark.parametrize(
    "custom_mode", [0, 1 << 16, 6 << 16, 4 << 16 | 3 << 24, 4 << 16 | 99 << 24]
)
def test_modes_have_names(custom_mode):
    link = Px4Link()
    assert link.mode_name(custom_mode)
    assert link.takes_commands(custom_mode) == (main_and_sub(custom_mode)[0] == 6)


def test_nothing_is_sent_unless_somebody_engages():
    flown = flight()
    flown.fly(2.0)
    assert flown.sent == []
    assert flown.autopilot.core.mode == HOLD


def test_inert_set_points_stream_before_offboard_is_asked_for():
    flown = flight()
    core, modes = flown.autopilot.core, []
    take = core.set_mode
    core.set_mode = lambda mode: modes.append((flown.time, mode)) or take(mode)
    flown.fly(0.5)
    up = core.state.up
    assert flown.link.engage() == ""
    asked_at = flown.time
    flown.fly(4.0)
    assert [mode for _, mode in modes] == ["OFFBOARD"]
    at = modes[0][0]
    inert = [(time, target) for time, target in flown.sent if time < at]
    times = np.array([time for time, _ in inert])
    assert at - times[0] >= 1.0
    assert times[0] - asked_at < 0.1
    assert np.diff(times).max() <= 0.04  # 25 Hz
    assert all(target.mask == NO_RATES for _, target in inert)
    assert all(0.2 < target.thrust <= 1.0 for _, target in inert)
    assert INERT_TIME <= at - asked_at < INERT_TIME + 1.1
    assert abs(core.state.up - up) < 5.0


@pytest.mark.parametrize("scenario", ["wind", "crosswind"])
def test_it_circles_in_wind_and_about_a_moving_target(scenario):
    flown = flight(scenario=scenario)
    controller = ByController(flown)
    assert flown.engage(controller) == ""
    begin = flown.time
    flown.fly(35.0, controller)
    distance, height, roll_rate = controller.since(begin + 25.0)
    assert distance < 0.3
    assert height < 1.0
    assert roll_rate < 5.0
    assert flown.link.values()["commands refused"] == 0


def test_a_nose_that_shakes_does_not_shake_the_bank():
    """The bank went as quickly as it may from one set-point to the next, by 1.2 deg."""
    flown = flight()
    flown.shake(0.3, 0.0)
    controller = ByController(flown)
    assert flown.engage(controller) == ""
    begin = flown.time
    flown.fly(35.0, controller)
    banks = np.degrees([target.roll for time, target in flown.sent if time > begin + 25.0])
    assert np.sqrt(np.mean(np.diff(banks) ** 2)) < 0.3
    assert controller.since(begin + 25.0)[0] < 0.3


def test_its_small_airplane_circles_by_its_own_configuration():
    near = [
        "uav_simulator.initial_position=[170.0, 0.0, 98.0]",
        "uav_simulator.initial_heading=1.6",
    ]
    flown = flight(scenario=None, config="px4_uav", near=near)
    controller = ByController(flown)
    assert flown.engage(controller) == ""
    begin = flown.time
    flown.fly(35.0, controller)
    distance, height, _ = controller.since(begin + 25.0)
    assert distance < 0.3
    assert height < 1.0


def test_what_is_sent_keeps_to_the_limits(engaged):
    engaged.fly(10.0)
    envelope = Px4Envelope(engaged.link.vehicle, 1.06)
    limits = envelope.energy_limits()
    bank = math.radians(engaged.link.vehicle["FW_R_LIM"])
    for (time, target), (later, following) in zip(engaged.sent, engaged.sent[1:], strict=False):
        assert abs(target.roll) <= bank
        assert limits.pitch_min <= target.pitch <= limits.pitch_max
        assert limits.thrust_min <= target.thrust <= limits.thrust_max
        reach = envelope.roll_slew * (later - time + 0.03) + 0.05
        assert abs(following.roll - target.roll) <= reach


@pytest.mark.parametrize("mode", ["POSCTL", "MANUAL", "RTL", HOLD])
def test_a_pilot_takes_over_within_one_message_and_for_good(engaged, mode):
    engaged.fly(2.0)
    assert engaged.autopilot.pilot_mode(mode)
    taken = engaged.time
    engaged.fly(3.0)
    assert not engaged.link.engaged
    assert not engaged.sent_after(taken + NOTICE)
    assert not engaged.autopilot.pilot_mode("OFFBOARD")  # there is no stream that it could fly
    engaged.fly(3.0)
    assert not engaged.sent_after(taken + NOTICE)
    assert any("took over" in words for words in engaged.words)


def test_after_a_take_over_it_can_be_engaged_again(engaged):
    engaged.autopilot.pilot_mode("POSCTL")
    engaged.fly(1.0)
    assert engaged.engage() == ""
    assert engaged.autopilot.core.mode == "OFFBOARD"


def test_giving_command_back_is_a_hold(engaged):
    engaged.link.disengage()
    at = engaged.time
    engaged.fly(1.0)
    assert engaged.autopilot.core.mode == HOLD
    assert not engaged.autopilot.core.failsafe
    assert not engaged.sent_after(at + 0.02)  # one may be under way


def test_a_controller_that_dies_ends_in_the_failsafe_and_nothing_streams_after_it(engaged):
    engaged.fly(8.0, Nobody())  # to the end of the last plan, and on
    assert engaged.autopilot.core.mode == HOLD
    assert engaged.autopilot.core.failsafe
    at = engaged.time
    engaged.fly(4.0)
    assert not engaged.sent_after(at)
    assert engaged.autopilot.core.mode == HOLD


def test_a_dead_link_is_taken_up_again(engaged):
    engaged.fly(5.0)
    fault = engaged.autopilot.begin_fault("silence")
    engaged.fly(5.0)
    assert engaged.autopilot.core.mode == HOLD
    engaged.autopilot.end_fault(fault)
    engaged.fly(3.0)
    assert engaged.autopilot.core.mode == "OFFBOARD"
    assert engaged.link.engaged


def test_a_pilot_who_took_over_while_the_link_was_dead_keeps_it(engaged):
    fault = engaged.autopilot.begin_fault("silence")
    engaged.fly(3.0)
    engaged.autopilot.pilot_mode("POSCTL")
    engaged.autopilot.end_fault(fault)
    engaged.fly(5.0)
    assert engaged.autopilot.core.mode == "POSCTL"
    assert not engaged.link.engaged


def test_telemetry_that_stops_is_not_flown_by(engaged):
    engaged.fly(2.0)
    engaged.autopilot.begin_fault("mute")
    at = engaged.time
    engaged.fly(6.0)
    assert not engaged.sent_after(at + 1.2)
    assert engaged.autopilot.core.mode == HOLD


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"COM_OBL_RC_ACT": 0}, "COM_OBL_RC_ACT is 0 .Position."),
        ({"COM_OF_LOSS_T": 30.0}, "COM_OF_LOSS_T is 30 s"),
        ({"MAV_FWDEXTSP": 0}, "MAV_FWDEXTSP is 0"),
        ({"GF_MAX_HOR_DIST": 250.0}, "leaves the autopilot's fence"),
        ({"GF_MAX_VER_DIST": 100.0}, "not inside the autopilot's fence"),
    ],
)
def test_what_does_not_fit_is_refused(changed, words):
    flown = flight(**changed)
    assert re.search(words, flown.engage())
    assert flown.sent == []


def test_a_pilot_may_engage_by_mode_where_that_is_asked_for():
    flown = flight(link=LinkParameters(link="px4", engage_on_mode=True))
    flown.fly(2.0)
    assert flown.sent  # inert, so that OFFBOARD is there to be switched to
    assert flown.autopilot.pilot_mode("OFFBOARD")
    flown.fly(1.5)
    assert flown.link.engaged
    flown.autopilot.pilot_mode("POSCTL")
    flown.fly(1.5)
    assert not flown.link.engaged
    assert flown.autopilot.core.mode == "POSCTL"
