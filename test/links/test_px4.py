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
from stepped_flight import Nobody, engaged_flight, flight

from uav_tracking_mpc.dynamics.air import GRAVITY
from uav_tracking_mpc.links.px4 import INERT_TIME, NAMES, NO_RATES, Px4Envelope, Px4Link
from uav_tracking_mpc.settings.link import LinkParameters

HOLD = "LOITER"  # as the simulated autopilot calls it


@pytest.fixture
def engaged():
    return engaged_flight("px4")


@pytest.mark.parametrize(
    ("custom_mode", "name"),
    [(0, "number 0.0"), (6 << 16, "OFFBOARD"), (4 << 16 | 3 << 24, "HOLD"), (1 << 16, "MANUAL")],
)
def test_modes_have_names(custom_mode, name):
    assert Px4Link().mode_name(custom_mode) == name
    assert Px4Link().takes_commands(custom_mode) == (name == "OFFBOARD")


def test_inert_set_points_stream_before_offboard_is_asked_for():
    flown = flight("px4")
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


def test_after_a_take_over_it_can_be_engaged_again(engaged):
    engaged.autopilot.pilot_mode("POSCTL")
    engaged.fly(1.0)
    assert engaged.engage() == ""
    assert engaged.autopilot.core.mode == "OFFBOARD"


def test_a_controller_that_dies_ends_in_the_failsafe_and_nothing_streams_after_it(engaged):
    engaged.fly(8.0, Nobody())  # to the end of the last plan, and on
    assert (engaged.autopilot.core.mode, engaged.autopilot.core.failsafe) == (HOLD, True)
    at = engaged.time
    engaged.fly(3.0)
    assert not engaged.sent_after(at)
    assert engaged.autopilot.core.mode == HOLD


@pytest.mark.parametrize("phase", [0.1, 0.4, 0.7])  # of the heartbeat: it may be heard first
def test_a_companion_that_stood_still_goes_on_whatever_it_hears_first(phase):
    flown = flight("px4", COM_OF_LOSS_T=0.5)
    assert flown.engage() == ""
    flown.fly(1.0 + phase)
    for _ in range(500):
        flown.autopilot.tick()
    assert flown.autopilot.core.mode == HOLD
    flown.fly(3.0)
    assert (flown.autopilot.core.mode, flown.link.engaged) == ("OFFBOARD", True)


def test_a_pilot_who_took_over_while_the_link_was_dead_keeps_it(engaged):
    fault = engaged.autopilot.begin_fault("silence")
    engaged.fly(3.0)
    engaged.autopilot.pilot_mode("POSCTL")
    engaged.autopilot.end_fault(fault)
    engaged.fly(3.0)
    assert (engaged.autopilot.core.mode, engaged.link.engaged) == ("POSCTL", False)


def test_telemetry_that_stops_is_not_flown_by(engaged):
    engaged.fly(2.0)
    engaged.autopilot.begin_fault("mute")
    at = engaged.time
    engaged.fly(6.0)
    assert not engaged.sent_after(at + 1.2)
    assert engaged.autopilot.core.mode == HOLD


def test_a_pilot_may_engage_by_mode_where_that_is_asked_for():
    flown = flight("px4", link=LinkParameters(link="px4", engage_on_mode=True))
    flown.fly(2.0)
    assert flown.sent  # inert, so that OFFBOARD is there to be switched to
    assert flown.autopilot.pilot_mode("OFFBOARD")
    flown.fly(1.5)
    assert flown.link.engaged
    flown.autopilot.pilot_mode("POSCTL")
    flown.fly(1.5)
    assert (flown.autopilot.core.mode, flown.link.engaged) == ("POSCTL", False)


GOOD = {
    "FW_R_LIM": 50.0, "FW_AIRSPD_MIN": 14.0, "FW_AIRSPD_TRIM": 22.0, "FW_AIRSPD_MAX": 30.0,
    "FW_T_CLMB_MAX": 5.0, "FW_T_SINK_MAX": 5.0, "FW_T_SINK_MIN": 2.0, "FW_R_RMAX": 70.0,
    "COM_OF_LOSS_T": 1.0, "COM_OBL_RC_ACT": 5.0, "COM_RCL_EXCEPT": 0.0, "NAV_DLL_ACT": 0.0,
    "NAV_RCL_ACT": 2.0, "MAV_TYPE": 1.0, "MAV_FWDEXTSP": 1.0, "GF_ACTION": 2.0,
    "GF_MAX_HOR_DIST": 1000.0, "GF_MAX_VER_DIST": 300.0, "FW_USE_AIRSPD": 1.0,
}  # fmt: skip


def envelope(ratio=1.0, without=(), **changed):
    vehicle = {name: value for name, value in {**GOOD, **changed}.items() if name not in without}
    return Px4Envelope(vehicle, ratio)


