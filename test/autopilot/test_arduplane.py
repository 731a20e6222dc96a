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

"""The simulated ArduPlane behaves as the sources of the real one say."""

import math

import numpy as np
import pytest
from autopilot_steps import autopilot, bank, banks, fly, off_circle, place

from uav_tracking_mpc.autopilot.arduplane import ArduPlane
from uav_tracking_mpc.autopilot.autopilot_core import (
    BaseMode,
    Cmd,
    Frame,
    Order,
    Result,
    SystemState,
)

REPOSITION = Cmd.DO_REPOSITION


@pytest.fixture
def core():
    """In GUIDED."""
    core = autopilot(ArduPlane)
    assert core.command(Order(Cmd.DO_SET_MODE, 1.0, 15.0)) == Result.ACCEPTED
    return core


def test_it_begins_in_a_loiter_about_its_start_at_its_height_and_speed():
    core = autopilot(ArduPlane)
    start, states = core.state, fly(core, 40.0)
    assert (core.mode, core.armed, core.system_state) == ("LOITER", True, SystemState.ACTIVE)
    radius = core.parameters["WP_LOITER_RAD"]
    assert off_circle(states[-1500:], radius, start.east, start.north) < 1.0
    assert np.ptp([state.up for state in states]) < 0.5
    assert states[-1].airspeed == pytest.approx(22.0, abs=0.2)
    assert np.all(banks(states[-1500:]) > 10.0)  # WP_LOITER_RAD is positive: clockwise


def test_the_bank_is_taken_in_guided_alone_and_altitude_and_airspeed_are_held_meanwhile():
    core = autopilot(ArduPlane)
    core.attitude_target(bank(-30.0))
    assert min(banks(fly(core, 1.0))) > -1.0
    core.set_mode("GUIDED")
    nothing = bank(-30.0, 0xFF)  # all is left out
    assert min(banks(fly(core, 1.0, lambda: core.attitude_target(nothing)))) > -1.0
    states = fly(core, 20.0, lambda: core.attitude_target(bank(-30.0)))
    assert banks(states[-1000:]) == pytest.approx(-30.0, abs=0.1)
    turning = (states[-1].heading - states[-2].heading) / 0.01
    assert turning == pytest.approx(9.80665 * math.tan(math.radians(30.0)) / 22.0, rel=0.01)
    assert max(abs(state.up - 100.0) for state in states) < 0.5
    assert states[-1].airspeed == pytest.approx(22.0, abs=0.1)


@pytest.mark.parametrize(("timeout", "off"), [(3.0, 0.5), (1.0, 3.0)])  # by default; as it is set
def test_a_forced_bank_is_forgotten_after_its_time_and_the_guided_point_circled(core, timeout, off):
    if timeout != core.parameters["GUIDED_TIMEOUT"]:
        assert core.parameters.set("GUIDED_TIMEOUT", timeout)
    start, radius = core.state, core.parameters["WP_LOITER_RAD"]
    fly(core, 1.0, lambda: core.attitude_target(bank(-20.0)))
    assert banks(fly(core, timeout - 0.1))[-1] == pytest.approx(-20.0, abs=off)
    assert abs(banks(fly(core, 1.5))[-1] + 20.0) > 5.0
    assert off_circle(fly(core, 40.0)[-800:], radius, start.east, start.north) < 2.0


@pytest.mark.parametrize(
    ("mask", "pitched", "driven"),
    [
        (0b11111110, False, False),  # roll alone
        (0b11111100, True, False),
        (0b10111110, False, True),  # with throttle
        (0b01111111, True, False),  # an attitude that is not left out forces all axes
        (0b00000110, True, True),
    ],
)
def test_bits_of_the_mask_leave_parts_out_as_the_real_one_takes_them(core, mask, pitched, driven):
    nose = math.radians(10.0)
    states = fly(core, 4.0, lambda: core.attitude_target(bank(20.0, mask, nose, thrust=0.1)))
    assert banks(states)[-1] == pytest.approx(20.0, abs=1.0)
    assert (states[-1].up > 105.0) == pitched
    assert (states[-1].airspeed < 21.0) == driven


