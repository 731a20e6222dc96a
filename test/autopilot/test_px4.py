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

"""The simulated PX4 behaves as the sources of the real one say."""

import math

import numpy as np
import pytest
from autopilot_steps import autopilot, bank, banks, fly, off_circle, place

from uav_tracking_mpc.autopilot.autopilot_core import BaseMode, Cmd, Order, Result, SystemState
from uav_tracking_mpc.autopilot.px4 import Px4

RATES_IGNORED = 0b111  # attitude and thrust are taken
OFFBOARD = Order(Cmd.DO_SET_MODE, 1.0, 6.0)


def level(core, roll=0.0, mask=RATES_IGNORED):
    """Set-point of level flight at cruise."""
    pitch = core.airframe.incidence(core.state.airspeed, math.radians(roll))
    return bank(roll, mask, pitch, core.engine.trim)


def offboard(*overrides, **parameters):
    core = autopilot(Px4, *overrides)
    for name, value in parameters.items():
        assert core.parameters.set(name, value)
    fly(core, 1.0, lambda: core.attitude_target(level(core)))
    assert core.command(OFFBOARD) == Result.ACCEPTED
    return core


def test_numbers_of_modes_are_those_of_the_real_one():
    """px4_custom_mode.h."""
    assert {name: number for name, number in Px4.modes.items() if name != "MANUAL"} == {
        "ALTCTL": 131072,
        "POSCTL": 196608,
        "TAKEOFF": 33816576,
        "LOITER": 50593792,
        "RTL": 84148224,
        "OFFBOARD": 393216,
        "STABILIZED": 458752,
    }


def test_it_begins_in_hold_about_its_start():
    core = autopilot(Px4)
    start, states = core.state, fly(core, 35.0)
    assert (core.mode, core.armed) == ("LOITER", True)
    radius = core.parameters["NAV_LOITER_RAD"]
    assert off_circle(states[-1000:], radius, start.east, start.north) < 1.0


def test_offboard_is_taken_only_while_setpoints_stream():
    core = autopilot(Px4)
    results = [core.command(OFFBOARD)]
    core.attitude_target(level(core))
    fly(core, 0.6)
    core.attitude_target(level(core))  # slower than 2 Hz
    results.append(core.command(OFFBOARD))
    fly(core, 1.0, lambda: core.attitude_target(bank(0.0, 0xFF)))  # proves nothing
    assert [*results, core.command(OFFBOARD)] == [Result.TEMPORARILY_REJECTED] * 3
    assert core.mode == "LOITER"
    states = fly(core, 3.0, lambda: core.attitude_target(level(core, -40.0)))
    assert min(banks(states)) > -10.0  # what streams before is inert
    assert core.command(OFFBOARD) == Result.ACCEPTED
    assert core.mode == "OFFBOARD"
    assert not core.base_mode & BaseMode.AUTO_ENABLED


def test_attitude_and_thrust_are_flown_as_they_come():
    core = offboard()
    start = core.state
    states = fly(core, 15.0, lambda: core.attitude_target(level(core)))
    assert states[-1].up == pytest.approx(start.up, abs=1.0)
    assert states[-1].airspeed == pytest.approx(22.0, abs=0.1)
    states = fly(core, 4.0, lambda: core.attitude_target(level(core, -30.0)))
    assert banks(states)[-1] == pytest.approx(-30.0, abs=0.2)
    assert np.max(np.abs(np.diff(banks(states)))) / 0.01 <= core.parameters["FW_R_RMAX"]
    climbing = level(core)._replace(pitch=math.radians(10.0), thrust=1.0)
    states = fly(core, 4.0, lambda: core.attitude_target(climbing))
    assert states[-1].up_rate > 1.5


def test_in_offboard_no_limit_of_bank_is_kept_and_thrust_that_is_left_out_is_none():
    core = offboard(FW_R_LIM=35.0)
    states = fly(core, 3.0, lambda: core.attitude_target(level(core, 44.0, 0b01000111)))
    assert banks(states)[-1] == pytest.approx(44.0, abs=1.0)
    assert states[-1].airspeed < 21.0


def test_full_throttle_climbs_as_it_is_told_and_idle_sinks():
    core = autopilot(Px4)
    engine = core.engine
    climb, sink = engine.force(1.0, 22.0, 0.0), engine.force(0.0, 22.0, 0.0)
    assert climb * 22.0 / 9.80665 == pytest.approx(core.parameters["FW_T_CLMB_MAX"])
    assert sink * 22.0 / 9.80665 == pytest.approx(-core.parameters["FW_T_SINK_MIN"])