def test_airspeeds_are_true_and_limits_those_of_the_autopilot():
    values = envelope(ratio=1.1).values(24.2)
    assert (values["airspeed_min"], values["airspeed_max"]) == pytest.approx((15.4, 33.0))
    assert values["path_angle_max"] == pytest.approx(math.asin(5.0 / 24.2))
    assert values["path_angle_min"] == -values["path_angle_max"]
    assert values["bank_max"] == pytest.approx(math.radians(48.0))
    assert values["roll_rate_max"] == pytest.approx(0.9 * math.radians(70.0))
    assert values["pitch_rate_max"] == pytest.approx(7.0 / 24.2)

    values = envelope().values(22.0)  # the force is that of climb and sink at cruise
    assert values["force_max"][0] == pytest.approx(GRAVITY * 5.0 / 22.0)
    assert values["force_min"] == pytest.approx((-GRAVITY * 2.0 / 22.0,) * 2)
    assert 0.0 < values["force_max"][1] < values["force_max"][0]


def test_bank_leaves_the_airspeed_that_its_load_factor_needs():
    """FW_AIRSPD_MIN sqrt(n) = 18 m/s at n = 1 / cos(bank) = (18 / 14)^2."""
    banks = [envelope().bank_max(airspeed) for airspeed in (18.0, 16.0, 14.0)]
    kept = math.radians(50.0), math.acos((14.0 / 16.0) ** 2), math.radians(25.0)
    assert banks == pytest.approx(kept)
    assert envelope(without=["FW_R_LIM"]).bank_max(22.0) is None


def test_the_law_gets_what_px4_itself_goes_by():
    limits = envelope(FW_P_LIM_MAX=20.0, FW_THR_TRIM=0.5, FW_THR_SLEW_MAX=0.3).energy_limits()
    assert limits.pitch_max == pytest.approx(math.radians(20.0))
    assert (limits.trim, limits.thrust_slew, limits.cruise) == (0.5, 0.3, 22.0)
    assert envelope().energy_limits().thrust_slew > 0.0


def test_the_fence_has_a_margin_and_ends_with_its_action():
    assert envelope().fence() == (-math.inf, 290.0, 990.0)
    assert envelope(GF_MAX_VER_DIST=0.0).fence() == (-math.inf, math.inf, 990.0)
    for none in ({"GF_ACTION": 0.0}, {"GF_MAX_VER_DIST": 0.0, "GF_MAX_HOR_DIST": 0.0}):
        assert envelope(**none).fence() is None


def test_a_good_vehicle_is_neither_refused_nor_warned_of():
    assert (envelope().refusals(), envelope().warnings(50.0)) == ([], [])
    assert all(len(name) <= 16 for name in NAMES)


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"COM_OBL_RC_ACT": 0.0}, r"COM_OBL_RC_ACT is 0 \(Position\).*5 \(Hold\) or 3 \(Return\)"),
        ({"COM_OBL_RC_ACT": 4.0}, "COM_OBL_RC_ACT is 4 .Land."),
        ({"COM_OBL_RC_ACT": 6.0}, "COM_OBL_RC_ACT is 6 .Terminate."),
        ({"COM_OBL_RC_ACT": 7.0}, "COM_OBL_RC_ACT is 7 .Disarm."),
        ({"COM_OF_LOSS_T": 30.0}, "COM_OF_LOSS_T is 30 s.*from 0.3 to 5 s"),
        ({"COM_OF_LOSS_T": 0.0}, "COM_OF_LOSS_T is 0 s"),
        ({"MAV_TYPE": 0.0}, "MAV_TYPE is 0.*must be 1"),
        ({"MAV_TYPE": 2.0}, "MAV_TYPE is 2"),
        ({"MAV_FWDEXTSP": 0.0}, "MAV_FWDEXTSP is 0.*must be 1"),
        ({"FW_THR_TRIM": 1.0}, "FW_THR_TRIM is 1, must be between"),
        ({"FW_AIRSPD_TRIM": 12.0}, "FW_AIRSPD_TRIM is 12 m/s, must be between"),
    ],
)
def test_what_does_not_fit_is_refused_by_name_and_value(changed, words):
    (refusal,) = envelope(**changed).refusals()
    assert re.search(words, refusal)


def test_what_cannot_be_read_is_refused_where_it_is_needed_and_warned_of_where_not():
    assert envelope(without=["FW_R_LIM"]).refusals() == ["FW_R_LIM cannot be read"]
    warnings = envelope(without=["COM_OBL_RC_ACT"]).warnings(50.0)
    assert any("COM_OBL_RC_ACT cannot be read" in words for words in warnings)


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"COM_RCL_EXCEPT": 4.0}, "COM_RCL_EXCEPT is 4"),
        ({"NAV_RCL_ACT": 5.0}, "NAV_RCL_ACT is 5: the loss of the transmitter terminates"),
        ({"NAV_DLL_ACT": 2.0}, "NAV_DLL_ACT is 2: OFFBOARD ends 10 s"),
        ({"GF_ACTION": 4.0}, "GF_ACTION is 4"),
        ({"GF_ACTION": 0.0}, "no fence"),
        ({"FW_USE_AIRSPD": 0.0}, "FW_USE_AIRSPD is 0"),
        ({"MAV_SIGN_CFG": 2.0}, "MAV_SIGN_CFG"),
    ],
)
def test_what_a_pilot_should_know_is_said(changed, words):
    assert envelope(**changed).refusals() == []
    (warning,) = envelope(**changed).warnings(50.0)
    assert words in warning