def test_the_bank_is_limited_and_its_rate_too(core):
    core.parameters.set("ROLL_LIMIT_DEG", 35.0)
    core.parameters.set("RLL2SRV_RMAX", 30)
    roll = banks(fly(core, 6.0, lambda: core.attitude_target(bank(80.0))))
    assert roll[-1] == pytest.approx(35.0 * math.cos(core.state.pitch), abs=0.2)
    assert np.max(np.diff(roll)) / 0.01 < 31.0


def test_near_the_least_airspeed_the_load_factor_limits_the_bank(core):
    core.parameters.set("AIRSPEED_MIN", 19.0)
    equivalent = 22.0 / core.density_factor
    limit = math.degrees(math.acos((19.0 / equivalent) ** 2))
    assert limit < 45.0
    assert math.degrees(core.roll_response.limit) == pytest.approx(max(limit, 25.0), abs=0.1)


def test_guided_altitude_and_speed_are_held_with_their_refusals(core):
    altitude = Order(Cmd.GUIDED_CHANGE_ALTITUDE, z=488.0 + 140.0, frame=Frame.GLOBAL)
    speed = Order(Cmd.GUIDED_CHANGE_SPEED, 0.0, 26.0)
    for order, result in (
        (altitude, Result.ACCEPTED),
        (speed, Result.ACCEPTED),
        (altitude._replace(z=0.0), Result.DENIED),
        (altitude._replace(z=-1.0), Result.DENIED),
        (altitude._replace(frame=99), Result.DENIED),
        (speed._replace(param1=1.0), Result.DENIED),
        (speed._replace(param2=5.0), Result.FAILED),
    ):
        assert core.command(order) == result, order
    states = fly(core, 40.0)
    assert states[-1].up == pytest.approx(140.0, abs=0.5)
    assert states[-1].airspeed / core.density_factor == pytest.approx(26.0, abs=0.2)
    climb = max(state.up_rate for state in states)
    assert climb <= core.parameters["TECS_CLMB_MAX"] + 0.01
    core.set_mode("LOITER")
    assert [core.command(order) for order in (altitude, speed)] == [Result.FAILED] * 2
    assert fly(core, 20.0)[-1].airspeed == pytest.approx(22.0, abs=0.3)  # forgotten


@pytest.mark.parametrize(("yaw", "sense"), [(1.0, -1.0), (math.nan, 1.0)])
def test_a_reposition_is_circled_at_its_radius_in_its_direction(yaw, sense):
    core = autopilot(ArduPlane, "uav_simulator.initial_position=[200.0, 0.0, 100.0]")
    order = Order(REPOSITION, 0.0, 0.0, 150.0, yaw, *place(0.0, 0.0), 100.0)
    assert core.command(order) == Result.FAILED  # neither in GUIDED nor asked to change to it
    assert core.command(order._replace(param2=1.0)) == Result.ACCEPTED
    assert core.mode == "GUIDED"
    states = fly(core, 45.0)
    assert off_circle(states[-1000:], 150.0) < 2.0
    assert np.all(sense * banks(states[-1000:]) > 10.0)


def test_a_reposition_stops_no_forced_bank_and_yields_to_the_guided_altitude(core):
    core.command(Order(Cmd.GUIDED_CHANGE_ALTITUDE, z=110.0))
    order = Order(REPOSITION, 0.0, 1.0, 150.0, 1.0, *place(0.0, 0.0), 90.0)

    def told():
        core.attitude_target(bank(15.0))
        if round(core.time / 0.01) % 200 == 0:
            assert core.command(order) == Result.ACCEPTED

    states = fly(core, 30.0, told)
    assert banks(states[-1000:]) == pytest.approx(15.0, abs=0.2)
    assert states[-1].up == pytest.approx(110.0, abs=0.5)


@pytest.mark.parametrize(
    "change", [{"x": 91.0}, {"y": 181.0}, {"x": 0.0, "y": 0.0}, {"x": math.nan}, {"frame": 10}]
)
def test_a_place_that_is_none_is_denied(core, change):
    order = Order(REPOSITION, 0.0, 1.0, 150.0, 0.0, *place(0.0, 0.0), 100.0)
    assert core.command(order._replace(**change)) == Result.DENIED