@pytest.mark.parametrize(("action", "mode"), [(5, "LOITER"), (3, "RTL"), (0, "RTL")])
def test_when_setpoints_stop_the_last_is_flown_then_the_failsafe(action, mode):
    core = offboard(COM_OBL_RC_ACT=action)
    fly(core, 2.0, lambda: core.attitude_target(level(core, -20.0)))
    assert banks(fly(core, 0.9))[-1] == pytest.approx(-20.0, abs=0.5)
    assert core.mode == "OFFBOARD"
    fly(core, 1.2)
    assert (core.mode, core.failsafe) == (mode, True)
    assert core.system_state == SystemState.CRITICAL
    assert core.texts == [(2, "Failsafe: Offboard control lost")]


@pytest.mark.parametrize("chosen", [False, True])
def test_offboard_goes_on_when_setpoints_come_back_unless_a_mode_was_chosen_meanwhile(chosen):
    core = offboard(COM_OBL_RC_ACT=5)
    fly(core, 2.0)
    assert core.mode == "LOITER"
    if chosen:
        assert core.set_mode("LOITER")
    fly(core, 1.0, lambda: core.attitude_target(level(core)))
    assert (core.mode, core.failsafe) == ("LOITER" if chosen else "OFFBOARD", False)


def test_a_pilot_takes_over_and_setpoints_mean_nothing_then():
    core = offboard()
    assert core.set_mode("POSCTL")
    states = fly(core, 5.0, lambda: core.attitude_target(level(core, -40.0)))
    assert (banks(states)[-1], states[-1].up) == pytest.approx((0.0, 100.0), abs=0.8)
    assert core.mode == "POSCTL"


@pytest.mark.parametrize(
    ("main", "sub", "result", "mode"),
    [
        (4, 3, Result.ACCEPTED, "LOITER"),
        (4, 5, Result.ACCEPTED, "RTL"),
        (3, 0, Result.ACCEPTED, "POSCTL"),
        (4, 4, Result.TEMPORARILY_REJECTED, "LOITER"),  # no mission
        (99, 0, Result.ACCEPTED, "LOITER"),  # unknown, acknowledged, nothing changes
    ],
)
def test_modes_are_changed_by_main_and_sub_mode(main, sub, result, mode):
    core = autopilot(Px4)
    assert core.command(Order(Cmd.DO_SET_MODE, 1.0, main, sub)) == result
    assert core.mode == mode
    packed = core.mode_order(1, Px4.modes["RTL"])
    assert core.command(packed) == Result.ACCEPTED
    assert core.mode == "RTL"


def test_a_reposition_must_ask_for_the_change_of_mode_and_tells_altitude_above_sea_level():
    core = offboard("uav_simulator.initial_position=[200.0, 0.0, 100.0]")
    order = Order(Cmd.DO_REPOSITION, -1.0, 0.0, -150.0, math.nan, *place(0.0, 0.0), 588.0, 0)
    assert core.command(order) == Result.UNSUPPORTED
    assert core.mode == "OFFBOARD"
    assert core.command(order._replace(param2=1.0)) == Result.ACCEPTED
    assert core.mode == "LOITER"
    states = fly(core, 45.0)
    assert off_circle(states[-1000:], 150.0) < 2.0
    assert np.all(banks(states[-1000:]) < -10.0)  # a negative radius is counter-clockwise
    assert states[-1].up == pytest.approx(100.0, abs=0.5)


def test_return_climbs_to_its_altitude_and_circles_home():
    core = autopilot(Px4, "uav_simulator.initial_position=[300.0, 0.0, 40.0]")
    assert core.command(Order(Cmd.NAV_RETURN_TO_LAUNCH)) == Result.ACCEPTED
    states = fly(core, 40.0)
    assert states[-1].up == pytest.approx(core.parameters["RTL_RETURN_ALT"], abs=0.5)
    assert off_circle(states[-1000:], core.parameters["RTL_LOITER_RAD"]) < 3.0


def test_the_loss_of_the_ground_station_counts_where_it_is_enabled():
    core = offboard(NAV_DLL_ACT=2)
    core.heard_heartbeat(7, ground_station=True)
    fly(core, 10.2, lambda: core.attitude_target(level(core)))
    assert (core.mode, core.failsafe) == ("RTL", True)
    fly(core, 1.0, lambda: core.attitude_target(level(core)))
    assert core.mode == "RTL"


def test_on_the_runway_it_takes_off_when_it_is_armed_and_told_to():
    core = autopilot(Px4, on_runway=True)
    fly(core, 1.0)
    assert core.system_state == SystemState.STANDBY
    assert core.command(Order(Cmd.NAV_TAKEOFF)) == Result.ACCEPTED
    assert core.command(Order(Cmd.COMPONENT_ARM_DISARM, 1.0)) == Result.ACCEPTED
    states = fly(core, 40.0)
    assert states[-1].up == pytest.approx(core.parameters["MIS_TAKEOFF_ALT"], abs=0.5)
    assert core.command(Order(Cmd.COMPONENT_ARM_DISARM, 0.0)) == Result.TEMPORARILY_REJECTED