def test_return_leads_home_and_a_pilot_may_take_any_mode(core):
    assert core.command(Order(Cmd.NAV_RETURN_TO_LAUNCH)) == Result.ACCEPTED
    assert off_circle(fly(core, 50.0)[-800:], core.parameters["WP_LOITER_RAD"]) < 2.0
    assert core.set_mode("FBWA")
    assert abs(banks(fly(core, 5.0))[-1]) < 0.5
    kinds = BaseMode.STABILIZE_ENABLED | BaseMode.GUIDED_ENABLED
    assert core.base_mode & kinds == BaseMode.STABILIZE_ENABLED


def test_modes_that_cannot_be_flown_are_refused_with_a_text():
    core = autopilot(ArduPlane)
    orders = Order(Cmd.DO_SET_MODE, 1.0, 10.0), Order(Cmd.DO_SET_MODE, 0.0, 15.0), Order(31999)
    results = [core.command(order) for order in orders]  # AUTO: no mission; no custom mode
    assert results == [Result.FAILED, Result.DENIED, Result.UNSUPPORTED]
    assert (core.mode, core.texts) == ("LOITER", [(5, "Mode 10 cannot be flown here")])


def test_the_loss_of_the_ground_station_counts_where_it_is_enabled(core):
    core.heard_heartbeat(255, ground_station=True)
    fly(core, 6.0)
    assert (core.mode, core.failsafe) == ("GUIDED", False)  # by default it changes nothing
    core.restart()
    core.set_mode("GUIDED")
    core.parameters.set("FS_GCS_ENABL", 1)
    core.parameters.set("FS_LONG_ACTN", 1)
    fly(core, 6.0)
    assert core.mode == "GUIDED"  # it was never there
    core.heard_heartbeat(7, ground_station=True)  # not SYSID_MYGCS
    fly(core, 6.0)
    core.heard_heartbeat(255, ground_station=False)
    fly(core, 4.9)
    assert core.mode == "GUIDED"
    fly(core, 0.2)
    assert (core.mode, core.system_state) == ("RTL", SystemState.CRITICAL)
    core.heard_heartbeat(255, ground_station=True)
    fly(core, 0.1)
    assert (core.mode, core.failsafe) == ("RTL", False)  # until somebody changes it


def test_on_the_runway_it_stands_disarmed_then_runs_climbs_straight_on_and_loiters():
    core = autopilot(ArduPlane, on_runway=True)
    assert (core.armed, core.system_state) == (False, SystemState.STANDBY)
    core.set_mode("GUIDED")
    states = fly(core, 5.0, lambda: core.attitude_target(bank(30.0)))
    assert (states[-1].roll, states[-1].up, states[-1].groundspeed) == (0.0, 0.0, 0.0)
    assert core.command(Order(Cmd.NAV_TAKEOFF, z=50.0)) == Result.FAILED  # as without rotors
    core.set_mode("TAKEOFF")
    assert core.command(Order(Cmd.COMPONENT_ARM_DISARM, 1.0)) == Result.ACCEPTED
    states = fly(core, 40.0)
    airborne = [state for state in states if 0.5 < state.up < 9.5]
    assert max(abs(state.roll) for state in airborne) < math.radians(5.5)
    assert states[-1].up == pytest.approx(core.parameters["TKOFF_ALT"], abs=0.5)
    assert core.command(Order(Cmd.COMPONENT_ARM_DISARM, 0.0)) == Result.FAILED  # in flight


def test_wind_moves_it_over_ground_and_its_loiter_stays():
    core = autopilot(ArduPlane, "uav_simulator.wind=[0.0, 8.0, 0.0]")
    start, states = core.state, fly(core, 55.0)[-2500:]
    radius = core.parameters["WP_LOITER_RAD"]
    assert off_circle(states, radius, start.east, start.north) < 15.0
    assert max(state.groundspeed for state in states) == pytest.approx(30.0, abs=0.3)
    assert core.airframe.wind == pytest.approx((0.0, 8.0, 0.0))


def test_a_restart_begins_clock_parameters_and_mode_again_and_flies_on(core):
    core.parameters.set("ROLL_LIMIT_DEG", 20.0)
    fly(core, 5.0)
    before = core.state
    core.restart()
    assert core.state == before
    assert core.time + core.clock_offset == pytest.approx(0.0)
    assert (core.mode, core.parameters["ROLL_LIMIT_DEG"]) == ("LOITER", 45.0)
